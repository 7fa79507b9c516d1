"""The shadows that fittings throw on the wall in a scan whose lines of sight are not known."""

import cv2
import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Array, Bool, Float
from frontage.model.masonry import MASONRY
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.raster import WallRaster, averaged, closed, opened

_NEAR = (0.3, 0.6, 1.0)  # m before the wall, where the layers begin in which fittings are looked for
_THICK = 0.5  # m, thickness of a layer
_PIER = 2.0 * MASONRY.half_brick  # m, least side of a pier: blocks and balusters are narrower
_REACH = 0.2  # m: a fitting stands out so much further than its layer begins


def shadows_of_fittings(beams: Beams, raster: WallRaster, least: Float) -> Bool:
    """Returns the cells (h, w) that something at most 1.5 m before the wall may hide.

    `least` (h, w) are the beams that masonry returns at least.

    Those are the cells above and below it, as far as it stands out, for the sensor may stand anywhere. Most
    of them must be dark: where the wall shows, it was seen past the fitting. What is long throws its shadow
    along its whole length: a place is lit where piers to its left and its right returned their beams at the
    same height in the same shadow, no further apart than an opening is wide. There must be wall above it, for
    what stands on a cornice at the end of a wall is no pier.
    """
    wall = averaged(raster.count(*beams.solid[beams.solid_depth >= -beams.least].T))  # without fittings
    shown = wall >= np.maximum(averaged(least), 1e-9)
    hidden = np.zeros(raster.shape, np.bool_)
    depth = -beams.front[:, 2]
    for near in _NEAR:
        some = (depth >= near) & (depth < near + _THICK)
        held = opened(raster.count(*beams.front[some, :2].T) > 0, (1, 3))
        if not held.any():
            continue
        reach = max(int((near + _REACH) / raster.cell), 1)
        for anchor in (reach, 0):  # up, and down
            kernel = np.ones((reach + 1, 1), np.uint8)
            shadow = cv2.dilate(held.view(np.uint8), kernel, anchor=(0, anchor))
            hidden |= _dark(shadow, shown)
    if not hidden.any():
        return hidden
    wide = max(int(_PIER / raster.cell), 1)
    lit = _between(opened(shown & hidden, (wide, wide)), int(MASONRY.largest_opening / raster.cell))
    has_wall_above = np.logical_or.accumulate(shown[::-1], axis=0)[::-1]
    return np.asarray(hidden & ~(lit & has_wall_above))


def _dark(shadow: Array, shown: Bool) -> Bool:
    """Returns the cells (h, w) of those connected parts of a shadow in most of which no wall is `shown`."""
    labels, count = ndimage.label(shadow)
    dark, lit = (np.bincount(labels[shown == one], minlength=count + 1) for one in (False, True))
    is_dark = dark >= lit
    is_dark[0] = False  # what lies in no shadow
    return np.asarray(is_dark[labels])


def _between(cells: Bool, most: int) -> Bool:
    """Returns the cells (h, w), and what lies between two of them in a row that are at most `most` apart."""
    padded = np.pad(cells, ((0, 0), (most, most)))
    return closed(padded, (1, most | 1))[:, most:-most]
