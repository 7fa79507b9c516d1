"""Tells what lies behind the openings of a relief: a frame, a passage, or a room that is not the facade.

Frames stand within the thickness of the outer wall. Solid brick walls are 24 or 36.5 cm thick (one or one and
a half bricks), and modern insulated walls set their frames no deeper. What a scan sees farther back is
therefore a room behind glass, unless it is a surface that a person could walk up to: continuous, and at least
as wide as the narrowest door leaf, 61 cm (DIN 18101), such as the back of a loggia, a passage or a door in a
deep portal.
"""

import cv2
import numpy as np
from scipy.ndimage import label

from frontage.geometry.arrays import Array, Bool, Int
from frontage.raster import gridding

DEEPEST_REVEAL_M = 0.365  # one and a half bricks
_PASSAGE_M = 0.61  # DIN 18101, narrowest door leaf
_CONTINUED = 0.5  # share of the cells around that must continue a surface
_RING_CELLS = 2  # around an opening, in which its frame may be visible
_BIN_M = 0.02  # range of depth that the points of a frame share
_FEWEST_FRAME_POINTS = 8


def room_cells(y: Array, size: float, step: float) -> Bool:
    """Returns the cells that show rooms behind glass, (h, w) bool, of a relief y (h, w) m.

    They are deeper than any reveal and do not belong to a continuous surface as wide as a door. `size` m is
    the edge of a cell; neighbours within `step` m of each other continue a surface.
    """
    with np.errstate(invalid="ignore"):
        deep = y > DEEPEST_REVEAL_M
    if not deep.any():
        return deep
    solid = deep & _continuous(y, step)
    whole = gridding.closed(solid, np.full(y.shape, 1.0))
    wide = ~gridding.closed(~whole, np.full(y.shape, 0.5 * _PASSAGE_M / size))  # opening of the surface
    near_wide = gridding.distance_to(wide) <= _RING_CELLS + 1
    return deep & ~near_wide


def fill_at_frame_depth(smooth: Array, known: Bool, cell: Int, depth: Array, step: float) -> Array:
    """Fills the gaps of `smooth` (h, w) m: openings at the depth of their frame, others from beside.

    An opening is a gap in `known`; `cell` (n,) and `depth` (n,) m are those of all points. Its frame lies
    where most of the points in and around it lie that are recessed by more than `step` m, if there are eight
    of them.
    """
    full = gridding.nearest_filled(smooth)
    full = np.where(np.isfinite(full), full, 0.0).astype(np.float32)
    openings, count = label(~known)
    if count == 0:
        return full
    around = _labels_within(openings, _RING_CELLS)
    wall = _median_by(around[(around > 0) & known], full[(around > 0) & known], count)
    which = around.ravel()[cell]
    behind = depth - wall[which]
    use = (which > 0) & (behind > step) & (behind <= DEEPEST_REVEAL_M)
    frame = wall + _mode(which[use], behind[use], count)
    inside = (openings > 0) & np.isfinite(frame)[openings]
    return np.where(inside, frame[openings], full).astype(np.float32)


def _continuous(y: Array, step: float) -> Bool:
    """Returns the cells (h, w) that at least half of their 24 neighbours continue within `step` m."""
    padded = np.pad(y, 2, constant_values=np.nan)
    h, w = y.shape
    friends = np.zeros(y.shape, np.int32)
    for i in range(5):
        for j in range(5):
            with np.errstate(invalid="ignore"):
                friends += np.abs(padded[i : i + h, j : j + w] - y) <= step
    return friends - 1 >= _CONTINUED * 24


def _labels_within(labels: Array, reach: int) -> Int:
    """Grows labels (h, w) into the zeros around them by `reach` cells; the larger label wins."""
    box = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    grown = cv2.dilate(labels.astype(np.float32), box).astype(np.int64)
    return np.where(labels > 0, labels, grown)


def _median_by(which: Int, value: Array, count: int) -> Array:
    """Returns the median (count + 1,) of values (n,) by label (n,); 0 for labels without values."""
    (median,), _ = gridding.cell_quantiles(which, value.astype(np.float64), (1, count + 1), (0.5,))
    return np.asarray(np.nan_to_num(median[0], nan=0.0))


def _mode(which: Int, value: Array, count: int) -> Array:
    """Returns the depth (count + 1,) m where most values (n,) of a label lie: mean of the fullest bins."""
    bins = int(DEEPEST_REVEAL_M / _BIN_M) + 2
    flat = which * bins + np.minimum((value / _BIN_M).astype(np.int64), bins - 1)
    n = np.bincount(flat, minlength=(count + 1) * bins).reshape(count + 1, bins)
    total = np.bincount(flat, value, (count + 1) * bins).reshape(count + 1, bins)
    n3, total3 = (np.pad(a, ((0, 0), (1, 1))) for a in (n, total))
    n3, total3 = (a[:, :-2] + a[:, 1:-1] + a[:, 2:] for a in (n3, total3))
    best = np.arange(count + 1), np.argmax(n3, axis=1)
    mean = total3[best] / np.maximum(n3[best], 1)
    return np.where(n3[best] >= _FEWEST_FRAME_POINTS, mean, np.nan)
