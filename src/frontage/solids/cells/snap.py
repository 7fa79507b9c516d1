"""Snaps borders together where the strip between them would be narrower than the minimum gap."""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float


def snap_border(polygon: Polygon, others: Sequence[BaseGeometry], gap: float) -> Polygon:
    """Moves the border of a polygon without holes onto the lines of others within `gap` of it.

    Vertices move to the nearest vertex within the gap, else to the nearest line; edges are split at vertices
    of the others. Returns the polygon unchanged if nothing is near, or if the result would not be simple.
    """
    close = [g.boundary if g.geom_type.endswith("Polygon") else g for g in others]
    close = [g for g in close if g.dwithin(polygon.boundary, gap)]
    if not close:
        return polygon
    lines = shapely.union_all(close)
    targets = shapely.get_coordinates(lines)
    ring = _vertices_snapped(shapely.get_coordinates(polygon.exterior)[:-1], lines, targets, gap)
    ring = _edges_split(ring, targets, gap)
    keep = (ring != np.roll(ring, 1, axis=0)).any(1)
    if keep.sum() < 3:
        return polygon
    snapped = Polygon(np.rint(ring[keep]))
    return snapped if snapped.is_valid and snapped.area > 0 else polygon


def _vertices_snapped(ring: Float, lines: BaseGeometry, targets: Float, gap: float) -> Float:
    """Moves vertices (k, 2) onto the nearest target vertex (n, 2) or line within the gap."""
    away = np.linalg.norm(ring[:, None] - targets, axis=2)
    nearest = away.argmin(1)
    to_vertex = away[np.arange(len(ring)), nearest] <= gap
    feet = np.array(
        [shapely.get_coordinates(shapely.shortest_line(shapely.Point(p), lines))[1] for p in ring]
    )
    to_line = np.linalg.norm(feet - ring, axis=1) <= gap
    moved = np.where(to_line[:, None], feet, ring)
    return np.asarray(np.where(to_vertex[:, None], targets[nearest], moved))


def _edges_split(ring: Float, targets: Float, gap: float) -> Float:
    """Splits edges at the target vertices (n, 2) that lie within the gap of them."""
    out: list[Float] = []
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        out.append(a)
        along = b - a
        squared = float(along @ along)
        if squared == 0:
            continue
        t = (targets - a) @ along / squared
        off = np.linalg.norm(targets - a - t[:, None] * along, axis=1)
        margin = gap / np.sqrt(squared)  # closer to an end than the gap, the end itself was moved there
        near = (off > 0) & (off <= gap) & (t > margin) & (t < 1 - margin)
        out += list(targets[near][np.argsort(t[near], kind="stable")])
    return np.array(out)
