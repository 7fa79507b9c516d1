"""Working clouds: what one building's task needs of the whole street, and no more."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.ndimage import distance_transform_edt

from frontage.geometry.arrays import Bool, Float, Int, distinct, drawn, extent, sorted_groups
from frontage.model import Scan

REACH = 15.0  # m; across a street: what can hide a facade, and the ground it stands on
_CELL = 1.0  # m; plan cells for finding neighbours
_MANY = 1_000_000  # surrounding points above which they are thinned
_SOME = 10_000  # points of a building that tell where it is seen
_BLOCK_POINTS = 16384  # points at a time, so that a block stays in the processor's cache
_VOXEL = 0.05  # m; finer than a lamp post or a branch, which is what surroundings are for


def around(scans: Sequence[Scan], margin: float) -> tuple[float, ...]:
    """The box in plan (x0, y0, x1, y1), m world, of scans in one world, `margin` m wider on every side."""
    low = np.min([s.xyz.min(0) for s in scans], axis=0)
    high = np.max([s.xyz.max(0) for s in scans], axis=0)
    low, high = scans[0].world.to_world(low - margin), scans[0].world.to_world(high + margin)
    return (float(low[0]), float(low[1]), float(high[0]), float(high[1]))


def thin(xyz: Float, voxel: float) -> Int:
    """Indices (k,) int64, ascending, of one point in every voxel of `voxel` m, whatever the points' order.

    It is the one least in x, and of those the one least in y and z.
    """
    if not len(xyz):
        return np.empty(0, np.int64)
    order, start = sorted_groups(_voxel_of(xyz, voxel))
    x = xyz[order, 0]
    size = np.diff(start, append=len(x))
    least = np.flatnonzero(x == np.repeat(np.minimum.reduceat(x, start), size))
    group, rows = np.repeat(np.arange(len(start)), size)[least], order[least]
    first = np.diff(group, prepend=-1) > 0
    tied = np.bincount(group)[group] > 1
    by = np.lexsort((xyz[rows[tied], 2], xyz[rows[tied], 1], group[tied]))
    rows[tied] = rows[tied][by]  # groups stay where they are
    return np.sort(rows[first])


def _voxel_of(xyz: Float, voxel: float) -> Int:
    """The number (n,) of the voxel, `voxel` m wide, of every point (n, 3) m."""
    number = np.zeros(len(xyz), np.int64)
    for axis, low, high in zip(xyz.T, *extent(xyz), strict=True):
        number *= int((high - low) / voxel) + 1
        for start in range(0, len(axis), _BLOCK_POINTS):
            step = axis[start : start + _BLOCK_POINTS] - low
            step /= voxel
            number[start : start + _BLOCK_POINTS] += step.astype(np.int64)  # truncates, as all are >= 0
    return number


def thin_to(xyz: Float, voxel: float, most: int = 3_000_000) -> Int:
    """Like `thin`, with the voxel grown by half until at most `most` points remain."""
    index = thin(xyz, voxel)
    while len(index) > most:
        voxel *= 1.5
        index = index[thin(xyz[index], voxel)]
    return index


class Neighbourhoods:
    """Plan cells of a cloud, sorted once, so that the surroundings of one building cost what they hold."""

    def __init__(self, xyz: Float) -> None:
        self._xyz = xyz
        x, y = (_steps(xyz[:, axis], np.floor(xyz[:, axis].min()) - REACH - 2 * _CELL) for axis in (0, 1))
        self._rows = int(y.max()) + 2 * int(REACH / _CELL) + 8
        x *= self._rows
        x += y
        self._cell = x
        self._order, _ = sorted_groups(x)
        self._sorted = x[self._order]

    def thinned(self, index: Int) -> Int:
        """Returns those of the points (n,) that remain when the whole cloud is thinned to 5 cm."""
        return index[self._remains[index]]

    @cached_property
    def _remains(self) -> Bool:
        """Which points (n,) remain. As many plan cells as hold a million points are thinned at a time."""
        remains = np.zeros(len(self._order), np.bool_)
        first = np.flatnonzero(np.diff(self._sorted, prepend=-1))
        start = 0
        while start < len(remains):
            after = int(np.searchsorted(first, start + _MANY))
            stop = int(first[after]) if after < len(first) else len(remains)
            rows = self._order[start:stop]
            remains[rows[thin(np.take(self._xyz, rows, axis=0), _VOXEL)]] = True
            start = stop
        return remains

    def around(self, index: Int, reach: float = REACH) -> Int:
        """Indices (k,) ascending of all points in plan cells within `reach` m of those at `index`."""
        own = np.column_stack(np.divmod(distinct(self._cell[index]), self._rows))
        margin = int(np.ceil(reach / _CELL)) + 1
        low = own.min(0) - margin
        near = np.ones(tuple(own.max(0) - low + margin + 1), bool)
        near[tuple((own - low).T)] = False
        cells = np.argwhere(distance_transform_edt(near) * _CELL <= reach) + low
        flat = cells[:, 0] * self._rows + cells[:, 1]
        start, stop = (
            np.searchsorted(self._sorted, flat, "left"),
            np.searchsorted(self._sorted, flat, "right"),
        )
        count = stop - start
        place = np.arange(count.sum())
        place += np.repeat(start - (np.cumsum(count) - count), count)
        held = np.zeros(len(self._order), bool)
        held[self._order[place]] = True
        return np.flatnonzero(held)


def _steps(axis: Float, low: float) -> Int:
    """The number (n,) of the plan cell, counted from `low` m, that every coordinate (n,) m lies in."""
    step = axis - low
    step /= _CELL
    return step.astype(np.int64)


def working_cloud(scan: Scan, neighbourhoods: Neighbourhoods, index: Int) -> tuple[Scan, Int]:
    """One building's points and its surroundings within `REACH`, and which of them are its own (ascending).

    The building keeps every point; surroundings of more than a million points are thinned to 5 cm. Of the
    beams without return those that look at the building stay.
    """
    own = np.zeros(len(scan), bool)
    own[index] = True
    near = neighbourhoods.around(index)
    other = near[~own[near]]
    if len(other) > _MANY:
        other = neighbourhoods.thinned(other)
    held = own.copy()
    held[other] = True
    kept = np.flatnonzero(held)
    some = np.take(scan.xyz, index, axis=0)
    some = some[drawn(some, _SOME)]
    lost = tuple(n.towards(some - scan.origins[n.origin]) for n in scan.no_returns)
    return replace(scan.take(kept), no_returns=lost), np.flatnonzero(own[kept])
