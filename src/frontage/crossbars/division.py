"""A window divided by bars: the bars, what they gain, and which pieces of them belong together."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.crossbars.lines import MULLIONS_M

SAME_M = 0.05  # by which a bar may be displaced and still be the same
STEPPED = 60.0  # nats more where a bar goes on beside itself beyond another one, which joiners do not do
_JOINED_M = 0.03  # by which pieces of one bar may lie apart on both sides of a crossing
_BESIDE_M = 0.09  # between the axes of pieces that are too close to be two bars


@dataclass(frozen=True)
class Line:
    """A bar of a layout: axis 0 upright or 1, centre, extent (both ends), width, all m; evidence nats."""

    axis: int
    position: float
    extent: tuple[float, float]
    width: float
    evidence: float


@dataclass(frozen=True)
class Layout:
    """Bars, with their evidence less what it costs to describe them, nats.

    gain    of the whole layout
    gains   of every bar
    rivals  of the best bar that a pane could have had, negative; none where nothing speaks for one
    """

    lines: tuple[Line, ...] = ()
    gain: float = 0.0
    gains: tuple[float, ...] = ()
    rivals: tuple[float, ...] = ()

    def with_bar(self, line: Line, gain: float) -> "Layout":
        """Returns the layout with one more bar, and what it gains."""
        return Layout((*self.lines, line), self.gain + gain, (*self.gains, gain), self.rivals)

    def beside(self, other: "Layout", less: float = 0.0) -> "Layout":
        """Returns both layouts of two panes as one, which gains `less` than both."""
        return Layout(
            self.lines + other.lines,
            self.gain + other.gain - less,
            self.gains + other.gains,
            self.rivals + other.rivals,
        )


def joined(lines: Sequence[Line]) -> tuple[Line, ...]:
    """Returns the bars with pieces joined that continue each other across a bar of the other direction."""
    whole: list[Line] = []
    for line in sorted(lines, key=lambda one: (one.axis, one.extent)):
        before = [k for k, one in enumerate(whole) if _continues(one, line)]
        if not before:
            whole.append(line)
            continue
        whole[before[0]] = joined_pieces((whole[before[0]], line))
    return tuple(whole)


def alike(one: Sequence[Line], other: Sequence[Line], ends: float = np.inf) -> bool:
    """Tells whether two layouts of a window have the same bars, whose ends differ by less than `ends` m."""
    a, b = (sorted(joined(lines), key=lambda line: (line.axis, line.position)) for lines in (one, other))
    return len(a) == len(b) and all(
        p.axis == q.axis
        and abs(p.position - q.position) < SAME_M
        and max(abs(x - y) for x, y in zip(p.extent, q.extent, strict=True)) < ends
        for p, q in zip(a, b, strict=True)
    )


def joined_pieces(pieces: Sequence[Line]) -> Line:
    """Returns pieces of one bar as a bar, with the mean of their positions and widths by their lengths."""
    runs = np.array([line.extent[1] - line.extent[0] for line in pieces])
    share = runs / runs.sum()
    return Line(
        pieces[0].axis,
        float(share @ [line.position for line in pieces]),
        (pieces[0].extent[0], pieces[-1].extent[1]),
        float(share @ [line.width for line in pieces]),
        float(sum(line.evidence for line in pieces)),
    )


def stepped(one: Layout, other: Layout) -> float:
    """Returns what bars cost that go on beyond a bar between both layouts, but a little beside it."""
    pairs = ((a, b) for a in one.lines for b in other.lines if a.axis == b.axis)
    beside = (
        abs(a.position - b.position) < _BESIDE_M and not _continues(a, b) and _meet(a, b) for a, b in pairs
    )
    return STEPPED * sum(beside)


def _meet(one: Line, other: Line) -> bool:
    """Tells whether the ends of two bars nearly face each other across one bar."""
    gap = other.extent[0] - one.extent[1]
    return abs(one.position - other.position) < _BESIDE_M and -1e-6 < gap < MULLIONS_M[1]


def _continues(one: Line, other: Line) -> bool:
    gap = other.extent[0] - one.extent[1]
    aligned = abs(one.position - other.position) < max(_JOINED_M, 0.35 * min(one.width, other.width))
    return one.axis == other.axis and aligned and -1e-6 < gap < MULLIONS_M[1]
