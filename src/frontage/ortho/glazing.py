"""Finds the glazed openings of a relief and the planes of their frames, where the scan got little back.

A laser passes through glass, and what returns from behind it (curtains, furniture, the far wall) is not the
facade. The frame is: it stands around the glass, within the thickness of the wall, and its bars cross the
glass. In an opening, everything without a surface of its own therefore lies on the plane of the frame. Drawn
on the wall or on a curtain instead, bars would tear and frames appear twice.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.ortho.recess import DEEPEST_REVEAL_M, solid_cells
from frontage.raster import gridding

_WALL_M2 = 3.0  # a continuous surface larger than a door leaf (2 m2) is wall
_FRAME_M = 0.15  # beside the reveal: frames are 5 to 12 cm wide
_BIN_M = 0.02  # range of depth that the points of a frame share
_FEWEST_POINTS = 8  # of a frame
_APART_BINS = 3  # between bars and a curtain behind them, at least
_WIDEST_BAR_M = 0.25  # with the cells beside it, in which its points mix with those of a curtain
_CURTAIN = 0.5  # share of the inside of an opening that it fills


@dataclass(frozen=True, eq=False)
class FilledRelief:
    """A relief without gaps, by cells (h, w).

    y        float32 m, the surface that pictures are drawn on
    known    bool, where it was measured
    opening  int32, number of the opening whose frame or glass a cell shows; 0 = wall
    """

    y: Array
    known: Bool
    opening: Int


def fill_openings(
    y: Array, known: Bool, inside: Bool, points: tuple[Int, Float], *, size: float, step: float
) -> FilledRelief:
    """Fills the gaps of a relief y (h, w) m: of the wall by the wall, of openings by their frames.

    `known` are the measured cells, small gaps included, and `inside` those in the outline of the facade.
    What was measured within `step` of a frame lies on its plane, so that its bars are straight.
    `points` are the flat cell numbers (n,) and the depths (n,) m of all points. Cells are `size` m wide; a
    difference in depth of more than `step` m is an edge. What was measured behind a frame is left out unless
    it is a surface as wide as a door.
    """
    filled = gridding.nearest_filled(y)
    filled = np.where(np.isfinite(filled), filled, 0.0).astype(np.float32)
    wall = _wall_depth(filled, known, size, step)
    count, opening = cv2.connectedComponents(
        (inside & (~known | (filled - wall > step))).astype(np.uint8), connectivity=4
    )
    frame = _frame_depth(opening, count, wall.ravel(), points, size, step)
    plane = wall + frame[opening]
    framed = np.isfinite(plane)
    behind = framed & known & (filled > plane + step)
    solid = solid_cells(behind, np.where(known, filled, np.nan), size, step)
    through = behind & (~solid | _crossed(solid, framed & known & (abs(filled - plane) <= step), size))
    own = np.where(known & ~through, filled, np.nan)
    own = np.where(framed & (np.abs(own - plane) <= step), plane, own)
    beside = gridding.nearest_filled(own)
    glass = framed & ~np.isfinite(own) & (beside <= plane + step)
    rest = np.where(np.isfinite(own), own, np.where(framed, beside, wall))
    surface = np.where(glass, plane, rest).astype(np.float32)
    return FilledRelief(surface, known & ~through, np.where(framed, opening, 0).astype(np.int32))


def _wall_depth(filled: Array, known: Bool, size: float, step: float) -> Array:
    """Depth (h, w) m of the wall in or nearest to every cell: of the large continuous surfaces."""
    box = np.ones((3, 3), np.uint8)
    flat = known & (cv2.dilate(filled, box) - cv2.erode(filled, box) <= step)
    _, piece, stats, _ = cv2.connectedComponentsWithStats(flat.astype(np.uint8), connectivity=4)
    area = stats[:, cv2.CC_STAT_AREA] * size**2
    area[0] = 0.0
    large = area >= min(_WALL_M2, float(area.max()))
    large[0] = False
    depth: Array = gridding.nearest_filled(np.where(large[piece], filled, np.nan).astype(np.float32))
    return np.where(np.isfinite(depth), depth, 0.0).astype(np.float32)


def _crossed(solid: Bool, frame: Bool, size: float) -> Bool:
    """Which cells (h, w) of wide surfaces bars cross: cells of the `frame` between two parts of the surface.

    They are curtains; nothing crosses the leaf of a door, or the back of a loggia.
    """
    if not solid.any():
        return solid
    whole = gridding.closed(solid, np.full(solid.shape, 0.5 * _WIDEST_BAR_M / size))
    count, piece, stats, _ = cv2.connectedComponentsWithStats(whole.astype(np.uint8), connectivity=8)
    across = 0.5 * np.minimum(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT])
    bars = np.bincount(piece[whole & frame], minlength=count)
    return np.asarray(solid & (bars >= across)[piece])


def _frame_depth(
    opening: Int, count: int, wall: Array, points: tuple[Int, Float], size: float, step: float
) -> Float:
    """Depth (count,) m behind the wall of the frames of numbered openings; NaN where no frame was measured.

    It is where most points lie beside the reveals, or else in the whole opening. What fills most of an
    opening behind bars is a curtain, and the bars have the depth of the frame.
    """
    inside = np.flatnonzero(np.take((opening > 0).ravel(), points[0]))
    cell, depth = (np.take(values, inside) for values in points)
    behind = depth - wall[cell]
    use = np.flatnonzero((behind > step) & (behind <= DEEPEST_REVEAL_M))
    cell, behind = cell[use], behind[use]
    which = opening.ravel()[cell]
    beside = (gridding.distance_to(opening == 0) * size <= _FRAME_M + size).ravel()
    border, inner = (_Layers.of(which[part], behind[part], count) for part in (beside[cell], ~beside[cell]))
    fullest = np.argmax(border.points, axis=1)
    curtain = border.depth(fullest)
    filling = np.unique(cell[~beside[cell] & (np.abs(behind - curtain[which]) <= step)])
    filled, room = (
        np.bincount(opening.ravel()[cells], minlength=count) for cells in (filling, np.flatnonzero(~beside))
    )
    bars = border.before(fullest, inner)
    found = border.depth(np.where((filled > _CURTAIN * room) & (bars >= 0), bars, fullest))
    every = _Layers.of(which, behind, count)
    return np.where(np.isfinite(found), found, every.depth(np.argmax(every.points, axis=1)))


@dataclass(frozen=True, eq=False)
class _Layers:
    """How many points (count, bins) each opening has in three neighbouring bins of depth.

    `total` (count, bins) m is the sum of their depths.
    """

    points: Int
    total: Array

    @classmethod
    def of(cls, which: Int, value: Array, count: int) -> "_Layers":
        """Those of the depths (n,) m of points in numbered openings (n,)."""
        bins = int(DEEPEST_REVEAL_M / _BIN_M) + 2
        flat = which * bins + np.minimum((value / _BIN_M).astype(np.int64), bins - 1)
        n = np.bincount(flat, minlength=count * bins).reshape(count, bins)
        total = np.bincount(flat, value, count * bins).reshape(count, bins)
        n3, total3 = (np.pad(a, ((0, 0), (1, 1))) for a in (n, total))
        return cls(*(a[:, :-2] + a[:, 1:-1] + a[:, 2:] for a in (n3, total3)))

    def depth(self, layer: Int) -> Float:
        """The mean depth (count,) m of the points of a layer of each opening; NaN where there are few."""
        at = np.arange(len(layer)), layer
        mean = self.total[at] / np.maximum(self.points[at], 1)
        return np.where(self.points[at] >= _FEWEST_POINTS, mean, np.nan)

    def before(self, layer: Int, within: "_Layers") -> Int:
        """The fullest layer (count,) well before the given one that also crosses the opening; -1 = none.

        Reveals and rebates do not cross it: `within` are the layers away from its border.
        """
        several = (self.points >= _FEWEST_POINTS) & (within.points >= _FEWEST_POINTS)
        nearer = np.arange(self.points.shape[1]) <= layer[:, None] - _APART_BINS
        best = np.argmax(np.where(several & nearer, self.points, 0), axis=1)
        return np.where((several & nearer)[np.arange(len(best)), best], best, -1)
