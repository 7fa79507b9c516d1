"""Extrudes polygons with holes from one depth to another."""

import itertools

import numpy as np
import shapely
from shapely.geometry import Polygon

from frontage.geometry.arrays import Int
from frontage.geometry.rigid import Rigid3
from frontage.model import Face, Solid
from frontage.solids.brep import GRID_PER_M


def extruded(name: str, polygon: Polygon, pose: Rigid3, depths: tuple[float, float], world: Int) -> Solid:
    """Returns the prism over a polygon in 0.1 mm (x, z) between two depths y (m), the front one first.

    The outer ring is counter-clockwise and the holes are clockwise as seen along y. `pose` leads to the local
    frame, `world` (3,) is its origin. The front is the first face, the back the second one; faces have no
    semantic class.
    """
    closed, ring = shapely.get_coordinates(shapely.get_rings(polygon), return_index=True)
    last = np.append(ring[1:] != ring[:-1], True)  # repeats the first corner of its ring
    flat, n = closed[~last] / GRID_PER_M, int((~last).sum())
    xyz = np.concatenate([np.insert(flat, 1, y, axis=1) for y in depths])
    begins = [0, *np.cumsum(np.bincount(ring) - 1).tolist()]
    loops = [range(a, b) for a, b in itertools.pairwise(begins)]
    front = Face(tuple(loops[0]), "", tuple(tuple(r) for r in loops[1:]))
    behind = [tuple(range(r.stop - 1 + n, r.start - 1 + n, -1)) for r in loops]
    sides = [Face((b, a, a + n, b + n), "") for r in loops for a, b in zip(r, (*r[1:], r.start), strict=True)]
    grid = np.rint(pose.apply(xyz) * GRID_PER_M).astype(np.int64)
    faces = (front, Face(behind[0], "", tuple(behind[1:])), *sides)
    return Solid(name, grid, world, faces, "3")
