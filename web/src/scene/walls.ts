// The facades in space: where to click, and their pictures where there is no model.

import {
  BufferGeometry, DoubleSide, Float32BufferAttribute, FrontSide, Group, Mesh, MeshBasicMaterial, type PerspectiveCamera,
  Raycaster, ShapeUtils, SRGBColorSpace, TextureLoader, Vector2, Vector3,
} from "three";
import type { FacadeEntry, OpeningEntry, Run, Vec3 } from "../data";

export interface Hit { facade: FacadeEntry; opening: OpeningEntry | null }

const BEFORE = 0.12; // m: the highlight lies this far before the wall
const PICTURES = 60; // textures kept at once
const SMALLEST = 90; // px on the screen: a smaller facade needs no picture

export class Walls {
  readonly group = new Group();
  private readonly meshes = new Map<string, Mesh<BufferGeometry, MeshBasicMaterial>>();
  private readonly pictures = new Map<string, Mesh<BufferGeometry, MeshBasicMaterial>>();
  private readonly loader = new TextureLoader();
  private readonly caster = new Raycaster();

  constructor(private readonly run: Run, private readonly withPictures: boolean, private readonly redraw: () => void) {
    for (const facade of run.facades) {
      const material = new MeshBasicMaterial({ color: 0x2f6fde, transparent: true, opacity: 0.28, depthWrite: false, side: FrontSide });
      const mesh = new Mesh(polygon(facade), material);
      mesh.visible = false; // it can be hit all the same
      mesh.userData["facade"] = facade;
      this.meshes.set(facade.id, mesh);
      this.group.add(mesh);
      if (withPictures) this.group.add(this.placeholder(facade));
    }
  }

  highlight(id: string | null): void {
    for (const [name, mesh] of this.meshes) mesh.visible = name === id;
    this.redraw();
  }

  pick(at: Vector2, camera: PerspectiveCamera): Hit | null {
    this.caster.setFromCamera(at, camera);
    const hit = this.caster.intersectObjects([...this.meshes.values()], false)[0];
    if (!hit) return null;
    const facade = hit.object.userData["facade"] as FacadeEntry;
    return { facade, opening: openingAt(facade, hit.point) };
  }

  // Load the pictures of the facades that are large on the screen, and let go of those out of sight.
  update(camera: PerspectiveCamera, height: number): void {
    if (!this.withPictures) return;
    const pixels = (f: FacadeEntry) => {
      const to = new Vector3(...f.center).sub(camera.position), away = to.length();
      const facing = -to.dot(new Vector3(...f.outward)) / away;
      const sight = new Vector3(...f.center).project(camera);
      const seen = facing > 0 && sight.z < 1 && Math.abs(sight.x) < 1.4 && Math.abs(sight.y) < 1.4;
      return seen ? (f.size[1] / away) * height / (2 * Math.tan((camera.fov * Math.PI) / 360)) : 0;
    };
    const wanted = this.run.facades.filter((f) => f.ortho).map((f) => ({ f, px: pixels(f) }))
      .sort((a, b) => b.px - a.px);
    wanted.forEach(({ f, px }, k) => this.texture(f, k < PICTURES && px > SMALLEST));
  }

  private texture(f: FacadeEntry, wanted: boolean): void {
    const mesh = this.pictures.get(f.id)!;
    if (wanted && !mesh.material.map) {
      const texture = this.loader.load(`${f.path}/photo_${f.ortho!.levels - 1}_0_0.jpg`, () => this.redraw());
      texture.colorSpace = SRGBColorSpace;
      mesh.material.map = texture;
      mesh.material.color.set(0xffffff);
      mesh.material.needsUpdate = true;
    }
    if (!wanted && mesh.material.map) {
      mesh.material.map.dispose();
      mesh.material.map = null;
      mesh.material.color.set(0xb8b4aa);
      mesh.material.needsUpdate = true;
    }
  }

  private placeholder(f: FacadeEntry): Mesh<BufferGeometry, MeshBasicMaterial> {
    const corners = f.ortho?.corners ?? f.outline;
    const geometry = f.ortho ? quad(corners) : polygon(f, 0);
    const mesh = new Mesh(geometry, new MeshBasicMaterial({ color: 0xb8b4aa, side: DoubleSide }));
    this.pictures.set(f.id, mesh);
    return mesh;
  }
}

// Rightwards as seen from the street, and up in the wall.
function axes(f: FacadeEntry): { right: Vector3; up: Vector3 } {
  const out = new Vector3(...f.outward);
  const right = new Vector3(0, 0, 1).cross(out).normalize();
  return { right, up: out.clone().cross(right) };
}

function polygon(f: FacadeEntry, before = BEFORE): BufferGeometry {
  const { right, up } = axes(f), out = new Vector3(...f.outward).multiplyScalar(before);
  const points = f.outline.map((p) => new Vector3(...p));
  const flat = points.map((p) => new Vector2(p.dot(right), p.dot(up)));
  // Triangles must turn with the facade, so that its front faces the street.
  if (ShapeUtils.isClockWise(flat)) { points.reverse(); flat.reverse(); }
  const geometry = new BufferGeometry().setFromPoints(points.map((p) => p.clone().add(out)));
  geometry.setIndex(ShapeUtils.triangulateShape(flat, []).flat());
  return geometry;
}

function quad(corners: Vec3[]): BufferGeometry {
  const geometry = new BufferGeometry().setFromPoints(corners.map((p) => new Vector3(...p)));
  geometry.setAttribute("uv", new Float32BufferAttribute([0, 1, 1, 1, 1, 0, 0, 0], 2));
  geometry.setIndex([0, 2, 1, 0, 3, 2]);
  return geometry;
}

function openingAt(f: FacadeEntry, point: Vector3): OpeningEntry | null {
  const { right, up } = axes(f);
  return (f.openings ?? []).find((o) => {
    const d = point.clone().sub(new Vector3(...o.center));
    return Math.abs(d.dot(right)) <= o.width / 2 && Math.abs(d.dot(up)) <= o.height / 2;
  }) ?? null;
}
