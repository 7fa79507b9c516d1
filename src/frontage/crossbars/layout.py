"""The most probable division of a window into panes, by dynamic programming over slicing trees.

A pane is whole, or a bar across all of it divides it in two, or several bars divide it in equal parts, or
bars both ways that cross each other divide a sash. Each part is a pane again, so that crosses, fanlights, T
layouts and sashes with bars of their own come out. A bar is worth its evidence over the length of the pane
that it divides, less the nats that it takes to describe it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from frontage.crossbars.candidates import COST, ENDS_M, EQUAL, MOVE_M, Box, Place, candidates
from frontage.crossbars.division import SAME_M, Layout, Line, joined_pieces, stepped
from frontage.crossbars.lines import MULLIONS_M, Bars
from frontage.geometry.arrays import Float

NESTED = 5.0  # nats more for a bar that divides only a part of the window
_GOES_ON = 2.0  # nats to tell how a bar goes on beyond a crossing
_MOST_EQUAL = 6  # bars that divide a pane in equal parts
_EQUAL_M = 0.015  # by which a bar may miss the place that equal panes give it
_WIDE_M = 0.015  # by which panes may be measured too small, because bars show their sides
_SHOWN = 0.4  # share of a bar's length that must be seen
_PANE_SHOWN_M = 0.06  # of the width or height of a pane


def best_layout(
    box: Box,
    bars: Sequence[Bars],
    least: tuple[float, float],
    cost: float = COST,
    without: tuple[int, float] | None = None,
) -> Layout:
    """Returns the best layout of the bars within a box, the inside of the frame.

    bars     the evidence across x and across z
    least    m, least width and height of a pane
    without  axis and position m of a bar that must not be in it, nor be displaced in it
    """
    least = (least[0] - _WIDE_M, least[1] - _WIDE_M)
    found = [candidates(box, one, least, cost) for one in bars]
    if without is not None:
        axis, place = without
        found[axis] = found[axis][np.abs(found[axis] - place) > SAME_M + MOVE_M]
    return _Search(box, bars, tuple(found), least, cost).best(box, (_FRAME,) * 4)


_Sides = tuple[int, int, int, int]
"""Numbers of the candidates at the sides of a pane, in the order of `Box`; FRAME where none is."""
_FRAME = -1
_Spans = tuple[tuple[float, float], ...]
"""Both ends m of the pieces of a bar."""
_Key = tuple[int, int, int, int, _Spans]
"""Axis of a candidate, numbers of those at its ends, its own number, and its pieces."""
_Crossing = tuple[int, Line, tuple[Line, ...]]
"""A bar of a grid: the number of its candidate, the bar as a whole, and its pieces."""


@dataclass
class _Search:
    """The search over one window; remembers the best layout of every pane.

    A pane is known by the candidates at its sides. A candidate lies some millimetres elsewhere along another
    piece of its length; were each of these a pane of its own, there would be no end of panes.
    """

    whole: Box
    bars: Sequence[Bars]
    places: tuple[Float, ...]
    least: tuple[float, float]
    cost: float
    known: dict[tuple[_Sides, int], Layout] = field(default_factory=dict)
    lines: dict[_Key, Line | None] = field(default_factory=dict)
    shown: dict[tuple[int, int, int], bool] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.around = [
            [Place.near(bars, place) for place in places.tolist()]
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
            if axis == uncut or box[2 + axis] - box[axis] < 2 * self.least[axis]:
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
        if sides[0] == sides[2] == _FRAME:
            found = self._grid(box, sides)
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
        if min(low[2 + axis] - low[axis], high[2 + axis] - high[axis]) < self.least[axis]:
            return None
        if not (self._seen(low, axis) and self._seen(high, axis)):
            return None
        gain = line.evidence - self._cost(box)
        if line.evidence <= 0.0:
            return None
        below, above = _divided(sides, axis, k)
        first, second = self.best(low, below, uncut=axis), self.best(high, above)
        return first.beside(second, stepped(first, second)).with_bar(line, gain)

    def _seen(self, pane: Box, axis: int) -> bool:
        """Tells whether anything of a pane shows; if not, the bar may be a sill or a reveal that hides it."""
        low, high = pane[axis], pane[2 + axis]
        return self.bars[1 - axis].shown(low, high) * (high - low) > _PANE_SHOWN_M

    def _equal(self, box: Box, sides: _Sides, axis: int, count: int) -> Layout | None:
        """Returns the division of a pane by `count` bars into panes of one size; None if it has none."""
        low, high = box[axis], box[2 + axis]
        if (high - low) / (count + 1) < self.least[axis]:
            return None
        wanted = low + (high - low) * np.arange(1, count + 1) / (count + 1)
        places = self.places[axis]
        if len(places) < count:
            return None
        near = np.abs(places[None, :] - wanted[:, None])
        chosen = near.argmin(1).tolist()
        if near.min(1).max() > _EQUAL_M + MOVE_M or len(set(chosen)) < count:
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
            if min(part[2 + axis] - part[axis], rest[2 + axis] - rest[axis]) < self.least[axis]:
                return None
            inner = self.best(part, below, uncut=axis)
            inner = inner.with_bar(line, line.evidence - self._cost(box) + EQUAL)
            layout = layout.beside(inner, stepped(layout, inner))
        last = self.best(rest, around, uncut=axis)
        return layout.beside(last, stepped(layout, last))

    def _grid(self, box: Box, sides: _Sides) -> Layout | None:
        """Returns the division of a sash by upright bars and transoms that cross; None if it has none.

        A bar that goes on beyond a crossing is described once. Its pieces may lie a little beside each other.
        """
        upright = self._crossing(box, sides, 0, ())
        level = self._crossing(box, sides, 1, [line for _, line, _ in upright])
        upright = self._crossing(box, sides, 0, [line for _, line, _ in level]) if level else []
        if not upright or not level:
            return None
        layout = Layout()
        for _, _, pieces in (*upright, *level):
            for n, piece in enumerate(pieces):
                layout = layout.with_bar(piece, piece.evidence - (_GOES_ON if n else self._cost(box)))
        for part, around in _cells(box, sides, upright, level):
            layout = layout.beside(self.best(part, around))
        return layout

    def _crossing(self, box: Box, sides: _Sides, axis: int, across: Sequence[Line]) -> list[_Crossing]:
        """Returns the candidates that are worth their cost along a pane, in pieces between bars across."""
        ends = sorted((line.position - line.width / 2, line.position + line.width / 2) for line in across)
        cuts = [box[1 - axis], *(z for pair in ends for z in pair), box[3 - axis]]
        spans = tuple(zip(cuts[::2], cuts[1::2], strict=True))
        found: list[_Crossing] = []
        for k in range(len(self.places[axis])):
            lines = self._straight_or_bent(box, sides, axis, k, spans)
            if sum(line.evidence for line in lines) - _GOES_ON * (len(lines) - 1) > self._cost(box):
                found.append((k, joined_pieces(lines), lines))
        kept: list[_Crossing] = []
        for one in sorted(found, key=lambda one: -one[1].evidence):
            line = one[1]
            others = [(other.position, other.width) for _, other, _ in kept]
            others += [(box[axis], 0.0), (box[2 + axis], 0.0)]
            if min(abs(line.position - x) - (line.width + w) / 2 for x, w in others) >= self.least[axis]:
                kept.append(one)
        return sorted(kept, key=lambda one: one[1].position)

    def _straight_or_bent(
        self, box: Box, sides: _Sides, axis: int, k: int, spans: _Spans
    ) -> tuple[Line, ...]:
        """Returns a bar with one place on all spans, or one of its own on each, as is better; () for none."""
        straight = self._line(box, sides, axis, k, spans)
        pieces = [self._line(box, sides, axis, k, (span,)) for span in spans]
        bent = tuple(piece for piece in pieces if piece is not None)
        gain = sum(piece.evidence - _GOES_ON for piece in bent) + _GOES_ON
        if len(bent) == len(pieces) and (straight is None or gain > straight.evidence):
            return bent
        return () if straight is None else (straight,)

    def _line(self, box: Box, sides: _Sides, axis: int, k: int, spans: _Spans = ()) -> Line | None:
        """Returns a candidate as it is within one pane, or on spans of it; None if it is not shown there."""
        ends = (axis, sides[1 - axis], sides[3 - axis])
        key = (*ends, k, spans)
        if key not in self.lines:
            low, high = box[1 - axis], box[3 - axis]
            if ends not in self.shown:
                self.shown[ends] = self.bars[axis].shown(low, high) >= _SHOWN
            whole = spans or ((low, high),)
            self.lines[key] = self._estimated(ends, k, whole) if self.shown[ends] else None
        line = self.lines[key]
        if line is None or not box[axis] < line.position < box[2 + axis]:
            return None
        return line

    def _estimated(self, ends: tuple[int, int, int], k: int, spans: _Spans) -> Line | None:
        """Returns a candidate on spans m of a pane, which has the sides `ends` there."""
        axis = ends[0]
        bars, place = self.bars[axis], self.around[axis][k]
        value = -place.cost
        for low, high in spans:
            value = value + bars.over(low + ENDS_M, max(high - ENDS_M, low + ENDS_M), place.rows)
        if ends[1:] != (_FRAME, _FRAME):  # mullions part whole windows
            value = np.where(bars.widths * bars.px > MULLIONS_M[0], -np.inf, value)
        if not np.isfinite(value.max()):
            return None
        middle, width, evidence = bars.settled(value, place.centre)
        return Line(axis, middle, (spans[0][0], spans[-1][1]), width, evidence)


def _cells(
    box: Box, sides: _Sides, upright: Sequence[_Crossing], level: Sequence[_Crossing]
) -> Iterator[tuple[Box, _Sides]]:
    """The panes of a grid, each with its sides."""
    right, beyond = box, sides
    for n in range(len(upright) + 1):
        column, of_column = right, beyond
        if n < len(upright):
            column, right = _parts(right, 0, upright[n][1])
            of_column, beyond = _divided(beyond, 0, upright[n][0])
        for m in range(len(level) + 1):
            cell, around = column, of_column
            if m < len(level):
                cell, column = _parts(column, 1, level[m][1])
                around, of_column = _divided(of_column, 1, level[m][0])
            yield cell, around


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
