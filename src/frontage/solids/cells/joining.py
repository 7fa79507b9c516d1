"""Borders that almost touch are made to touch: no strip narrower than the gap stays between them."""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float


def join(polygon: Polygon, others: Sequence[BaseGeometry], gap: float) -> Polygon:
    """A polygon without holes whose border follows the others' lines wherever it came within `gap` of them.

    Vertices go to the nearest vertex within the gap, else to the nearest line; edges take in vertices of the
    others. The polygon comes back as it was where nothing is near, or where the result would not be simple.
    """
    close = [g.boundary if g.geom_type.endswith("Polygon") else g for g in others]
    close = [g for g in close if g.dwithin(polygon.boundary, gap)]
    if not close:
        return polygon
    lines = shapely.union_all(close)
    knots = shapely.get_coordinates(lines)
    ring = _to_lines(shapely.get_coordinates(polygon.exterior)[:-1], lines, knots, gap)
    ring = _with_knots(ring, knots, gap)
    keep = (ring != np.roll(ring, 1, axis=0)).any(1)
    if keep.sum() < 3:
        return polygon
    joined = Polygon(np.rint(ring[keep]))
    return joined if joined.is_valid and joined.area > 0 else polygon


def _to_lines(ring: Float, lines: BaseGeometry, knots: Float, gap: float) -> Float:
    """Vertices (k, 2) moved onto what is near."""
    away = np.linalg.norm(ring[:, None] - knots, axis=2)
    nearest = away.argmin(1)
    to_knot = away[np.arange(len(ring)), nearest] <= gap
    feet = np.array(
        [shapely.get_coordinates(shapely.shortest_line(shapely.Point(p), lines))[1] for p in ring]
    )
    to_line = np.linalg.norm(feet - ring, axis=1) <= gap
    moved = np.where(to_line[:, None], feet, ring)
    return np.asarray(np.where(to_knot[:, None], knots[nearest], moved))


def _with_knots(ring: Float, knots: Float, gap: float) -> Float:
    """Edges broken at the others' vertices that lie within the gap of them."""
    out: list[Float] = []
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        out.append(a)
        along = b - a
        length = float(along @ along)
        if length == 0:
            continue
        t = (knots - a) @ along / length
        off = np.linalg.norm(knots - a - t[:, None] * along, axis=1)
        margin = gap / np.sqrt(length)  # nearer to an end, the end itself has gone to the knot
        near = (off > 0) & (off <= gap) & (t > margin) & (t < 1 - margin)
        out += list(knots[near][np.argsort(t[near], kind="stable")])
    return np.array(out)
