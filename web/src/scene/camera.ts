// Where to look at the district from.

import { Box3, PerspectiveCamera, Sphere, Vector3 } from "three";
import type { Run } from "../data";

const FIELD_DEG = 45;

export function makeCamera(): PerspectiveCamera {
  const camera = new PerspectiveCamera(FIELD_DEG, 1, 0.3, 5000);
  camera.up.set(0, 0, 1);
  return camera;
}

export interface Stand { position: Vector3; target: Vector3 }

// From before the fronts, a little above the eaves, so that all facades are in the picture.
export function overview(run: Run, aspect: number): Stand {
  const box = new Box3().setFromPoints(run.facades.flatMap((f) => f.outline.map((p) => new Vector3(...p))));
  const around = box.getBoundingSphere(new Sphere());
  const out = run.facades.reduce((sum, f) => sum.addScaledVector(new Vector3(...f.outward), f.size[0] * f.size[1]), new Vector3());
  // Two sides of a street cancel each other: then look along the normal of the largest facade.
  const largest = run.facades.reduce((a, b) => (a.size[0] * a.size[1] >= b.size[0] * b.size[1] ? a : b));
  const total = run.facades.reduce((sum, f) => sum + f.size[0] * f.size[1], 0);
  const ahead = out.length() > 0.3 * total ? out.setZ(0).normalize() : new Vector3(...largest.outward).setZ(0).normalize();
  const aside = new Vector3(-ahead.y, ahead.x, 0);
  const half = Math.min(FIELD_DEG / 2, (Math.atan(Math.tan((FIELD_DEG * Math.PI) / 360) * aspect) * 180) / Math.PI);
  const away = (0.85 * around.radius) / Math.sin((half * Math.PI) / 180);
  const direction = ahead.multiplyScalar(0.9).addScaledVector(aside, 0.28).add(new Vector3(0, 0, 0.34)).normalize();
  return { position: around.center.clone().addScaledVector(direction, away), target: around.center.clone() };
}
