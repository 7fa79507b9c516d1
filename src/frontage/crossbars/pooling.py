"""Windows of one type share their frame and their layout, unless their own evidence speaks against it.

The paper assumes that windows of similar size in a row or column are divided alike (section 3.3). Here this
is decided by what it takes to describe them: a layout that several windows of one size share is told once,
so that a window which shows little takes it over, and a window that differs clearly keeps its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.crossbars.alike import types
from frontage.crossbars.candidates import COST, meeting_places
from frontage.crossbars.division import Layout, Line
from frontage.crossbars.layout import best_layout
from frontage.crossbars.lines import Bars
from frontage.crossbars.observe import Observation
from frontage.geometry.arrays import Array, Float

_FRAMES = 3  # windows that tell the frame of their type together
_MOVE_M = 0.01  # by which a bar may miss its place in the layout of its type
_ELSEWHERE_M = 0.12  # by which it may for the nats of a bar of its own, where the scan alone shows it
_SHIFTS_M = tuple(np.arange(-5, 6) * 0.01)  # by which all parallel bars may: outlines are displaced
_ENDS_M = 0.01  # at both ends of a bar, where other bars cross
_WIDTH = 0.4  # by which the width of a bar may differ, logarithm
_SHARED = 1.0  # nats to say that a window is like the others
# Nats to say that it is not: one window in fifty, and a nat of evidence counts for a tenth of one (`judge`).
_OWN = 45.0
_OWN_SCANNED = 20.0  # the same of a scan, whose points have fewer errors in common than views
_SASHES = 4.0  # nats to say that the lower part of a window lies behind the upper one


@dataclass(frozen=True, eq=False)
class Chosen:
    """The layout of a window.

    seen    its evidence, with the box inside the frame that is used
    bars    the evidence that the layout was chosen by: on one plane, or on those of two sashes
    pooled  the lines that only similar windows decide
    meeting m (z) below which bars are those of a lower sash, on the deeper plane; None = one plane
    alone   the layout that its own evidence would choose
    kin     number that windows with one layout, decided together, have in common; None = decided on its own
    beyond  nats by which the layout of its type is better for it than its own one
    """

    seen: Observation
    bars: Sequence[Bars]
    layout: Layout
    pooled: tuple[Line, ...] = ()
    meeting: float | None = None
    alone: Layout | None = None
    kin: int | None = None
    beyond: float = np.inf


def choose_layouts(observed: Sequence[Observation], least: float) -> list[Chosen]:
    """Returns the layouts of windows, those of one type decided together.

    least  m, least width and height of a pane
    """
    found: dict[int, Chosen] = {}
    for group in types([seen.sight for seen in observed]):
        alike = _with_one_frame([observed[k] for k in group])
        own = [_alone(seen, least) for seen in alike]
        found |= zip(group, _of_type(own, group[0]) if len(own) > 1 else own, strict=True)
    return [found[k] for k in range(len(observed))]


def _with_one_frame(observed: Sequence[Observation]) -> list[Observation]:
    """Returns windows of one type whose frames reach equally far in from each side of their outlines.

    A scan alone shows other sides of every window: those that the reveal does not hide.
    """
    if len(observed) < _FRAMES or not any(seen.sight.views for seen in observed):
        return list(observed)
    corners = np.array([[*s.sight.window.ring.min(0), *s.sight.window.ring.max(0)] for s in observed])
    inset = np.median(np.array([s.box for s in observed]) - corners, axis=0)
    boxes = (corners + inset).tolist()
    return [replace(s, box=(b[0], b[1], b[2], b[3])) for s, b in zip(observed, boxes, strict=True)]


def _alone(seen: Observation, least: float) -> Chosen:
    """Returns the layout that a window would have on its own, on one plane or with a lower sash behind."""
    best = Chosen(seen, seen.bars, best_layout(seen.box, seen.bars, least))
    if seen.behind is not None and seen.rail is not None:
        both = list(zip(seen.bars, seen.behind, strict=True))
        for place in meeting_places(seen.box, seen.rail, least):
            bars = [front.with_sash(back, seen.rail, place) for front, back in both]
            layout = best_layout(seen.box, bars, least)
            if layout.gain - _SASHES > best.layout.gain:
                best = Chosen(seen, bars, layout, meeting=float(place))
    return best


def _of_type(own: Sequence[Chosen], kin: int) -> list[Chosen]:
    """Returns the layouts of windows of one type, by the layout of one of them that serves all best.

    kin  the number of the type
    """
    best, most = list(own), -np.inf
    for model in own:
        fitted = [fit(model, member) for member in own]
        gains = np.array([sum(line.evidence for line in lines) for lines in fitted]) - _SHARED
        alone = np.array([one.layout.gain - _own_cost(one) for one in own])
        total = float(np.maximum(gains, alone).sum()) - COST * len(model.layout.lines)
        if total > most:
            most = total
            rows = zip(own, fitted, (gains - alone).tolist(), strict=True)
            best = [
                replace(_shared(a, model, b), kin=kin, beyond=more) if more >= 0 else a for a, b, more in rows
            ]
    return best


def _own_cost(one: Chosen) -> float:
    return _OWN if one.seen.sight.views else _OWN_SCANNED


def _shared(own: Chosen, model: Chosen, lines: Sequence[Line]) -> Chosen:
    """Returns a window with the layout of its type, as far as its own evidence places the bars."""
    if own is model:
        return own
    gains = tuple(line.evidence - COST for line in lines)
    weak = tuple(line for line, gain in zip(lines, gains, strict=True) if gain < 0)
    kept = tuple(max(gain, other) for gain, other in zip(gains, model.layout.gains, strict=True))
    costs = sum(line.evidence for line in model.layout.lines) - model.layout.gain
    gain = sum(line.evidence for line in lines) - costs
    layout = Layout(tuple(lines), gain, kept, model.layout.rivals)
    return Chosen(own.seen, own.bars, layout, weak, own.meeting, own.layout)


def fit(model: Chosen, member: Chosen) -> list[Line]:
    """Returns the bars of one window at their places in another one, with the evidence there."""
    rings = [one.seen.sight.window.ring for one in (model, member)]
    start, own = (ring.min(0) for ring in rings)
    scale = np.ptp(rings[1], axis=0) / np.ptp(rings[0], axis=0)
    moved = [_moved(line, start, own, scale) for line in model.layout.lines]
    shift = [_best_shift(member.bars[a], [line for line in moved if line.axis == a]) for a in (0, 1)]
    estimated = _estimated if member.seen.sight.views else _scanned
    return [estimated(member.bars[line.axis], line, shift[line.axis]) for line in moved]


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
    value = bars.over(line.extent[0] + _ENDS_M, line.extent[1] - _ENDS_M, slice(low, high))
    centre = bars.centres(low, high)
    near = (np.abs(centre - place) <= reach) & (away <= max(_WIDTH, float(away.min())))
    value = np.where(near, value, -np.inf)
    best = float(value.max())
    if best <= 0.0:
        return replace(line, position=place, evidence=best if np.isfinite(best) else 0.0)
    middle, width, best = bars.settled(value, centre)
    return Line(line.axis, middle, line.extent, width, best)


def _scanned(bars: Bars, line: Line, shift: float) -> Line:
    """Returns the same where the scan alone tells it: sashes of one type may be open or divided higher."""
    near, other = (_estimated(bars, line, shift, reach) for reach in (_MOVE_M, _ELSEWHERE_M))
    dearer = replace(other, evidence=other.evidence - COST)
    return dearer if dearer.evidence > near.evidence else near
