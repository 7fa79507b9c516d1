"""Windows of one type share their frame and their layout, unless their own evidence speaks against it.

The paper assumes that windows of similar size in a row or column are divided alike (section 3.3). Here this
is decided by what it takes to describe them: a layout that several windows of one size share is told once,
so that a window which shows little takes it over, and a window that differs clearly keeps its own.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.crossbars.alike import types
from frontage.crossbars.candidates import meeting_places
from frontage.crossbars.chosen import Chosen
from frontage.crossbars.layout import best_layout
from frontage.crossbars.observe import Observation
from frontage.crossbars.sharing import with_shared_layouts

_FRAMES = 3  # windows that tell the frame of their type together
# Of the least height of a pane, its least width in photos: bottom rails are high, stiles narrow. In a scan
# the groove between a stile and the frame looks like a narrow pane.
_NARROW = 0.75
_SASHES = 4.0  # nats to say that the lower part of a window lies behind the upper one


def choose_layouts(observed: Sequence[Observation], least: float) -> list[Chosen]:
    """Returns the layouts of windows, those of one type decided together.

    least  m, least height of a pane
    """
    found: dict[int, Chosen] = {}
    for group in types([seen.sight for seen in observed]):
        alike = _with_one_frame([observed[k] for k in group])
        own = [_alone(seen, least) for seen in alike]
        found |= zip(group, with_shared_layouts(own, group) if len(own) > 1 else own, strict=True)
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
    """Returns the layout that a window has on its own, on one plane or with a lower sash behind."""
    sides = (_NARROW * least if seen.sight.views else least, least)
    best = Chosen(seen, seen.bars, best_layout(seen.box, seen.bars, sides), sides)
    if seen.behind is not None and seen.rail is not None:
        both = list(zip(seen.bars, seen.behind, strict=True))
        for place in meeting_places(seen.box, seen.rail, least):
            bars = [front.with_sash(back, seen.rail, place) for front, back in both]
            layout = best_layout(seen.box, bars, sides)
            if layout.gain - _SASHES > best.layout.gain:
                best = Chosen(seen, bars, layout, sides, meeting=float(place))
    return best
