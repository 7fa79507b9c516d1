"""Openings in a relief: what lies behind them is a frame, a passage, or a room that is none of the facade's.

Frames stand within the thickness of the outer wall. Solid brick walls are 24 or 36.5 cm thick (one and a half
bricks), modern ones with insulation set their frames no deeper; so what a scan sees further back is a room
behind glass, unless it is a surface that a person could walk up to: continuous, and as wide as the narrowest
door leaf, 61 cm (DIN 18101), like the back of a loggia, a passage or a door in a deep portal.
"""

import cv2
import numpy as np
from scipy.ndimage import label

from frontage.geometry.arrays import Array, Bool, Int
from frontage.raster import gridding

DEEPEST_REVEAL = 0.365  # m
_PASSAGE = 0.61  # m
_SOLID = 0.5  # share of the cells around that continue a surface
_RING = 2  # cells around an opening in which its frame may show
_BIN = 0.02  # m of depth in which a frame's points gather
_ENOUGH = 8  # points that make a frame


def rooms(y: Array, size: float, step: float) -> Bool:
    """Cells (h, w) of `size` m deeper than a reveal that are no continuous surface as wide as a door."""
    with np.errstate(invalid="ignore"):
        deep = y > DEEPEST_REVEAL
    if not deep.any():
        return deep
    solid = deep & _continuous(y, step)
    whole = gridding.closed(solid, np.full(y.shape, 1.0))
    wide = ~gridding.closed(~whole, np.full(y.shape, 0.5 * _PASSAGE / size))  # opening of the surface
    near_wide = gridding.distance_to(wide) <= _RING + 1
    return deep & ~near_wide


def framed(smooth: Array, known: Bool, cell: Int, depth: Array, size: float, step: float) -> Array:
    """`smooth` (h, w) m with its gaps filled: openings at their frame's depth, the rest from the next cell.

    An opening is a gap in `known`; `cell` (n,) and `depth` (n,) m are all points. Its frame is where most of
    the points in and around it lie that are recessed by more than a step, if there are eight of them.
    """
    full = gridding.nearest_filled(smooth)
    full = np.where(np.isfinite(full), full, 0.0).astype(np.float32)
    openings, count = label(~known)
    if count == 0:
        return full
    around = _labels_within(openings, _RING)
    wall = _median_by(around[(around > 0) & known], full[(around > 0) & known], count)
    which = around.ravel()[cell]
    behind = depth - wall[which]
    use = (which > 0) & (behind > step) & (behind <= DEEPEST_REVEAL)
    frame = wall + _mode(which[use], behind[use], count)
    inside = (openings > 0) & np.isfinite(frame)[openings]
    return np.where(inside, frame[openings], full).astype(np.float32)


def _continuous(y: Array, step: float) -> Bool:
    """Cells (h, w) that at least half of their 24 neighbours continue within a step."""
    padded = np.pad(y, 2, constant_values=np.nan)
    h, w = y.shape
    friends = np.zeros(y.shape, np.int32)
    for i in range(5):
        for j in range(5):
            with np.errstate(invalid="ignore"):
                friends += np.abs(padded[i : i + h, j : j + w] - y) <= step
    return friends - 1 >= _SOLID * 24


def _labels_within(labels: Array, reach: int) -> Int:
    """Labels (h, w), grown into the zeros around by `reach` cells; where they meet, the larger number."""
    box = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    grown = cv2.dilate(labels.astype(np.float32), box).astype(np.int64)
    return np.where(labels > 0, labels, grown)


def _median_by(which: Int, value: Array, count: int) -> Array:
    """Median (count + 1,) of values (n,) by label (n,); 0 where a label has none."""
    (median,), _ = gridding.cell_quantiles(which, value.astype(np.float64), (1, count + 1), (0.5,))
    return np.asarray(np.nan_to_num(median[0], nan=0.0))


def _mode(which: Int, value: Array, count: int) -> Array:
    """The depth (count + 1,) m at which most values (n,) of a label lie: the mean of the fullest bins."""
    bins = int(DEEPEST_REVEAL / _BIN) + 2
    flat = which * bins + np.minimum((value / _BIN).astype(np.int64), bins - 1)
    n = np.bincount(flat, minlength=(count + 1) * bins).reshape(count + 1, bins)
    total = np.bincount(flat, value, (count + 1) * bins).reshape(count + 1, bins)
    n3, total3 = (np.pad(a, ((0, 0), (1, 1))) for a in (n, total))
    n3, total3 = (a[:, :-2] + a[:, 1:-1] + a[:, 2:] for a in (n3, total3))
    best = np.arange(count + 1), np.argmax(n3, axis=1)
    mean = total3[best] / np.maximum(n3[best], 1)
    return np.where(n3[best] >= _ENOUGH, mean, np.nan)
