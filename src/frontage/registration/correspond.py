"""Correspondences: on which wall or roof of the model does a surfel lie?"""

from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Array, Float, Int
from frontage.registration.walls import ModelWalls
from frontage.solve.surfels import Surfels

_FACING_COS = np.cos(np.radians(20.0))  # between the normals of surfel and patch: 20 degrees
_BORDER_M = 0.3  # m that a foot point may lie outside its polygon


@dataclass(frozen=True, eq=False)
class Matches:
    """Surfels on patches.

    piece  (m,) into the surfels; `patch` (m,) into the model's patches
    r      (m,) m, distance from the patch, outwards positive
    u, h   (m,) m, place along and up in the patch
    """

    piece: Int
    patch: Int
    r: Float
    u: Float
    h: Float

    def __len__(self) -> int:
        return len(self.piece)


def match_surfels(
    pieces: Surfels,
    walls: ModelWalls,
    d_max: float,
    *,
    slack: float = 0.0,
    turn: float = 0.0,
    roofs: bool = True,
) -> Matches:
    """Finds the nearest patch of every surfel within `d_max` m that faces the same way, if any.

    pieces  surfels, moved to local coordinates
    slack   m that the pose may still be off, heights included
    turn    rad that is added to the 20 degrees allowed between normals
    roofs   whether roofs take part

    A foot point must lie in the exposed polygon, grown by 0.3 m and by `slack`.
    """
    n = len(pieces)
    best, r, u, h = np.full(n, -1), np.full(n, d_max), np.zeros(n), np.zeros(n)
    limit = float(np.cos(np.arccos(_FACING_COS) + turn))
    for j, p in enumerate(walls.patches):
        if p.kind == "roof" and not roofs:
            continue
        cosine = pieces.normal @ p.normal
        facing = np.where(pieces.oriented, cosine, np.abs(cosine)) > limit
        rows = np.flatnonzero(facing)
        d, along, up = p.coordinates(pieces.xyz[rows])
        grow = _BORDER_M + slack
        x0, y0, x1, y1 = p.polygon.bounds
        near = (np.abs(d) < np.abs(r[rows])) & (along > x0 - grow) & (along < x1 + grow)
        near &= (up > y0 - grow) & (up < y1 + grow)
        rows, d, along, up = rows[near], d[near], along[near], up[near]
        inside = _contains(p.polygon.buffer(grow, quad_segs=2), along, up)
        rows = rows[inside]
        best[rows], r[rows], u[rows], h[rows] = j, d[inside], along[inside], up[inside]
    found = np.flatnonzero(best >= 0)
    return Matches(found, best[found], r[found], u[found], h[found])


def _contains(polygon: object, x: Float, y: Float) -> Array:
    """Returns which points (n,) lie in a polygon."""
    shapely.prepare(polygon)
    return np.asarray(shapely.contains_xy(polygon, x, y), np.bool_)


def foot_heights(ground: Surfels, walls: ModelWalls, within: float = 2.0) -> tuple[Float, Float]:
    """Measures the lowest height (b,) m of the ground at the foot of every building, as models define it.

    Also returns the range (b,) m of the ground there; both NaN where none was seen. `within` m is the width
    of the strip around a building.
    """
    z = np.full(len(walls.names), np.nan)
    spread = np.full(len(walls.names), np.nan)
    for b, plan in enumerate(walls.footprints):
        if plan.is_empty:
            continue
        x0, y0, x1, y1 = plan.bounds
        xy = ground.xyz[:, :2]
        rows = np.flatnonzero(
            (xy > np.array([x0, y0]) - within).all(1) & (xy < np.array([x1, y1]) + within).all(1)
        )
        ring = plan.buffer(within, quad_segs=2).difference(plan.buffer(0.1))
        rows = rows[_contains(ring, *xy[rows].T)] if len(rows) else rows
        if ground.area[rows].sum() < 1.0:
            continue
        low, high = np.percentile(ground.xyz[rows, 2], [5, 95])
        z[b], spread[b] = low, high - low
    return z, spread
