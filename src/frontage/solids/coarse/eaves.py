"""Cleans a facade's outline: upright sides, a level foot, and eaves of few straight segments.

The measured outline is ragged: chimneys, tanks and plants stand up from it, shadows are cut out of it. The
eaves are the best sequence of segments, level or as steep as a roof, found by dynamic programming over
columns (Bellman 1961). The cost is the sum of absolute distances, on which anything narrower than half a
segment has no influence, plus a price per segment.
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

LEVEL_M = 0.3  # mean deviation of a level line that comes from the raster of cells and from gutters
_NARROWEST_M = 3.0  # the narrowest facade of a house or of its wing
_ROOF_SLOPES = (0.27, 1.73)  # of a verge, 15 to 60 degrees; flatter is level eaves seen badly, steeper a side
_COLUMN_M = 0.1  # width of the columns in which the upper outline is looked up
_MOST_COLUMNS = 80  # that the segments are chosen from; narrower columns are joined
_NEAR_BREAK_M = 1.0  # two slopes meet where they cross, if that is this close to the break between them
_HIDDEN_FOOT_M = 3.0  # an outline that ends this far above the ground was hidden below, not in the air
_SMALLEST_STEP_M = 0.05  # a smaller step between two segments is levelled


@dataclass(frozen=True)
class _Segment:
    """The line z = height + slope x from column `first` on, in metres."""

    first: int
    height: float
    slope: float

    def at(self, x: Float | float) -> Any:
        """Returns the height (m) at x (m)."""
        return self.height + self.slope * x


def clean_outline(facade: Facade, ground_z: float) -> Float:
    """Returns the facade's clean outline (k, 2) m (x, z), counter-clockwise from the left end of its foot.

    The foot is moved down to the ground `ground_z` (m local, nan if unknown) where that is near.
    """
    polygon = shapely.make_valid(Polygon(facade.outline))
    x0, foot, x1, top = polygon.bounds
    ground = float((ground_z - facade.frame.t[2]) / facade.frame.R[2, 2])
    if np.isfinite(ground) and foot - _HIDDEN_FOOT_M < ground:
        foot = min(foot, ground)
    edges = np.linspace(x0, x1, max(2, int(np.ceil((x1 - x0) / _COLUMN_M))) + 1)
    x = (edges[1:] + edges[:-1]) / 2
    columns = shapely.linestrings([[(v, foot - 1), (v, top + 1)] for v in x])
    upper = shapely.bounds(shapely.intersection(columns, polygon))[:, 3]
    known = np.isfinite(upper)
    line = fit_eaves(x[known], upper[known], (x0, x1))
    line[:, 1] = np.clip(line[:, 1], foot + LEVEL_M, max(top, foot + LEVEL_M))
    return np.concatenate([[[x0, foot], [x1, foot]], line[::-1]])


def fit_eaves(x: Float, upper: Float, ends: tuple[float, float]) -> Float:
    """Fits the eaves (k, 2) m (x, z), from left to right, to columns at x (n,) m with tops `upper` (n,) m."""
    joined = -(-len(x) // _MOST_COLUMNS)
    starts = np.arange(0, len(x), joined)
    parts = [slice(s, s + joined) for s in starts]
    middle = np.array([x[p].mean() for p in parts])
    segments = _best_segments(middle, np.array([np.median(upper[p]) for p in parts]), ends[1] - ends[0])
    line = [(ends[0], segments[0].at(ends[0]))]
    for a, b in itertools.pairwise(segments):
        first = int(starts[b.first])
        near = slice(max(first - joined, 1) - 1, min(first + joined, len(x) - 1) + 1)
        line += _joint(_break(x[near], upper[near], a, b), a, b)
    return np.array([*line, (ends[1], segments[-1].at(ends[1]))], np.float64)


def _best_segments(x: Float, z: Float, width: float) -> list[_Segment]:
    """Returns the cheapest sequence of segments over columns x (n,), z (n,) m, from left to right."""
    n = len(x)
    column = width / n
    price = min(MASONRY.room_width * MASONRY.room_height / 2, LEVEL_M * width)
    shortest = max(1, int(np.ceil(min(_NARROWEST_M, width / 3) / column)))
    best, via = np.full(n + 1, np.inf), np.zeros(n + 1, np.int64)
    best[0] = 0.0
    costs, heights, slopes = np.full((n + 1, n), np.inf), np.zeros((n + 1, n)), np.zeros((n + 1, n))
    for length in range(min(shortest, n), n + 1):
        own = length, slice(n - length + 1)
        costs[own], heights[own], slopes[own] = _fit_segments(x, z, length)
    for end in range(1, n + 1):
        starts = np.arange(end)
        total = best[:end] + costs[end - starts, starts] * column + price
        via[end] = int(np.argmin(total))
        best[end] = total[via[end]]
    segments, end = list[_Segment](), n
    while end > 0:
        first = int(via[end])
        segments.append(
            _Segment(first, float(heights[end - first, first]), float(slopes[end - first, first]))
        )
        end = first
    return segments[::-1]


def _fit_segments(x: Float, z: Float, length: int) -> tuple[Array, Array, Array]:
    """Fits a segment to every run of `length` columns: cost, height at x = 0 and slope of each.

    The cost is the sum of absolute distances. A segment is level at the median, or Tukey's resistant line
    through the medians of the outer thirds where that is as steep as a roof and fits better.
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
    roof_like = (np.abs(slope) > _ROOF_SLOPES[0]) & (np.abs(slope) < _ROOF_SLOPES[1])
    better = roof_like & (sloping < cost)
    return np.where(better, sloping, cost), np.where(better, base, height), np.where(better, slope, 0.0)


def _break(x: Float, upper: Float, a: _Segment, b: _Segment) -> float:
    """Returns the x (m), between columns x (k,) with tops `upper` (k,) m, where segment a best ends."""
    left, right = np.abs(upper - a.at(x)), np.abs(upper - b.at(x))
    split = 1 + int(np.argmin(np.cumsum(left)[:-1] + right.sum() - np.cumsum(right)[:-1]))
    return float(x[split - 1] + x[split]) / 2


def _joint(at: float, a: _Segment, b: _Segment) -> list[tuple[float, float]]:
    """Returns the vertices where two segments meet: their crossing if that is near, else an upright step."""
    if a.slope != b.slope:
        cross = (b.height - a.height) / (a.slope - b.slope)
        if abs(cross - at) < _NEAR_BREAK_M:
            return [(cross, float(a.at(cross)))]
    left, right = float(a.at(at)), float(b.at(at))
    stepped = abs(left - right) > _SMALLEST_STEP_M
    return [(at, left), (at, right)] if stepped else [(at, (left + right) / 2)]
