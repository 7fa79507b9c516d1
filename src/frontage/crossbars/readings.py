"""Where single photos show the edges of the bars that were found.

The layout is chosen from evidence that tolerates some millimetres between views. What the views say one by
one is read afterwards, so that bars are placed by an adjustment, and their disagreement tells how well.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from frontage.crossbars.division import Line
from frontage.crossbars.rectify import Grid, PlaneView, WallView
from frontage.geometry.arrays import Array, Float

_REACH_M = 0.015  # about the expected edge in which it is looked for
_NEAR_M = 0.008  # one sigma of its distance from there
_BAND_M = 0.06  # along a bar, in which steps of one sign are added
_CROSSING_M = 0.015  # beside a crossing bar that is left out
_SHOWN = 0.7  # share of a band that must show the window
_LEAST_BANDS = 2
_LEAST_STEP = 1.5  # of 255: mean step of an edge that shows


@dataclass(frozen=True, eq=False)
class Readings:
    """Edges of bars in single views, all arrays (m,).

    bar, view  numbers
    side       -1 the lower edge, 1 the higher one
    at         m, on the plane that was looked at
    """

    bar: Array
    view: Array
    side: Array
    at: Float

    def some(self, kept: Array) -> "Readings":
        """Returns the readings that a mask (m,) keeps."""
        return Readings(self.bar[kept], self.view[kept], self.side[kept], self.at[kept])

    def and_more(self, other: "Readings") -> "Readings":
        """Returns these readings and others of the same bars and views."""
        pairs = ((self.bar, other.bar), (self.view, other.view), (self.side, other.side), (self.at, other.at))
        bar, view, side, at = (np.concatenate(pair) for pair in pairs)
        return Readings(bar, view, side, at)


def read_edges(
    grid: Grid, mask: Array, views: Sequence[WallView], lines: Sequence[Line], depths: Sequence[float]
) -> Readings:
    """Returns the edges of bars in every view, each on the plane at the depth m of its bar.

    mask  the outline's, see `rectify.outline_mask`
    """
    rows = []
    for v, view in enumerate(views):
        planes = {d: PlaneView.of(grid, view, d, mask) for d in set(depths)}
        for k, line in enumerate(lines):
            strength = _strength(grid, planes[depths[k]], line, lines)
            for side in (-1, 1):
                at = _peak(grid, line, strength, line.position + side * line.width / 2)
                if at is not None:
                    rows.append((k, v, side, at))
    table = np.array(rows, np.float64).reshape(-1, 4)
    bar, seen_in, side = table[:, :3].astype(np.int64).T
    return Readings(bar, seen_in, side, table[:, 3])


def _strength(grid: Grid, plane: PlaneView, line: Line, lines: Sequence[Line]) -> Float | None:
    """Returns the mean steps (n,) of colour across a bar, added along it whatever their signs."""
    image, inside = plane.grey, plane.inside
    if line.axis == 1:
        image, inside = image.T, inside.T
    along = grid.centres(1 - line.axis)
    used = (along > line.extent[0] + _CROSSING_M) & (along < line.extent[1] - _CROSSING_M)
    for other in lines:
        if other.axis != line.axis:
            used &= np.abs(along - other.position) > other.width / 2 + _CROSSING_M
    bands = round(int(used.sum()) * grid.px / _BAND_M)
    if bands < _LEAST_BANDS:
        return None
    size = (image.shape[1], bands)
    shown = cv2.resize(np.ascontiguousarray(inside[used]), size, interpolation=cv2.INTER_AREA)
    mean = cv2.resize(np.ascontiguousarray(image[used] * inside[used]), size, interpolation=cv2.INTER_AREA)
    known = shown > _SHOWN
    step = np.zeros_like(mean)
    mean /= np.maximum(shown, 1e-3)
    step[:, 1:-1] = np.abs(mean[:, 2:] - mean[:, :-2]) * (known[:, 2:] & known[:, :-2])
    count = known.sum(0)
    return np.where(count >= _LEAST_BANDS, step.sum(0) / np.maximum(count, 1), 0.0)


def _peak(grid: Grid, line: Line, strength: Float | None, expected: float) -> float | None:
    """Returns the coordinate m of the strongest edge near where it is expected; None without one."""
    if strength is None:
        return None
    at = grid.centres(line.axis)
    reach = min(_REACH_M, 0.45 * line.width + grid.px)
    near = np.flatnonzero(np.abs(at - expected) <= reach)
    near = near[(near > 0) & (near < len(at) - 1)]
    peaks = near[(strength[near] >= strength[near - 1]) & (strength[near] > strength[near + 1])]
    if not len(peaks):
        return None
    likely = strength[peaks] * np.exp(-0.5 * ((at[peaks] - expected) / _NEAR_M) ** 2)
    k = int(peaks[likely.argmax()])
    a, b, c = strength[k - 1 : k + 2]
    if b < _LEAST_STEP:
        return None
    return float(at[k] + 0.5 * grid.px * (a - c) / (a - 2 * b + c))
