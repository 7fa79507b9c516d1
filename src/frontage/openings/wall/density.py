"""The density of beams where they are sparse, from the triangles between neighbouring points."""

import numpy as np
from scipy.spatial import Delaunay, QhullError, cKDTree

from frontage.geometry.arrays import Float, Int

_NEIGHBOURS = 16  # points that determine the density of a place: more than border one side of an opening
_FEWEST = 4  # points that make triangles
_GAP = 2.0  # times the usual radius from which a triangle spans a gap; 1 % of those of random points do


def triangulated_density(points: Float, places: Float, reach: float) -> Float:
    """Returns the points per m2 (m,) of a wall at places (m, 2) m, from its points (n, 2) m within `reach` m.

    Returns 0 where there are none. Every triangle between neighbouring points stands for half a point,
    whether they form a lattice, however narrow, or lie at random. The circle about a triangle holds no other
    point: where it is twice as large as is usual at its corners, the triangle spans an opening or another
    gap and is left out.
    """
    if len(points) < _FEWEST:
        return np.zeros(len(places))
    try:
        triangles = Delaunay(points).simplices.astype(np.int64)
    except QhullError:  # all on one line
        return np.zeros(len(places))
    areas, radii = _areas_and_radii(points, triangles)
    tree, near = cKDTree(points), min(_NEIGHBOURS, len(points))
    own = _median_about(triangles, radii, len(points))
    usual = np.nanmedian(own[tree.query(points, near)[1]], axis=1)
    whole = radii <= _GAP * usual[triangles].min(1)
    held = np.bincount(triangles[whole].ravel(), minlength=len(points) + 1)
    area = np.bincount(triangles[whole].ravel(), np.repeat(areas[whole], 3), minlength=len(points) + 1)
    around = tree.query(places, near, distance_upper_bound=reach)[1]
    return np.asarray(0.5 * held[around].sum(1) / np.maximum(area[around].sum(1), 1e-9))


def _areas_and_radii(points: Float, triangles: Int) -> tuple[Float, Float]:
    """Returns the areas (t,) m2 of triangles (t, 3) of points (n, 2) m, and the radii (t,) m about them."""
    corners = points[triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2.0
    return areas, sides.prod(1) / np.maximum(4.0 * areas, 1e-12)


def _median_about(triangles: Int, values: Float, number: int) -> Float:
    """Returns the lower median (n,) of the values (t,) of the triangles at each point; NaN without any."""
    corner, value = triangles.ravel(), np.repeat(values, 3)
    order = np.lexsort((value, corner))
    first = np.searchsorted(corner[order], np.arange(number))
    held = np.diff(np.append(first, len(order)))
    middle = np.append(value[order], np.nan)[first + np.maximum(held - 1, 0) // 2]
    return np.where(held > 0, middle, np.nan)
