"""Finds the places that one photo has to show as a whole: windows, and whatever the photos do not agree on.

Behind glass, and where bars, balusters or ornaments stand off the surface that the photos are drawn on, every
photo shows something else. There is no common colour there, and cells chosen one by one would come from
several photos. What speaks against a photo is therefore averaged over such a place. Walkers do not make one:
most photos agree on the wall behind them.
"""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Int
from frontage.ortho.mosaic.consensus import FEWEST_PHOTOS, Disagreement

_AROUND_M = 0.4  # over which agreement is averaged: the distance of bars
_AGREEING = (0.75, 0.6, 0.45)  # share of the photos that agree on a surface, at least; where a place
# would be too large, the next share parts it
_SMALLEST_M2 = 0.1
_LARGEST_M2 = 6.0  # of a window or a gate; what is larger is no unit, and a walker would be lost in it


def whole_places(found: Disagreement, clear: Bool, cell: float) -> Int:
    """Returns the number (h, w) of the place that a cell belongs to, 0 = none.

    `found` compares photos (k), and `clear` (k, h, w) tells where they see the facade with nothing in front;
    cells are `cell` m wide.
    """
    count = clear.sum(0)
    agreeing = (found.accepted & clear).sum(0) / np.maximum(count, 1).astype(np.float32)
    agreeing[count < FEWEST_PHOTOS] = 1.0
    width = max(1, round(_AROUND_M / cell)) | 1
    smooth = cv2.blur(agreeing.astype(np.float32), (width, width))
    place = np.zeros(count.shape, np.int64)
    for share in _AGREEING:
        torn = (smooth < share) & (place == 0)
        number = _fitting(cv2.connectedComponents(torn.astype(np.uint8), connectivity=4)[1], cell)
        place = np.where(number > 0, number + place.max(), place)
    return place


def _fitting(number: Int, cell: float) -> Int:
    """The numbers (h, w) of places of the size of windows and gates; the others become 0."""
    area = np.bincount(number.ravel()) * cell**2
    fits = (area >= _SMALLEST_M2) & (area <= _LARGEST_M2)
    return np.asarray(np.where(fits[number], number, 0), np.int64)


def averaged(cost: Array, place: Int, clear: Bool) -> Array:
    """Returns costs (k, h, w) of which those of clear cells are replaced by their mean over their place."""
    out, flat = cost.copy(), place.ravel()
    for k in range(len(cost)):
        use = np.flatnonzero((clear[k] & (place > 0)).ravel())
        own = flat[use]
        number = np.bincount(own)
        mean = np.bincount(own, cost[k].ravel()[use]) / np.maximum(number, 1)
        out[k].ravel()[use] = mean[own]
    return out
