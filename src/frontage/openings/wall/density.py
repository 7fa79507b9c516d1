"""The density of beams where they are sparse, from the triangles between neighbouring points."""

import numpy as np
from scipy.spatial import Delaunay, QhullError

from frontage.geometry.arrays import Float, Int

_FEWEST = 4  # points that make triangles
_GAP = 2.0  # times the usual radius about a place from which a triangle spans a gap; 1 % of random ones do


def wall_triangles(points: Float) -> tuple[Float, Float]:
    """Returns the middles (t, 2) m and areas (t,) m2 of the triangles between points (n, 2) m of a wall.

    Every triangle stands for half a point, whether the points form a lattice, however narrow, or lie at
    random. The circle about a triangle holds no other point: where it is twice as large as is usual at the
    corners, the triangle spans an opening or another gap and is left out.
    """
    if len(points) < _FEWEST:
        return np.empty((0, 2)), np.empty(0)
    try:
        triangles = Delaunay(points).simplices.astype(np.int64)
    except QhullError:  # all on one line
        return np.empty((0, 2)), np.empty(0)
    corners = points[triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2.0
    radii = sides.prod(1) / np.maximum(4.0 * areas, 1e-12)
    usual = _median_about(triangles, radii, len(points))[triangles].min(1)
    whole = radii <= _GAP * usual
    return np.asarray(corners[whole].mean(1)), np.asarray(areas[whole])


def _median_about(triangles: Int, values: Float, number: int) -> Float:
    """Returns the lower median (n,) of the values (t,) of the triangles at each point; NaN without any."""
    corner, value = triangles.ravel(), np.repeat(values, 3)
    order = np.lexsort((value, corner))
    first = np.searchsorted(corner[order], np.arange(number))
    held = np.diff(np.append(first, len(order)))
    middle = np.append(value[order], np.nan)[first + np.maximum(held - 1, 0) // 2]
    return np.where(held > 0, middle, np.nan)
