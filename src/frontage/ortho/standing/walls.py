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


def is_building(xyz: Array) -> bool:
    """Whether most points (n, 3) m, z upwards, lie on large upright planes."""
    points = np.asarray(xyz[:: 1 + len(xyz) // _ENOUGH], np.float64)
    left, on_walls = points, 0
    for _ in range(_PLANES):
        on = _fullest_plane(left)
        if on.sum() < (1.0 - _MOSTLY) / _PLANES * len(points):
            break
        if _area(left[on]) > _WALL_M2:
            on_walls += int(on.sum())
        left = left[~on]
    return on_walls > _MOSTLY * len(points)


def _fullest_plane(xyz: Float) -> Bool:
    """Which points (n, 3) lie on the upright plane that holds most of them."""
    if not len(xyz):
        return np.zeros(0, np.bool_)
    angle = np.arange(_DIRECTIONS) * np.pi / _DIRECTIONS
    across = xyz[:, 0, None] * np.cos(angle) + xyz[:, 1, None] * np.sin(angle)
    across -= across.min(axis=0)
    number = (across / _FLAT_M).astype(np.int64)
    width = int(number.max()) + 2
    count = np.bincount((number + width * np.arange(_DIRECTIONS)).ravel(), minlength=width * _DIRECTIONS)
    count = count.reshape(_DIRECTIONS, width)
    both = count[:, :-1] + count[:, 1:]  # of two neighbouring slices
    direction, first = divmod(int(np.argmax(both)), width - 1)
    own = number[:, direction]
    middle = np.median(across[(own == first) | (own == first + 1), direction])
    return np.asarray(np.abs(across[:, direction] - middle) < _FLAT_M)


def _area(xyz: Float) -> float:
    """The area m2 that points (n, 3) of an upright plane fill, by cells along it and upwards."""
    plan = xyz[:, :2] - xyz[:, :2].mean(axis=0)
    along = plan @ np.linalg.svd(plan, full_matrices=False)[2][0]
    cells = np.unique(np.floor(np.column_stack([along, xyz[:, 2]]) / _CELL_M).astype(np.int64), axis=0)
    return float(len(cells)) * _CELL_M**2
