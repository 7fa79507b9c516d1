// Where to look at the district from.

import { Box3, PerspectiveCamera, Vector3 } from "three";
import type { FacadeEntry, Run } from "../data";

const FIELD_DEG = 45;

export function makeCamera(): PerspectiveCamera {
  const camera = new PerspectiveCamera(FIELD_DEG, 1, 0.3, 5000);
  camera.up.set(0, 0, 1);
  return camera;
}

export interface Stand { position: Vector3; target: Vector3 }

const ROOF_M = 4; // roofs reach this far above the facades
const ROOM = 1.06;

// From before the fronts, a little above, just so far away that all facades are in the picture.
export function overview(run: Run, aspect: number): Stand {
  const points = run.facades.flatMap((f) => f.outline.map((p) => new Vector3(...p)));
  points.push(...points.map((p) => p.clone().add(new Vector3(0, 0, ROOF_M))));
  const target = new Box3().setFromPoints(points).getCenter(new Vector3());
  const direction = ahead(run).multiplyScalar(0.9).add(new Vector3(0, 0, 0.34));
  direction.add(new Vector3(-direction.y, direction.x, 0).multiplyScalar(0.3)).normalize();
  const right = new Vector3(0, 0, 1).cross(direction).normalize(), up = direction.clone().cross(right);
  const tall = Math.tan((FIELD_DEG * Math.PI) / 360), wide = tall * aspect;
  const away = points.map((p) => {
    const d = p.clone().sub(target);
    return d.dot(direction) + Math.max(Math.abs(d.dot(right)) / wide, Math.abs(d.dot(up)) / tall);
  });
  return { position: target.clone().addScaledVector(direction, ROOM * Math.max(...away)), target };
}

// The way that most facades face. Two sides of a street cancel each other: then that of the largest.
function ahead(run: Run): Vector3 {
  const area = (f: FacadeEntry) => f.size[0] * f.size[1];
  const sum = run.facades.reduce((v, f) => v.addScaledVector(new Vector3(...f.outward), area(f)), new Vector3());
  const total = run.facades.reduce((v, f) => v + area(f), 0);
  const largest = run.facades.reduce((a, b) => (area(a) >= area(b) ? a : b));
  return (sum.length() > 0.3 * total ? sum : new Vector3(...largest.outward)).setZ(0).normalize();
}
