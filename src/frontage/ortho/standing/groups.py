"""Joins points before a wall into things, and takes those apart that only touch each other.

Points whose cubes touch are one group. A tree may touch the bay of a house, though, and a car the wall of a
wing: where a group holds upright walls, these are taken out, and the rest is grouped again.
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float, Int
from frontage.ortho.standing.walls import fullest_planes, is_building, wall_points

TOUCH_M = 0.6
"""Before the plane: what lies so near may be held by the wall."""
FEWEST_POINTS = 20
"""Points of a thing, at least."""
_TOUCHING = 0.2  # share of the cubes of a group so near the wall, from which it belongs to the facade,
_HELD = 0.02  # and from which it does when it does not stand on the ground
_JOINED = 0.15  # share of these cubes that must go on up to the wall if the group stands on the ground
_ABOVE_GROUND_M = 1.5  # what begins no higher may stand on the ground, behind a car
_MOSTLY = 0.7  # share of the points of a wall that lie on upright planes
_SMALLEST_M = 0.3  # extent in height
_WINDOW_CUBES = 7  # of the width of a window, odd
_TOUCHES = np.ones((3, 3, 3), np.bool_)


@dataclass(frozen=True)
class Group:
    """Points (n, 3) m in the facade frame, their heights (n,) m above the ground and cubes (n, 3)."""

    xyz: Float
    height: Float
    cube: Int

    def at(self, index: Int | Bool) -> "Group":
        """Returns some of the points: numbers (k,), or a mask (n,)."""
        return Group(self.xyz[index], self.height[index], self.cube[index])


def loose_groups(points: Group, joining: Int) -> tuple[list[Group], list[Group]]:
    """Returns the groups that no wall holds, and the walls of neighbours and wings.

    `joining` (m, 3) are the cubes of what lies between the points and the wall of the facade.
    """
    loose, walls = [], []
    for group in _grouped(points, joining):
        planes = fullest_planes(group.xyz)
        wall = wall_points(group.xyz, planes)
        if wall.any():
            parts, upright = _taken_apart(group, wall, joining)
            loose += parts
            walls += upright
        else:
            (walls if is_building(group.xyz, planes) else loose).append(group)
    return loose, walls


def _taken_apart(group: Group, wall: Bool, joining: Int) -> tuple[list[Group], list[Group]]:
    """Takes the walls, of which points (n,) are known, out of a group; also returns what they do not hold."""
    upright, rest = group.at(wall), group.at(~wall)
    parts = _grouped(rest, joining, upright.cube) if len(rest.xyz) else []
    more = [wall_points(part.xyz).mean() > _MOSTLY for part in parts]
    loose = [part for part, is_wall in zip(parts, more, strict=True) if not is_wall]
    return loose, [upright, *(part for part, is_wall in zip(parts, more, strict=True) if is_wall)]


def _grouped(points: Group, joining: Int, upright: Int | None = None) -> list[Group]:
    """Joins points whose cubes touch, without small groups and without those that a wall holds.

    `joining` (m, 3) are the cubes of what lies between them and the wall of the facade, and `upright` (k, 3)
    those of other walls.
    """
    at, shape = points.cube, tuple(points.cube.max(0) + 1)
    flat = np.ravel_multi_index(tuple(at.T), shape)
    beside = _around(joining, at.max(0) + 1)
    near = points.xyz[:, 1] > -TOUCH_M
    joins = np.ones_like(near)
    if upright is not None:
        by_wall = _touched(_around(upright, at.max(0) + 1))
        by_wall |= _behind(upright, at.max(0) + 1)
        beside |= by_wall
        near |= by_wall[tuple(at.T)]
        joins = ~near  # what is so near such a wall joins nothing to it
    filled = np.zeros(shape, bool)
    filled[tuple(at[joins].T)] = True
    number, _ = ndimage.label(filled, _TOUCHES)
    if not joins.all():
        number = np.where(filled, number, ndimage.grey_dilation(number, footprint=_TOUCHES))
    mine = number[tuple(at.T)]
    order = np.argsort(mine, kind="stable")[np.count_nonzero(mine == 0) :]
    out = []
    for index in np.split(order, np.flatnonzero(np.diff(mine[order])) + 1):
        if joins[index].sum() < FEWEST_POINTS or np.ptp(points.xyz[index, 2]) < _SMALLEST_M:
            continue
        first = index[np.unique(flat[index], return_index=True)[1]]
        stands = points.height[index].min() < _ABOVE_GROUND_M
        held = first[near[first]]
        joined = (not stands or beside[tuple(at[held].T)].mean() > _JOINED) if len(held) else False
        if near[first].mean() < (_TOUCHING if stands else _HELD) or not joined:
            out.append(points.at(index[joins[index]]))
    return out


def _around(cubes: Int, shape: Int) -> Bool:
    """Which cubes of a grid of this shape are, or touch, the given ones (m, 3), which may lie outside."""
    found = np.zeros(tuple(shape + 2), np.bool_)
    inside = ((cubes >= -1) & (cubes <= shape)).all(1)
    found[tuple(cubes[inside].T + 1)] = True
    return _touched(found)[1:-1, 1:-1, 1:-1]


def _touched(cubes: Bool) -> Bool:
    """The given cubes of a grid (i, j, k) and all that touch them, axis after axis."""
    for axis in range(3):
        before = np.swapaxes(cubes, 0, axis)
        grown = before.copy()
        grown[1:] |= before[:-1]
        grown[:-1] |= before[1:]
        cubes = np.swapaxes(grown, 0, axis)
    return cubes


def _behind(cubes: Int, shape: Int) -> Bool:
    """Which cubes of a grid of this shape lie right before walls, which fill `cubes` (m, 3), or behind them.

    A bay encloses a part of the building. Its windows are gaps in the wall that are closed, and at its
    corners what touches it may hide a cube of it.
    """
    deep = np.iinfo(np.int64).max
    first = np.full((shape[0], shape[2]), deep)
    inside = ((cubes >= 0) & (cubes < shape)).all(1)
    x, y, z = cubes[inside].T
    np.minimum.at(first, (x, z), y)
    wide = np.pad(first < deep, _WINDOW_CUBES)
    closed = ndimage.binary_closing(wide, np.ones((_WINDOW_CUBES, _WINDOW_CUBES), np.bool_))
    closed = ndimage.binary_dilation(closed, np.ones((3, 3), np.bool_))
    closed = closed[_WINDOW_CUBES:-_WINDOW_CUBES, _WINDOW_CUBES:-_WINDOW_CUBES]
    first = ndimage.minimum_filter(first, _WINDOW_CUBES + 2, mode="constant", cval=deep)
    return np.asarray(closed[:, None] & (np.arange(shape[1])[:, None] >= first[:, None] - 2))
