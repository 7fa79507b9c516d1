"""How far a bar reaches: across as far as it looks like the frame, along as far as there is glass.

A post between two casements consists of three pieces, the post and a stile on either side, with edges and
shadows between them. Its layout may rest on one of these pieces. Whatever looks as much like the frame as the
piece that was found, up to where panes begin, belongs to it.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from shapely import LineString, Polygon
from shapely.geometry.base import BaseGeometry

from frontage.crossbars.division import Line
from frontage.crossbars.observe import Observation
from frontage.geometry.arrays import Array

_FARTHEST_M = 0.11  # beyond the piece that was found
_CONTRAST = 0.5  # nats by which panes must look less like the frame than a bar
_CROSSING_M = 0.01  # beside crossing bars
_SIDE_M = 0.045  # depth of the side face of a post, which looks like the frame, too
_LEAST_M = 0.008  # by which a bar goes on, if it does


def whole_bars(seen: Observation, lines: Sequence[Line]) -> list[Line]:
    """Returns bars that reach across as far as they look like the frame."""
    return [_whole(seen, line, lines) if seen.like else line for line in lines]


def _whole(seen: Observation, line: Line, lines: Sequence[Line]) -> Line:
    grid, like = seen.sight.grid, seen.like[line.axis]
    size = grid.shape[line.axis] * grid.px / len(like)
    along = grid.start(1 - line.axis) + (np.arange(len(like)) + 0.5) * size
    used = (along > line.extent[0]) & (along < line.extent[1])
    for other in lines:
        if other.axis != line.axis:
            used &= np.abs(along - other.position) > other.width / 2 + _CROSSING_M
    if used.sum() < 2:
        return line
    profile = like[used].mean(0)
    at = grid.centres(line.axis)
    low, high = line.position - line.width / 2, line.position + line.width / 2
    inside = float(profile[(at > low) & (at < high)].mean())
    tilt = [float(view.tilt[line.axis]) for view in seen.sight.views]
    low -= _beyond(_farther(profile[at < low][::-1], inside, grid.px), min(tilt))
    high += _beyond(_farther(profile[at > high], inside, grid.px), -max(tilt))
    return replace(line, position=(low + high) / 2, width=high - low)


def _beyond(reach: float, tilt: float) -> float:
    """Returns how far m a bar goes on, when it looks so for `reach` m.

    On the side that is turned to all cameras, where `tilt` is positive, its side face shows beside it.
    """
    side = _SIDE_M * max(tilt, 0.0)
    return reach - 0.5 * side if reach > side + _LEAST_M else 0.0


def _farther(profile: Array, inside: float, px: float) -> float:
    """Returns how far m a bar goes on along a profile that begins at its edge; 0 where no pane begins."""
    near = profile[: round(_FARTHEST_M / px)]
    if len(near) < 3 or inside - float(near.min()) < _CONTRAST:
        return 0.0
    pane = np.flatnonzero(near < 0.5 * (inside + float(near.min())))
    return float(pane[0] * px)


def within_frame(seen: Observation, lines: Sequence[Line]) -> list[Line]:
    """Returns bars that end at the frame also where the head of the window is not level.

    The frame reaches equally far in from the outline all around: as far as at the sides and below.
    """
    window = seen.sight.window
    if window.opening.shape == "rectangle":
        return list(lines)
    low, high = window.ring.min(0), window.ring.max(0)
    inset = float(np.median([seen.box[0] - low[0], high[0] - seen.box[2], seen.box[1] - low[1]]))
    glass = Polygon(window.ring).buffer(-max(inset, 0.0), join_style="mitre")
    return [_cut(line, glass) for line in lines]


def _cut(line: Line, glass: BaseGeometry) -> Line:
    """Returns the part of a bar before the glass; all of it where its middle line meets none."""
    ends = [(line.position, end)[:: 1 if line.axis == 0 else -1] for end in line.extent]
    part = LineString(ends).intersection(glass)
    if part.is_empty:
        return line
    bounds = part.bounds
    return replace(line, extent=(bounds[1 - line.axis], bounds[3 - line.axis]))
