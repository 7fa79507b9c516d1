"""A facade's outline as a building has it: upright sides, a level foot, and its eaves in few pieces.

The measured outline is ragged: chimneys, tanks and plants stand up from it, shadows are cut out of it. The
eaves are the best sequence of pieces, level or as steep as a roof, by dynamic programming over columns
(Bellman 1961): the sum of absolute distances, which what is narrower than half a piece cannot move, and a
price for every piece.
"""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.lib.stride_tricks import sliding_window_view
from shapely.geometry import Polygon

from frontage.geometry.arrays import Array, Float
from frontage.model import Facade
from frontage.model.masonry import MASONRY

LEVEL = 0.3  # m: what a raster of cells and a gutter make of a level line, in the mean over it
_NARROW = 3.0  # m: the narrowest front of a house or of its wing
# slope of a verge, 15 to 60 degrees: flatter ones are level eaves seen badly, steeper ones sides
_ROOF = (0.27, 1.73)
_COLUMN = 0.1  # m: columns in which the upper outline is looked up
_MOST = 80  # of them, joined to wider ones, that the pieces are chosen from
_MEET = 1.0  # m beside a break where two slopes that cross there meet
_FOOT = 3.0  # m: an outline that ends so far above the ground was hidden below, not in the air


@dataclass(frozen=True)
class _Piece:
    """The line z = height + slope x from column `first` on."""

    first: int
    height: float
    slope: float

    def at(self, x: Float | float) -> Any:
        """Height m at x m."""
        return self.height + self.slope * x


def clean_outline(facade: Facade, ground_z: float) -> Float:
    """The facade's outline (k, 2) m (x, z), counter-clockwise from the left end of its foot.

    `ground_z` m local, nan = not known; the foot is the ground, where that is known and near.
    """
    polygon = shapely.make_valid(Polygon(facade.outline))
    x0, foot, x1, top = polygon.bounds
    ground = float((ground_z - facade.frame.t[2]) / facade.frame.R[2, 2])
    if np.isfinite(ground) and foot - _FOOT < ground:
        foot = min(foot, ground)
    edges = np.linspace(x0, x1, max(2, int(np.ceil((x1 - x0) / _COLUMN))) + 1)
    x = (edges[1:] + edges[:-1]) / 2
    columns = shapely.linestrings([[(v, foot - 1), (v, top + 1)] for v in x])
    upper = shapely.bounds(shapely.intersection(columns, polygon))[:, 3]
    known = np.isfinite(upper)
    line = eaves(x[known], upper[known], (x0, x1))
    line[:, 1] = np.clip(line[:, 1], foot + LEVEL, max(top, foot + LEVEL))
    return np.concatenate([[[x0, foot], [x1, foot]], line[::-1]])


def eaves(x: Float, upper: Float, ends: tuple[float, float]) -> Float:
    """The eaves (k, 2) m (x, z) from left to right over columns at x (n,) m with tops (n,) m."""
    joined = -(-len(x) // _MOST)
    starts = np.arange(0, len(x), joined)
    parts = [slice(s, s + joined) for s in starts]
    middle = np.array([x[p].mean() for p in parts])
    pieces = _chosen(middle, np.array([np.median(upper[p]) for p in parts]), ends[1] - ends[0])
    breaks = [_break(x, upper, a, b, int(starts[b.first]), joined) for a, b in itertools.pairwise(pieces)]
    line = [(ends[0], pieces[0].at(ends[0]))]
    for at, (a, b) in zip(breaks, itertools.pairwise(pieces), strict=True):
        line += _joint(at, a, b)
    return np.array([*line, (ends[1], pieces[-1].at(ends[1]))], np.float64)


def _chosen(x: Float, z: Float, width: float) -> list[_Piece]:
    """The cheapest sequence of pieces over columns x (n,), z (n,) m, from left to right."""
    n = len(x)
    column = width / n
    price = min(MASONRY.room_width * MASONRY.room_height / 2, LEVEL * width)
    shortest = max(1, int(np.ceil(min(_NARROW, width / 3) / column)))
    best, via = np.full(n + 1, np.inf), np.zeros(n + 1, np.int64)
    best[0] = 0.0
    costs, heights, slopes = np.full((n + 1, n), np.inf), np.zeros((n + 1, n)), np.zeros((n + 1, n))
    for length in range(min(shortest, n), n + 1):
        own = length, slice(n - length + 1)
        costs[own], heights[own], slopes[own] = _fitted(x, z, length)
    for end in range(1, n + 1):
        starts = np.arange(end)
        total = best[:end] + costs[end - starts, starts] * column + price
        via[end] = int(np.argmin(total))
        best[end] = total[via[end]]
    pieces, end = list[_Piece](), n
    while end > 0:
        first = int(via[end])
        pieces.append(_Piece(first, float(heights[end - first, first]), float(slopes[end - first, first])))
        end = first
    return pieces[::-1]


def _fitted(x: Float, z: Float, length: int) -> tuple[Array, Array, Array]:
    """Sum of absolute distances, height at x = 0 and slope of all pieces of so many columns.

    Level at the median; or Tukey's resistant line, through the medians of the outer thirds, where it is as
    steep as a roof and fits better.
    """
    xs, zs = sliding_window_view(x, length), sliding_window_view(z, length)
    height = np.median(zs, axis=1)
    cost = np.abs(zs - height[:, None]).sum(1)
    third = length // 3
    if third < 1:
        return cost, height, np.zeros(len(cost))
    run = xs[:, -third:].mean(1) - xs[:, :third].mean(1)
    slope = (np.median(zs[:, -third:], axis=1) - np.median(zs[:, :third], axis=1)) / run
    rest = zs - slope[:, None] * xs
    base = np.median(rest, axis=1)
    sloping = np.abs(rest - base[:, None]).sum(1)
    better = (np.abs(slope) > _ROOF[0]) & (np.abs(slope) < _ROOF[1]) & (sloping < cost)
    return np.where(better, sloping, cost), np.where(better, base, height), np.where(better, slope, 0.0)


def _break(x: Float, upper: Float, a: _Piece, b: _Piece, near: int, reach: int) -> float:
    """Where between fine columns, `reach` to either side of column `near`, the one piece ends best."""
    low, high = max(near - reach, 1), min(near + reach, len(x) - 1)
    own = slice(low - 1, high + 1)
    left, right = np.abs(upper[own] - a.at(x[own])), np.abs(upper[own] - b.at(x[own]))
    split = low + int(np.argmin(np.cumsum(left)[:-1] + right.sum() - np.cumsum(right)[:-1]))
    return float(x[split - 1] + x[split]) / 2


def _joint(at: float, a: _Piece, b: _Piece) -> list[tuple[float, float]]:
    """The vertices where two pieces meet: where their lines cross, if that is near; else an upright step."""
    if a.slope != b.slope:
        cross = (b.height - a.height) / (a.slope - b.slope)
        if abs(cross - at) < _MEET:
            return [(cross, float(a.at(cross)))]
    left, right = float(a.at(at)), float(b.at(at))
    return [(at, left), (at, right)] if abs(left - right) > 0.05 else [(at, (left + right) / 2)]
