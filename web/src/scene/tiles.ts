// The model of the run: its 3D Tiles, brought from geocentric into local coordinates.

import { TilesRenderer } from "3d-tiles-renderer/three";
import { type Material, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, MeshStandardMaterial, type Object3D, type PerspectiveCamera, Quaternion, Vector3, type WebGLRenderer } from "three";

const ERROR_PX = 12; // of the geometry on the screen, at which finer buildings are loaded
const MEMORY_BYTES = 384 * 2 ** 20;

export interface TileEvents { changed(): void; failed(url: string): void }

export class Model {
  readonly tiles: TilesRenderer;

  // `matrix` takes local metres to the tiles' coordinates, column by column.
  constructor(url: string, matrix: number[], on: TileEvents) {
    this.tiles = new TilesRenderer(url);
    this.tiles.errorTarget = ERROR_PX;
    this.tiles.lruCache.maxBytesSize = MEMORY_BYTES;
    const group = this.tiles.group;
    group.matrixAutoUpdate = false;
    group.matrix.copy(similar(new Matrix4().fromArray(matrix)).invert());
    group.matrixWorldNeedsUpdate = true;
    this.tiles.addEventListener("load-model", ({ scene }) => { soften(scene); on.changed(); });
    this.tiles.addEventListener("needs-update", () => on.changed());
    this.tiles.addEventListener("tile-visibility-change", () => on.changed());
    this.tiles.addEventListener("load-error", ({ url: missing }) => on.failed(String(missing ?? url)));
  }

  update(camera: PerspectiveCamera, renderer: WebGLRenderer): void {
    this.tiles.setCamera(camera);
    this.tiles.setResolutionFromRenderer(camera, renderer);
    camera.updateMatrixWorld();
    this.tiles.update();
  }

  get loading(): boolean {
    return this.tiles.loadProgress < 1;
  }
}

// The matrix with one scale, that of the plan: the renderer judges distances by it. Map projections stretch the
// plan by some 0.03 % and leave heights, which moves a roof by millimetres.
function similar(matrix: Matrix4): Matrix4 {
  const place = new Vector3(), turn = new Quaternion(), scale = new Vector3();
  matrix.decompose(place, turn, scale);
  return matrix.compose(place, turn, scale.setScalar((scale.x + scale.y) / 2));
}

// Pictures have their light in them already and are drawn as they are; bare faces are shaded. Nothing shines, so
// that plain materials do, whose programs are compiled and run in a fraction of the time without graphics hardware.
export function soften(scene: Object3D): void {
  const made = new Map<Material, Material>();
  scene.traverse((part) => {
    if (part instanceof Mesh && part.material instanceof MeshStandardMaterial) {
      const given = part.material;
      if (!made.has(given)) made.set(given, plain(given));
      part.material = made.get(given)!;
    }
  });
}

function plain(given: MeshStandardMaterial): Material {
  const { map, color, side, transparent, opacity, alphaTest, vertexColors, name } = given;
  const about = { map, color, side, transparent, opacity, alphaTest, vertexColors, name };
  if (map) map.anisotropy = 4;
  given.dispose();
  return map ? new MeshBasicMaterial(about) : new MeshLambertMaterial(about);
}
