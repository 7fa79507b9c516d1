"""A peer for window bars: straight segments of the best view (OpenCV's LSD) vote for lines across it."""

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from frontage.crossbars import CrossbarOptions, FoundBars, Window
from frontage.model import Bar, Elements, Glazing

_PIXEL_M = 0.003
_LEAST_M = 0.06  # shorter segments do not vote
_SLANT = np.tan(np.radians(5.0))
_FRAME_M = 0.12  # of the border, where edges are those of the frame
_REACH = 0.5  # share of the window's height or width that an edge must have
_WIDTHS_M = (0.015, 0.16)  # of bars
_DEPTH_M = 0.12  # of the frame where the opening has none


def bars_by_segments(elements: Elements, windows: Sequence[Window], options: CrossbarOptions) -> FoundBars:
    """Bars where two edges of enough votes are as far apart as a bar is wide; all run from side to side."""
    found = {w.opening.id: _glazing(w) for w in windows}
    openings = tuple(replace(o, glazing=found.get(o.id, o.glazing)) for o in elements.openings)
    return FoundBars(replace(elements, openings=openings), ())


def _glazing(window: Window) -> Glazing:
    if not window.views:
        return Glazing(False, note="no photo shows it")
    view = min(window.views, key=lambda v: v.gsd / max(v.cosine, 0.05))
    (x0, z0), (x1, z1) = window.ring.min(0), window.ring.max(0)
    depth = _DEPTH_M if window.opening.depth is None else float(window.opening.depth.value)
    x, z = np.arange(x0, x1, _PIXEL_M) + _PIXEL_M / 2, np.arange(z1, z0, -_PIXEL_M) - _PIXEL_M / 2
    grid = np.stack(np.meshgrid(x, z), axis=-1).reshape(-1, 2)
    points = np.column_stack([grid[:, 0], np.full(len(grid), window.wall_y + depth), grid[:, 1]])
    at = (view.project(window.frame, points) - 0.5).reshape(len(z), len(x), 2).astype(np.float32)
    grey = cv2.cvtColor(cv2.remap(view.pixels, at, None, cv2.INTER_LINEAR), cv2.COLOR_RGB2GRAY)
    lines = cv2.createLineSegmentDetector().detect(grey)[0]
    ends = np.empty((0, 4)) if lines is None else lines.reshape(-1, 4) * _PIXEL_M
    bars = []
    for axis, across, low, high, a, b in (("vertical", 0, x0, x1, z0, z1), ("horizontal", 1, z0, z1, x0, x1)):
        along = 1 - across
        run = np.abs(ends[:, along + 2] - ends[:, along])
        straight = (np.abs(ends[:, across + 2] - ends[:, across]) < _SLANT * run) & (run > _LEAST_M)
        middle = (ends[straight, across] + ends[straight, across + 2]) / 2
        place = middle + x0 if axis == "vertical" else z1 - middle
        edges = _edges(place, run[straight], low, high, _REACH * (b - a))
        bars += [Bar(axis, (p + q) / 2, (float(a), float(b)), q - p, 0.005) for p, q in edges]
    return Glazing(True, tuple(bars), None, window.opening.depth, 0.5, (view.photo.id,))


def _edges(
    place: np.ndarray, votes: np.ndarray, low: float, high: float, least: float
) -> list[tuple[float, float]]:
    """Pairs of neighbouring lines (m) whose votes, the lengths of their segments, suffice."""
    bins = np.arange(low, high + 0.01, 0.01)
    sums = np.convolve(np.histogram(place, bins, weights=votes)[0], np.ones(3), "same")
    peak = (sums >= least) & (sums >= np.roll(sums, 1)) & (sums > np.roll(sums, -1))
    lines = (bins[:-1] + 0.005)[peak]
    lines = lines[(lines > low + _FRAME_M) & (lines < high - _FRAME_M)]
    pairs, k = [], 0
    while k + 1 < len(lines):
        if _WIDTHS_M[0] <= lines[k + 1] - lines[k] <= _WIDTHS_M[1]:
            pairs.append((float(lines[k]), float(lines[k + 1])))
            k += 1
        k += 1
    return pairs
