"""The points that may hide a facade from a photo: everything on its street side."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int, picked_rows
from frontage.model import Facade, Scan
from frontage.ortho.cloud import in_facade_frame
from frontage.ortho.options import OrthoOptions
from frontage.ortho.railings import Beams, find_railings
from frontage.ortho.standing.find import Standing
from frontage.raster.zbuffer import local_spacing

_FEWEST_TOGETHER = 3  # points in one cube of the cloud below which they are noise and hide nothing
_COLUMN_M = 2.0  # of the facade, across which the spacing of beams hardly changes
_CUBE_M = 0.04  # of which one point is enough: what photos see is told on cells of that size
_PLACES = 1 << 22  # of a table of cubes, many more than a facade fills

Spaced = tuple[Array, Array]
"""Points (n, 3) float32 m in the facade frame, axis by axis in memory, and the spacing (n,) float32 m of the
surface of each."""


@dataclass(frozen=True, eq=False)
class OccluderCloud:
    """What may hide the facade: its own parts, and what stands free before it.

    Of the latter, `solid` are things without gaps, such as cars and people, and `light` are the others.
    """

    part: Spaced
    light: Spaced
    solid: Spaced


def find_occluders(
    facade: Facade,
    xyz_facade: Float,
    standing: Standing,
    surroundings: Scan | None,
    options: OrthoOptions,
    scan: Scan | None = None,
) -> OccluderCloud:
    """Returns the points in front of the back of the facade with their local spacing.

    Lone points are left out, and so are railings, which are part of the picture and show what is behind them.
    `xyz_facade` (n, 3) m is the scan of the facade in its frame. Free are the points of what is `standing`
    before it, however near, and all points so far before it that they are no part of it, but for those of
    walls: the wall of a neighbour stays, and it may have the colour of this one. The `scan` itself, if given,
    tells where its beams came from, and which of them passed between the bars of a railing.
    """
    clouds = [(xyz_facade, scan)]
    if surroundings is not None:
        clouds.append((in_facade_frame(surroundings, facade), surroundings))
    xyz, spacing, lines, beams = [], [], [], Beams.of(None, facade, np.zeros(0, np.int64))
    for points, measured in clouds:
        near = points[:, 1] < options.back
        ahead = picked_rows(near, points)
        kept = _one_of_each_cube(ahead)
        s, k = local_spacing(ahead, of=kept)
        many = k >= _FEWEST_TOGETHER
        kept, s, k = kept[many], s[many], k[many]
        xyz.append(np.take(ahead.T, kept, axis=1).T.astype(np.float32))
        spacing.append(s)
        lines.append(_in_lines(xyz[-1], s, k))
        beams = beams.and_those(Beams.of(measured, facade, np.flatnonzero(near)[kept]))
    every = np.concatenate([points.T for points in xyz], axis=1).T
    gap = np.maximum(np.concatenate(spacing), _CUBE_M).astype(np.float32)
    free, solid, walls = standing.parted(every)
    free |= (every[:, 1] < -options.front) & ~walls
    solid &= free
    part = ~free & np.concatenate(lines)
    part &= walls | ~find_railings(every, beams, part)
    return OccluderCloud(*((picked_rows(which, every), gap[which]) for which in (part, free & ~solid, solid)))


def _in_lines(xyz: Array, spacing: Float, together: Float) -> Bool:
    """Which points (n, 3) are as many in a cube as a line of beams through it has, given the `spacing` (n,).

    A part of a facade returns a line of beams at least; fewer are stray echoes. The spacing of beams is the
    geometric mean of that of all points before 2 x 2 m of the facade.
    """
    if not len(xyz):
        return np.zeros(0, np.bool_)
    x, z = (np.floor(a / _COLUMN_M).astype(np.int64) for a in (xyz[:, 0], xyz[:, 2]))
    column = (z - z.min()) * (int(np.ptp(x)) + 1) + x - x.min()
    usual = np.bincount(column, np.log(spacing)) / np.maximum(np.bincount(column), 1)
    # `together` points in a cube with edges of spacing sqrt(together): edge / usual of them are a line.
    return np.asarray(spacing <= np.exp(usual)[column] * np.sqrt(together))


def _one_of_each_cube(xyz: Float) -> Int:
    """Which (k,) of the points (n, 3) stand for the cubes that they fill, one for nearly each."""
    if not len(xyz):
        return np.zeros(0, np.int64)
    # The plane of the facade runs through the middle of its cubes, so that one layer of them holds the wall.
    (x, across), (y, _), (z, up) = (_numbered(axis) for axis in xyz.T)
    cube = y.astype(np.int64)
    cube *= up
    cube += z
    cube *= across
    cube += x
    # A table with a place for several cubes: where two cubes meet, one of them keeps all of its points.
    place, number = cube & (_PLACES - 1), np.arange(len(cube), dtype=np.int32)
    last = np.zeros(_PLACES, np.int32)
    last[place] = number
    found = last[place]
    return np.flatnonzero((found == number) | (cube[found] != cube))


def _numbered(axis: Array) -> tuple[Array, int]:
    """The cubes (n,), counted from 0 on, into which coordinates (n,) m of an axis fall, and their number."""
    at = axis * np.float32(1.0 / _CUBE_M)
    at += np.float32(0.5 - np.floor(float(at.min()) + 0.5))
    number = at.astype(np.int32)  # none is negative
    return number, int(number.max()) + 1
