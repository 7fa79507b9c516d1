// The district before: the coarse buildings of the tileset, the city model that the run started from, in one grey.

import { EdgesGeometry, Group, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshLambertMaterial, Scene } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { Light } from "./light";

interface TileJson { content?: { uri: string }; transform?: number[]; children?: TileJson[] }

const GREY = new MeshLambertMaterial({ color: 0xc9c6be, side: 2 });
const LINE = new LineBasicMaterial({ color: 0x6b6862 });
const CREASE_DEG = 25;

export class Before {
  readonly scene = new Scene();
  readonly light = new Light();
  private loaded: Promise<void> | null = null;

  constructor(private readonly url: string, private readonly matrix: number[], private readonly changed: () => void) {
    this.scene.add(this.light.group);
  }

  load(): Promise<void> {
    return this.loaded ??= this.fetchAll();
  }

  private async fetchAll(): Promise<void> {
    const tileset = await (await fetch(this.url)).json() as { root: TileJson };
    const local = new Matrix4().fromArray(this.matrix).invert();
    const folder = this.url.slice(0, this.url.lastIndexOf("/") + 1);
    await Promise.all(coarsest(tileset.root, new Matrix4()).map(async ({ uri, matrix }) => {
      const { scene } = await new GLTFLoader().loadAsync(folder + uri);
      // glTF has y up, tiles have z up.
      const group = new Group();
      group.matrixAutoUpdate = false;
      group.matrix.copy(local).multiply(matrix).multiply(new Matrix4().makeRotationX(Math.PI / 2));
      scene.traverse((part) => { if (part instanceof Mesh) part.material = GREY; });
      const lines: [LineSegments, Mesh][] = [];
      scene.traverse((part) => {
        if (part instanceof Mesh) lines.push([new LineSegments(new EdgesGeometry(part.geometry, CREASE_DEG), LINE), part]);
      });
      for (const [line, part] of lines) part.add(line);
      group.add(scene);
      this.scene.add(group);
      this.changed();
    }));
  }
}

// The first tile with a content along every branch: the coarsest one.
function coarsest(tile: TileJson, above: Matrix4): { uri: string; matrix: Matrix4 }[] {
  const matrix = tile.transform ? above.clone().multiply(new Matrix4().fromArray(tile.transform)) : above;
  if (tile.content) return [{ uri: tile.content.uri, matrix }];
  return (tile.children ?? []).flatMap((child) => coarsest(child, matrix));
}
