"""Tells the walls of neighbours, and of wings of the same building, from what stands free before a facade.

Two walls that meet in a corner are one group of points. A group is therefore taken apart into its largest
upright planes, one after the other; of a building they hold most of the points, of a tree or a car they do
not.
"""

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float

_WALL_M2 = 8.0  # an upright plane larger than any sign or side of a car
_MOSTLY = 0.7  # share of the points of a group on such planes
_PLANES = 3  # of a group, at most
_FLAT_M = 0.15  # of a plane, from its middle
_DIRECTIONS = 120  # 1.5 degrees apart
_CELL_M = 0.4  # of a plane, which counts where it holds points
_ENOUGH = 1500  # points, which tell as much as all
_HIGH_M = 4.0  # lorries and buses are lower (StVZO, section 32)
_THIN_M = 0.05  # from the middle of a wall: cornices and frames are few
_WITHIN = 0.6  # share of the points near a plane that are so near; of a tree, it is a third
_MIXED = 0.45  # likewise, of half a square metre that a tree touches
_FEWEST = 50  # of a sample, on a plane

Plane = tuple[Float, float]
"""An upright plane: its normal (2,), which is level, and its distance from the origin in m."""


def fullest_planes(xyz: Array) -> list[Plane]:
    """The upright planes that hold most of the points (n, 3) m, z upwards, one after the other."""
    left = _sample(xyz)
    planes: list[Plane] = []
    while len(left) and len(planes) < _PLANES:
        planes.append(_fullest_plane(left))
        left = left[np.abs(_off(left, planes[-1])) >= _FLAT_M]
    return planes


def is_building(xyz: Array, planes: list[Plane] | None = None) -> bool:
    """Whether most points (n, 3) m, z upwards, lie on large upright planes: their `fullest_planes`."""
    points = _sample(xyz)
    left, on_walls = points, 0
    for plane in fullest_planes(xyz) if planes is None else planes:
        on = np.abs(_off(left, plane)) < _FLAT_M
        if on.sum() < (1.0 - _MOSTLY) / _PLANES * len(points):
            break
        if _area(left[on]) > _WALL_M2:
            on_walls += int(on.sum())
        left = left[~on]
    return on_walls > _MOSTLY * len(points)


def wall_points(xyz: Array, planes: list[Plane] | None = None) -> Bool:
    """Returns which points (n, 3) m, z upwards, lie on upright planes that are large, thin and high.

    A slice of a tree is large as well, but it is as full at its sides as in its middle; a lorry is lower.
    `planes` are the `fullest_planes` of the points, where they are known.
    """
    found = np.zeros(len(xyz), np.bool_)
    if np.ptp(xyz[:, 2]) < _HIGH_M:
        return found
    points, left = np.asarray(xyz, np.float64), _sample(xyz)
    for plane in fullest_planes(xyz) if planes is None else planes:
        on = np.abs(_off(left, plane)) < _FLAT_M
        if on.sum() < _FEWEST:
            break
        found |= _wall_on(points, _fitted(left, plane))
        left = left[~on]
    return found


def _sample(xyz: Array) -> Float:
    return np.asarray(xyz[:: 1 + len(xyz) // _ENOUGH], np.float64)


def _wall_on(xyz: Float, plane: Plane) -> Bool:
    """Which points (n, 3) are those of a wall on a plane, if there is one.

    A wall has few points beside it. That is told on cells, because a tree may cross the plane elsewhere.
    """
    (across, along), _ = plane
    off, found = np.abs(_off(xyz, plane)), np.zeros(len(xyz), np.bool_)
    near = np.flatnonzero(off < _FLAT_M)
    place = xyz[near, 1] * across - xyz[near, 0] * along, xyz[near, 2]
    column, row = (np.floor((a - a.min()) / _CELL_M).astype(np.int64) for a in place)
    rows = int(row.max()) + 1
    cell = column * rows + row
    share = np.bincount(cell, off[near] < _THIN_M) / np.maximum(np.bincount(cell), 1)
    thin = np.flatnonzero(share > _WITHIN)
    if len(thin) * _CELL_M**2 > _WALL_M2 and np.ptp(thin % rows) * _CELL_M > _HIGH_M:
        found[near] = share[cell] > _MIXED
    return found


def _fitted(xyz: Float, plane: Plane) -> Plane:
    """Turns a plane, whose direction is known to a few degrees, to fit the points (n, 3) beside it."""
    for width in (_FLAT_M, _FLAT_M, _THIN_M):
        plan = xyz[np.abs(_off(xyz, plane)) < width][:, :2]
        if len(plan) < _FEWEST:
            break
        normal = np.linalg.eigh(np.cov(plan.T))[1][:, 0]
        plane = normal, float(np.median(plan @ normal))
    return plane


def _off(xyz: Float, plane: Plane) -> Float:
    """The distances (n,) m of points (n, 3) from an upright plane."""
    normal, level = plane
    return np.asarray(xyz[:, :2] @ normal - level)


def _fullest_plane(xyz: Float) -> Plane:
    """The upright plane that holds most of the points (n, 3)."""
    angle = np.arange(_DIRECTIONS) * np.pi / _DIRECTIONS
    if not len(xyz):
        return np.array([1.0, 0.0]), 0.0
    across = xyz[:, 0, None] * np.cos(angle) + xyz[:, 1, None] * np.sin(angle)
    number = ((across - across.min(axis=0)) / _FLAT_M).astype(np.int64)
    width = int(number.max()) + 2
    count = np.bincount((number + width * np.arange(_DIRECTIONS)).ravel(), minlength=width * _DIRECTIONS)
    count = count.reshape(_DIRECTIONS, width)
    both = count[:, :-1] + count[:, 1:]  # of two neighbouring slices
    direction, first = divmod(int(np.argmax(both)), width - 1)
    own = number[:, direction]
    level = float(np.median(across[(own == first) | (own == first + 1), direction]))
    return np.array([np.cos(angle[direction]), np.sin(angle[direction])]), level


def _area(xyz: Float) -> float:
    """The area m2 that points (n, 3) of an upright plane fill, by cells along it and upwards."""
    plan = xyz[:, :2] - xyz[:, :2].mean(axis=0)
    along = plan @ np.linalg.svd(plan, full_matrices=False)[2][0]
    cells = np.unique(np.floor(np.column_stack([along, xyz[:, 2]]) / _CELL_M).astype(np.int64), axis=0)
    return float(len(cells)) * _CELL_M**2
