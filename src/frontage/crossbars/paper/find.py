"""The published method from windows and photos to crossbars (Becker & Haala 2008, section 3.3)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.crossbars.options import CrossbarOptions
from frontage.crossbars.paper.bars import BAR_WIDTH_M, bars_of_group
from frontage.crossbars.paper.derive import WindowEdges, derive_edges
from frontage.crossbars.paper.neighbours import neighbours
from frontage.crossbars.paper.templates import Division, divide, joined, support
from frontage.crossbars.paper.triangulate import Edges3D
from frontage.crossbars.window import Window
from frontage.geometry.arrays import Float
from frontage.model.glazing import Bar, Glazing

FRAME_WIDTH_M = 0.07
"""Usual width of a window frame, inside of which the panes begin."""

_FEWEST_PX = 3.0  # across a bar, below which its two edges are one
_THIN_BAR_M = 0.03  # width of the thinnest usual bar


def bars_by_edges(windows: Sequence[Window], options: CrossbarOptions) -> list[Glazing]:
    """Returns the glazing of each window by the published method.

    2-D edges of the photos inside each window are matched and triangulated (3.3.1); for windows of one kind,
    the recursive division of the window is tested against the 3-D edges, and what is accepted becomes bars
    (3.3.2). Windows for which no two photos can be compared are not resolved, unless neighbours of the same
    kind are.
    """
    derived = [derive_edges(window, options.min_pane) for window in windows]
    found: dict[int, Glazing] = {}
    for group in neighbours(windows):
        members = [windows[k] for k in group]
        edges = [derived[k] for k in group]
        division, bars = crossbars(members, edges, options.min_pane)
        for k, own in zip(group, bars, strict=True):
            found[k] = _glazing(windows[k], derived[k], division, own, edges)
    return [found[k] for k in range(len(windows))]


def crossbars(
    windows: Sequence[Window], edges: Sequence[WindowEdges], least: float
) -> tuple[Division, list[list[Bar]]]:
    """Returns the division that windows of one kind share, and the bars of each in the facade frame.

    The windows are laid on one another by their middles. A buffer of a third of the least pane on both sides
    of a dividing line takes in both edges of a bar, and the shift between the scan's outlines and the photos.
    """
    middles = [(w.ring.min(0) + w.ring.max(0)) / 2 for w in windows]
    relative = [
        (_moved(e.upright, -m), _moved(e.level, -m[::-1])) for e, m in zip(edges, middles, strict=True)
    ]
    first = windows[0].ring - middles[0]
    buffer = least / 3
    by = tuple(support([r[axis] for r in relative], first, axis, buffer) for axis in (0, 1))
    (x0, z0), (x1, z1) = first.min(0) + FRAME_WIDTH_M, first.max(0) - FRAME_WIDTH_M
    division = divide((x0, z0, x1, z1), (by[0], by[1]), least, BAR_WIDTH_M)
    lines = joined(division.lines, 2 * BAR_WIDTH_M)
    bars = bars_of_group(lines, relative, buffer)
    return division, [[_placed(b, m) for b in own] for own, m in zip(bars, middles, strict=True)]


def _moved(edges: Edges3D, by: Float) -> Edges3D:
    """Returns edges moved by (across, along) m."""
    return replace(edges, across=edges.across + by[0], along=edges.along + by[1])


def _placed(bar: Bar, middle: Float) -> Bar:
    """Returns a bar relative to a window's middle (2,) m in the facade frame."""
    across, along = (float(v) for v in (middle if bar.axis == "vertical" else middle[::-1]))
    return replace(bar, position=bar.position + across, extent=(bar.extent[0] + along, bar.extent[1] + along))


def _glazing(
    window: Window, own: WindowEdges, division: Division, bars: Sequence[Bar], group: Sequence[WindowEdges]
) -> Glazing:
    """Returns the result of one window, and why it is not resolved where it is not."""
    seen = [e for e in group if not e.reason]
    if not seen:
        return Glazing(False, note=own.reason)
    if not bars and min(e.gsd for e in seen) * _FEWEST_PX > _THIN_BAR_M:
        return Glazing(False, sources=own.sources, note="the photos are too coarse to exclude thin bars")
    note = f"taken from windows of the same kind: {own.reason}" if own.reason else ""
    accepted = [line.support for line in division.lines]
    confidence = float(np.clip(min([1 - division.refused, *accepted]), 0, 1))
    depth = own.depth(window.wall_y)
    return Glazing(True, tuple(bars), None, depth, confidence, own.sources, note)
