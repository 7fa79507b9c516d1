"""The most probable division of a window into panes, by dynamic programming over slicing trees.

A pane is whole, or a bar across all of it divides it in two, or several bars divide it in equal parts.
Each part is a pane again, so that crosses, fanlights, T layouts and sashes with bars of their own come
out. A bar is worth its evidence over the length of the pane that it divides, less the nats that it takes
to describe it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from frontage.crossbars.division import Layout, Line, stepped
from frontage.crossbars.lines import MULLIONS_M, Bars
from frontage.geometry.arrays import Array, Float

COST = 9.0  # nats of a bar: its position and width, the direction of the split, the choice among candidates
NESTED = 5.0  # nats more for a bar that divides only a part of the window
EQUAL = 3.0  # nats less for a bar whose position follows from equal panes
MULLION = 6.0  # nats more for a bar as wide as a mullion between coupled windows
MOST_LINES = 11  # candidates per axis
_ENDS_M = 0.01  # at both ends of a bar, where other bars cross
_MOVE_M = 0.02  # by which a line may move when it is estimated again within one pane
_MOST_EQUAL = 6  # bars that divide a pane in equal parts
_EQUAL_M = 0.015  # by which a bar may miss the place that equal panes give it
_MEETING = (0.3, 0.7)  # share of a window's height at which its sashes meet
_RAIL_M = 0.02  # half a meeting rail
_MOST_RAILS = 2  # that are tried, the strongest
_WIDE_M = 0.015  # by which panes may be measured too small, because bars show their sides
_SHOWN = 0.4  # share of a bar's length that must be seen


Box = tuple[float, float, float, float]
"""x0, z0, x1, z1 m of a pane."""


def best_layout(
    box: Box,
    bars: Sequence[Bars],
    least: float,
    cost: float = COST,
    without: tuple[int, float] | None = None,
) -> Layout:
    """Returns the best layout of the bars within a box, the inside of the frame.

    bars     the evidence across x and across z
    least    m, least width and height of a pane
    without  axis and position m of a bar that must not be in it
    """
    least -= _WIDE_M
    found = [candidates(box, one, least, cost) for one in bars]
    if without is not None:
        axis, place = without
        found[axis] = found[axis][np.abs(found[axis] - place) > _MOVE_M]
    return _Search(box, bars, tuple(found), least, cost).best(box, (_FRAME,) * 4)


def candidates(box: Box, bars: Bars, least: float, cost: float) -> Float:
    """Returns the positions (k,) m of the lines that any pane may want, the strongest first.

    A line counts by its best piece among the whole length and its parts.
    """
    low, high = box[1 - bars.axis], box[3 - bars.axis]
    best = np.full(bars.total.shape[1:], -np.inf, np.float32)
    for parts in (1, 2, 3, 4, 6):
        size = (high - low) / parts
        if parts > 1 and size < least:
            break
        for first in np.arange(low, high - size + 1e-6, size / 2):
            best = np.maximum(best, bars.over(first + _ENDS_M, first + size - _ENDS_M))
    best = best - _mullion_cost(bars)
    strength = best.max(1)
    centre = bars.centre(np.arange(len(strength)), best.argmax(1))
    inside = (centre > box[bars.axis] + least / 2) & (centre < box[2 + bars.axis] - least / 2)
    strength = np.where(inside, strength, -np.inf)
    places: list[float] = []
    for k in np.argsort(-strength, kind="stable"):
        if strength[k] < cost - EQUAL or len(places) == MOST_LINES:
            break
        if all(abs(centre[k] - p) > 2.2 * _MOVE_M for p in places):
            places.append(float(centre[k]))
    return np.array(places)


def _mullion_cost(bars: Bars) -> Array:
    return np.where(bars.widths * bars.px > MULLIONS_M[0], MULLION, 0.0).astype(np.float32)


_Sides = tuple[int, int, int, int]
"""Numbers of the candidates at the sides of a pane, in the order of `Box`; FRAME where none is."""
_FRAME = -1


@dataclass(frozen=True, eq=False)
class _Place:
    """Where a candidate may lie: rows of the evidence, with centres and costs (r, w) of bars there."""

    rows: slice
    centre: Array
    cost: Array

    @staticmethod
    def near(bars: Bars, place: float) -> "_Place":
        """The rows about a place m; bars that lie farther from it cost too much."""
        first, last = bars.rows(place, _MOVE_M)
        centre = bars.centres(first, last)
        cost = np.where(np.abs(centre - place) <= _MOVE_M, _mullion_cost(bars), np.inf)
        return _Place(slice(first, last), centre, cost)


@dataclass
class _Search:
    """The search over one window; remembers the best layout of every pane.

    A pane is known by the candidates at its sides. A candidate lies some millimetres elsewhere along another
    piece of its length; were each of these a pane of its own, there would be no end of panes.
    """

    whole: Box
    bars: Sequence[Bars]
    places: tuple[Float, ...]
    least: float
    cost: float
    known: dict[tuple[_Sides, int], Layout] = field(default_factory=dict)
    lines: dict[tuple[int, int, int, int], Line | None] = field(default_factory=dict)
    shown: dict[tuple[int, int, int], bool] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.around = [
            [_Place.near(bars, place) for place in places.tolist()]
            for bars, places in zip(self.bars, self.places, strict=True)
        ]

    def best(self, box: Box, sides: _Sides, uncut: int = -1) -> Layout:
        """Returns the best layout of a pane, whose first split is not along axis `uncut`.

        Splits by parallel bars come from left to right, so that every layout is met only once.
        """
        key = (sides, uncut)
        if key in self.known:
            return self.known[key]
        best, rival = Layout(), -np.inf
        for axis in (0, 1):
            if axis == uncut or box[2 + axis] - box[axis] < 2 * self.least:
                continue
            places = self.places[axis]
            inside = np.flatnonzero((places > box[axis]) & (places < box[2 + axis])).tolist()
            for k in inside:
                found = self._split(box, sides, axis, k)
                rival = max(rival, found.gain if found is not None else rival)
                if found is not None and found.gain > best.gain:
                    best = found
            for count in range(1, min(len(inside), _MOST_EQUAL) + 1):
                found = self._equal(box, sides, axis, count)
                if found is not None and found.gain > best.gain:
                    best = found
        if not best.lines:
            best = Layout(rivals=(rival,) if rival > -self.cost else ())
        self.known[key] = best
        return best

    def _cost(self, box: Box) -> float:
        return self.cost if box == self.whole else self.cost + NESTED

    def _split(self, box: Box, sides: _Sides, axis: int, k: int) -> Layout | None:
        line = self._line(box, sides, axis, k)
        if line is None:
            return None
        low, high = _parts(box, axis, line)
        if min(low[2 + axis] - low[axis], high[2 + axis] - high[axis]) < self.least:
            return None
        gain = line.evidence - self._cost(box)
        if line.evidence <= 0.0:
            return None
        below, above = _divided(sides, axis, k)
        first, second = self.best(low, below, uncut=axis), self.best(high, above)
        return first.beside(second, stepped(first, second)).with_bar(line, gain)

    def _equal(self, box: Box, sides: _Sides, axis: int, count: int) -> Layout | None:
        """Returns the division of a pane by `count` bars into panes of one size; None if it has none."""
        low, high = box[axis], box[2 + axis]
        if (high - low) / (count + 1) < self.least:
            return None
        wanted = low + (high - low) * np.arange(1, count + 1) / (count + 1)
        places = self.places[axis]
        if len(places) < count:
            return None
        near = np.abs(places[None, :] - wanted[:, None])
        chosen = near.argmin(1).tolist()
        if near.min(1).max() > _EQUAL_M + _MOVE_M or len(set(chosen)) < count:
            return None
        lines = [self._line(box, sides, axis, k) for k in chosen]
        if any(
            line is None or abs(line.position - at) > _EQUAL_M for line, at in zip(lines, wanted, strict=True)
        ):
            return None
        layout, rest, around = Layout(), box, sides
        for k, line in zip(chosen, lines, strict=True):
            assert line is not None
            part, rest = _parts(rest, axis, line)
            below, around = _divided(around, axis, k)
            if part[2 + axis] - part[axis] < self.least or rest[2 + axis] - rest[axis] < self.least:
                return None
            inner = self.best(part, below, uncut=axis)
            inner = inner.with_bar(line, line.evidence - self._cost(box) + EQUAL)
            layout = layout.beside(inner, stepped(layout, inner))
        last = self.best(rest, around, uncut=axis)
        return layout.beside(last, stepped(layout, last))

    def _line(self, box: Box, sides: _Sides, axis: int, k: int) -> Line | None:
        """Returns a candidate as it is within one pane; None if it is not shown there."""
        ends = (axis, sides[1 - axis], sides[3 - axis])
        key = (*ends, k)
        if key not in self.lines:
            low, high = box[1 - axis], box[3 - axis]
            if ends not in self.shown:
                self.shown[ends] = self.bars[axis].shown(low, high) >= _SHOWN
            self.lines[key] = self._estimated(ends, k, low, high) if self.shown[ends] else None
        line = self.lines[key]
        if line is None or not box[axis] < line.position < box[2 + axis]:
            return None
        return line

    def _estimated(self, ends: tuple[int, int, int], k: int, low: float, high: float) -> Line | None:
        """Returns a candidate along a pane from `low` to `high` m, which has the sides `ends` there."""
        axis = ends[0]
        bars, place = self.bars[axis], self.around[axis][k]
        value = bars.over(low + _ENDS_M, high - _ENDS_M, place.rows) - place.cost
        if ends[1:] != (_FRAME, _FRAME):  # mullions part whole windows
            value = np.where(bars.widths * bars.px > MULLIONS_M[0], -np.inf, value)
        if not np.isfinite(value.max()):
            return None
        middle, width, evidence = bars.settled(value, place.centre)
        return Line(axis, middle, (low, high), width, evidence)


def _parts(box: Box, axis: int, line: Line) -> tuple[Box, Box]:
    """Returns the panes on both sides of a bar, the lower one first."""
    low, high = list(box), list(box)
    low[2 + axis] = line.position - line.width / 2
    high[axis] = line.position + line.width / 2
    return (low[0], low[1], low[2], low[3]), (high[0], high[1], high[2], high[3])


def _divided(sides: _Sides, axis: int, k: int) -> tuple[_Sides, _Sides]:
    """Returns the sides of the panes below and above a candidate."""
    below, above = list(sides), list(sides)
    below[2 + axis] = above[axis] = k
    return (below[0], below[1], below[2], below[3]), (above[0], above[1], above[2], above[3])


def meeting_places(box: Box, rail: Bars, least: float) -> Float:
    """Returns the heights (k,) m, in the middle of a window, below which a lower sash may hang.

    rail  the evidence of transoms that reach from the plane of one sash to that of the other
    """
    places = candidates(box, rail, least, COST)
    share = (places - box[1]) / (box[3] - box[1])
    return np.asarray(places[(share > _MEETING[0]) & (share < _MEETING[1])][:_MOST_RAILS] - _RAIL_M)
