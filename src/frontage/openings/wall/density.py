"""The density of beams where they are sparse, from the triangles between neighbouring points."""

import numpy as np
from scipy.spatial import Delaunay, QhullError, cKDTree

from frontage.geometry.arrays import Float, Int

_NEIGHBOURS = 16  # points that determine the density of a place: more than border one side of an opening
_FEWEST = 4  # points that make triangles


def triangulated_density(points: Float, places: Float, reach: float) -> Float:
    """Returns the points per m2 (m,) of a wall at places (m, 2) m, from its points (n, 2) m within `reach` m.

    Returns 0 where there are none. Between the points of a lattice, however narrow, all Delaunay triangles
    have half the area that a point stands for. Those across openings are larger but few, so the median of the
    triangles at a point, and then of the points around, is that of the wall. For random points the result is
    1.4 times the density.
    """
    if len(points) < _FEWEST:
        return np.zeros(len(places))
    try:
        triangles = Delaunay(points).simplices.astype(np.int64)
    except QhullError:  # all on one line
        return np.zeros(len(places))
    own = np.append(_median_about(triangles, _areas(points, triangles), len(points)), np.nan)
    near = cKDTree(points).query(places, min(_NEIGHBOURS, len(points)), distance_upper_bound=reach)[1]
    around = own[near]  # NaN where no point is near enough
    around[np.isnan(around).all(1), 0] = np.inf
    return np.asarray(0.5 / np.nanmedian(around, axis=1))


def _areas(points: Float, triangles: Int) -> Float:
    """Returns the areas (t,) m2 of triangles (t, 3) of points (n, 2) m."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    return np.asarray(np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2)


def _median_about(triangles: Int, areas: Float, number: int) -> Float:
    """Returns the lower median (n,) of the areas of the triangles at each point; NaN without any."""
    corner, area = triangles.ravel(), np.repeat(areas, 3)
    order = np.lexsort((area, corner))
    first = np.searchsorted(corner[order], np.arange(number))
    held = np.diff(np.append(first, len(order)))
    middle = np.append(area[order], np.nan)[first + np.maximum(held - 1, 0) // 2]
    return np.where(held > 0, middle, np.nan)
