// Pixels of an ortho-image as measurements: the same arithmetic as FacadePixels of the Python API.

import type { Ortho, Point, Vec3 } from "./data";

export interface WorldPoint { xyz: Vec3; depth: number; relief: boolean; sigma: number | null }

// World position of a pixel; `y` is the relief there (m behind the plane), null where none was measured.
export function worldFromPixel(ortho: Ortho, column: number, row: number, y: number | null): WorldPoint {
  const m = ortho.raster_to_world;
  const p = [column, row, y ?? 0, 1];
  const xyz = [0, 1, 2].map((k) => m[k]!.reduce((sum, v, j) => sum + v * p[j]!, 0)) as Vec3;
  return { xyz, depth: y ?? 0, relief: y !== null, sigma: sigmaAcross(ortho, column, row, y !== null) };
}

// Standard error along the wall's normal: of the plane there, with the scatter of the points on relief.
export function sigmaAcross(ortho: Ortho, column: number, row: number, relief: boolean): number | null {
  const c = ortho.plane_variance;
  if (!c || (relief && ortho.scatter === null)) return null;
  const [x, z] = facadeFromPixel(ortho, [column, row]);
  const terms = [1, x, z, x * x, x * z, z * z];
  const plane = terms.reduce((sum, t, k) => sum + t * c[k]!, 0);
  return Math.sqrt(Math.max(plane, 0) + (relief ? ortho.scatter! ** 2 : 0));
}

export function facadeFromPixel(ortho: Ortho, [column, row]: Point): Point {
  return [ortho.corner[0] + ortho.gsd * column, ortho.corner[1] - ortho.gsd * row];
}

export function pixelFromFacade(ortho: Ortho, [x, z]: Point): Point {
  return [(x - ortho.corner[0]) / ortho.gsd, (ortho.corner[1] - z) / ortho.gsd];
}

export interface Measured { value: number; sigma: number }

// Every point is placed on a pixel, which leaves an error that is uniform over the pixel.
const pixelVariance = (gsd: number) => gsd * gsd / 12;

// Length of a path of pixels on the wall, m.
export function lengthOf(ortho: Ortho, pixels: Point[]): Measured {
  const points = pixels.map((p) => facadeFromPixel(ortho, p));
  let value = 0;
  const slope = points.map(() => [0, 0] as Point);
  for (let k = 1; k < points.length; k++) {
    const [a, b] = [points[k - 1]!, points[k]!];
    const d = Math.hypot(b[0] - a[0], b[1] - a[1]);
    value += d;
    for (const axis of [0, 1] as const) {
      const unit = d ? (b[axis] - a[axis]) / d : 0;
      slope[k]![axis] += unit;
      slope[k - 1]![axis] -= unit;
    }
  }
  return { value, sigma: Math.sqrt(pixelVariance(ortho.gsd) * sumOfSquares(slope)) };
}

// Area of a polygon of pixels on the wall, m2.
export function areaOf(ortho: Ortho, pixels: Point[]): Measured {
  const points = pixels.map((p) => facadeFromPixel(ortho, p));
  const n = points.length;
  let twice = 0;
  const slope = points.map((_, k): Point => {
    const [before, here, after] = [points[(k + n - 1) % n]!, points[k]!, points[(k + 1) % n]!];
    twice += here[0] * after[1] - after[0] * here[1];
    return [(after[1] - before[1]) / 2, (before[0] - after[0]) / 2];
  });
  return { value: Math.abs(twice) / 2, sigma: Math.sqrt(pixelVariance(ortho.gsd) * sumOfSquares(slope)) };
}

// Length of a path in space, m; null if a point has no relief.
export function lengthInSpace(points: WorldPoint[]): number | null {
  if (points.some((p) => !p.relief)) return null;
  return points.slice(1).reduce((sum, p, k) => sum + Math.hypot(...p.xyz.map((v, j) => v - points[k]!.xyz[j]!)), 0);
}

const sumOfSquares = (rows: Point[]) => rows.reduce((sum, [a, b]) => sum + a * a + b * b, 0);

export function inside([x, y]: Point, ring: Point[]): boolean {
  let within = false;
  for (let k = 0, j = ring.length - 1; k < ring.length; j = k++) {
    const [a, b] = [ring[k]!, ring[j]!];
    if (a[1] > y !== b[1] > y && x < ((b[0] - a[0]) * (y - a[1])) / (b[1] - a[1]) + a[0]) within = !within;
  }
  return within;
}
