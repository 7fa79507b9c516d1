"""Rings (k, 2) in the plane, without a repeated last vertex, and rasters of cells turned into rings."""

import numpy as np
import shapely
from shapely.geometry import Polygon, box

from frontage.geometry.arrays import Array, Bool, Float

_ON_SIDE = 1e-6  # corners this close to a side of the bounding box touch it


def ring_area(ring: Float) -> float:
    """Returns the signed area of a ring (k, 2), positive when it is counter-clockwise."""
    x, y = np.asarray(ring, np.float64).T
    return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def ring_area_sigma(ring: Float, covariance: Float) -> float:
    """Returns the standard error of a ring's area from the covariance (2k, 2k) of x0, y0, x1, y1, ..."""
    ahead, behind = np.roll(ring, -1, axis=0), np.roll(ring, 1, axis=0)
    gradient = 0.5 * np.column_stack([ahead[:, 1] - behind[:, 1], behind[:, 0] - ahead[:, 0]]).ravel()
    return float(np.sqrt(max(float(gradient @ covariance @ gradient), 0.0)))


def box_sigmas(ring: Float, covariance: Float) -> tuple[float, float, float, float]:
    """Returns the standard errors of x0, y0, x1, y1 of the bounding box of a ring (k, 2).

    Each is the mean over the corners that touch the side. `covariance` is the (2k, 2k) of the coordinates
    x0, y0, x1, y1, ...
    """
    sigma = np.sqrt(np.diag(covariance)).reshape(-1, 2)

    def side(axis: int, at: float) -> float:
        return float(sigma[np.abs(ring[:, axis] - at) < _ON_SIDE, axis].mean())

    low, high = ring.min(0), ring.max(0)
    return side(0, low[0]), side(1, low[1]), side(0, high[0]), side(1, high[1])


def span_sigma(ring: Float, covariance: Float, axis: int) -> float:
    """Returns the standard error of a ring's width (axis 0) or height (axis 1) from its covariance (2k, 2k).

    It is sqrt(g C g); the gradient g takes the mean of the corners on the one side minus that on the other.
    """
    value = ring[:, axis]
    gradient = np.zeros_like(ring)
    for sign, extreme in ((1.0, value.max()), (-1.0, value.min())):
        on = np.abs(value - extreme) < _ON_SIDE
        gradient[on, axis] = sign / on.sum()
    g = gradient.ravel()
    return float(np.sqrt(g @ covariance @ g))


def at_depth(ring: Float, y: float) -> Float:
    """Returns the points (k, 3) of a facade frame for points (k, 2) x and z at depth y."""
    return np.column_stack([ring[:, 0], np.full(len(ring), y), ring[:, 1]])


def ring_contains(ring: Float, xy: Float) -> Bool:
    """Returns whether points (n, 2) lie in a ring (k, 2) or on its border, (n,) bool."""
    polygon = Polygon(ring)
    shapely.prepare(polygon)
    inside = shapely.contains_xy(polygon, xy[:, 0], xy[:, 1])
    near = ~inside
    if near.any():
        inside[near] = shapely.intersects_xy(polygon, xy[near, 0], xy[near, 1])
    return np.asarray(inside, np.bool_)


def convex_ring(xy: Float) -> Float:
    """Returns the convex hull (k, 2) of points (n, 2), counter-clockwise.

    Raises ValueError when the points lie on one line or are fewer than three.
    """
    hull = shapely.convex_hull(shapely.multipoints(xy))
    if not isinstance(hull, Polygon):
        raise ValueError("points on one line have no convex ring")
    return polygon_ring(hull)


def polygon_ring(polygon: Polygon) -> Float:
    """Returns the exterior ring (k, 2) of a polygon, counter-clockwise, without its holes."""
    ring = np.asarray(polygon.exterior.coords, np.float64)[:-1]
    return ring if ring_area(ring) > 0 else ring[::-1]


def cells_ring(mask: Bool, corner: tuple[float, float], cell: float, tolerance: float) -> Float:
    """Returns the outer ring (k, 2) of the largest connected component of the cells that are set.

    mask       (h, w): row r, column c covers ``corner + cell * (c..c+1, r..r+1)``
    tolerance  distance that the ring may have from the outline of the cells (Douglas-Peucker)

    The ring is counter-clockwise. Raises ValueError when no cell is set.
    """
    if not mask.any():
        raise ValueError("no cell is set")
    padded = np.zeros((mask.shape[0], mask.shape[1] + 2), np.int8)
    padded[:, 1:-1] = mask
    step: Array = np.diff(padded, axis=1)
    row, first = np.nonzero(step == 1)
    _, last = np.nonzero(step == -1)
    x0, z0 = corner
    runs = shapely.box(x0 + first * cell, z0 + row * cell, x0 + last * cell, z0 + (row + 1) * cell)
    union = shapely.union_all(runs)
    parts = shapely.get_parts(union)
    part = max(parts, key=lambda p: float(p.area))
    plain = Polygon(part.exterior).simplify(tolerance)
    if not isinstance(plain, Polygon) or plain.is_empty or not plain.is_valid:
        plain = Polygon(part.exterior)
    return polygon_ring(plain)


def rectangle(x0: float, z0: float, x1: float, z1: float) -> Float:
    """Returns the counter-clockwise ring (4, 2) of an upright rectangle."""
    return polygon_ring(box(x0, z0, x1, z1))
