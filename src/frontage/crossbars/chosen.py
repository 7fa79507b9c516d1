"""The layout of a window, and what it is worth in another window of its type."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.crossbars.candidates import COST, ENDS_M, Box
from frontage.crossbars.division import Layout, Line
from frontage.crossbars.lines import Bars
from frontage.crossbars.observe import Observation
from frontage.geometry.arrays import Array, Float

_MOVE_M = 0.01  # by which a bar may miss its place in the layout of its type
_ELSEWHERE_M = 0.12  # by which a transom may for the nats of a bar of its own, where the scan alone shows it
_SHIFTS_M = tuple(np.arange(-5, 6) * 0.01)  # by which all parallel bars may: outlines are displaced
_WIDTH = 0.4  # by which the width of a bar may differ, logarithm


@dataclass(frozen=True, eq=False)
class Chosen:
    """The layout of a window.

    seen    its evidence, with the box inside the frame that is used
    bars    the evidence that the layout was chosen by: on one plane, or on those of two sashes
    least   m, least width and height of a pane
    pooled  the lines that only similar windows decide
    meeting m (z) below which bars are those of a lower sash, on the deeper plane; None = one plane
    alone   the layout that its own evidence would choose
    kin     number that windows with one layout, decided together, have in common; None = decided on its own
    members number of the windows of a scan that share the layout
    beyond  nats by which that layout is better for it than its own one and than the other ones of its type
    sure    nats by which it is better than the next one for all windows that share it, where only the scan
            shows them and there are two or more; None otherwise
    """

    seen: Observation
    bars: Sequence[Bars]
    layout: Layout
    least: tuple[float, float]
    pooled: tuple[Line, ...] = ()
    meeting: float | None = None
    alone: Layout | None = None
    kin: int | None = None
    members: int = 1
    beyond: float = np.inf
    sure: float | None = None


def fit(model: Chosen, member: Chosen) -> list[Line]:
    """Returns the bars of one window at their places in another one, with the evidence there."""
    rings = [one.seen.sight.window.ring for one in (model, member)]
    start, own = (ring.min(0) for ring in rings)
    scale = np.ptp(rings[1], axis=0) / np.ptp(rings[0], axis=0)
    moved = [_moved(line, start, own, scale) for line in model.layout.lines]
    shift = [_best_shift(member.bars[a], [line for line in moved if line.axis == a]) for a in (0, 1)]
    found = [(member.bars[line.axis], line, shift[line.axis]) for line in moved]
    if member.seen.sight.views:
        return [_estimated(*one) for one in found]
    return [_scanned(*one, member.seen.box) for one in found]


def _moved(line: Line, start: Float, own: Float, scale: Float) -> Line:
    def at(value: float, axis: int) -> float:
        return float(own[axis] + (value - start[axis]) * scale[axis])

    extent = (at(line.extent[0], 1 - line.axis), at(line.extent[1], 1 - line.axis))
    return Line(line.axis, at(line.position, line.axis), extent, line.width, 0.0)


def _best_shift(bars: Bars, lines: Sequence[Line]) -> float:
    """Returns the common displacement m of parallel bars that suits the evidence best."""
    total = [sum(_estimated(bars, line, shift).evidence for line in lines) for shift in _SHIFTS_M]
    return float(_SHIFTS_M[int(np.argmax(total))])


def _estimated(bars: Bars, line: Line, shift: float, reach: float = _MOVE_M) -> Line:
    """Returns a displaced bar where the evidence is best near its place; there, if nothing shows it."""
    place = line.position + shift
    low, high = bars.rows(place, reach)
    away: Array = np.abs(np.log(bars.widths * bars.px / line.width))
    value = bars.over(line.extent[0] + ENDS_M, line.extent[1] - ENDS_M, slice(low, high))
    centre = bars.centres(low, high)
    near = (np.abs(centre - place) <= reach) & (away <= max(_WIDTH, float(away.min())))
    value = np.where(near, value, -np.inf)
    best = float(value.max())
    if best <= 0.0:
        return replace(line, position=place, evidence=best if np.isfinite(best) else 0.0)
    middle, width, best = bars.settled(value, centre)
    return Line(line.axis, middle, line.extent, width, best)


def _scanned(bars: Bars, line: Line, shift: float, box: Box) -> Line:
    """Returns the same where the scan alone tells it: sashes of one type may be open or divided higher.

    They slide up and down, so that upright bars stay where they are. What lies in the frame of this window,
    outside the box, is no evidence of a bar.
    """
    found = _estimated(bars, line, shift)
    if line.axis == 1:
        other = _estimated(bars, line, shift, _ELSEWHERE_M)
        dearer = replace(other, evidence=other.evidence - COST)
        found = dearer if dearer.evidence > found.evidence else found
    within = box[line.axis] < found.position < box[2 + line.axis]
    return found if within else replace(found, evidence=min(found.evidence, 0.0))
