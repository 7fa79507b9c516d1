"""Rasterises the outline of a facade; sky, neighbours and the roof behind it do not belong in the picture."""

import cv2
import numpy as np

from frontage.geometry.arrays import Bool
from frontage.model import Facade
from frontage.ortho.orthoraster import OrthoRaster
from frontage.raster.tiles import Tile

_SHIFT_BITS = 4  # fractional bits of the coordinates that OpenCV draws with


def inside_outline(facade: Facade, raster: OrthoRaster, tile: Tile, margin: float) -> Bool:
    """Returns which pixels (m, n) of a tile lie in the outline of the facade or within `margin` m of it."""
    x, z = facade.outline.T
    ring = np.column_stack([(x - raster.corner[0]) / raster.gsd, (raster.corner[1] - z) / raster.gsd])
    at = np.rint((ring - [tile.c0, tile.r0] - 0.5) * (1 << _SHIFT_BITS)).astype(np.int32)
    mask = np.zeros(tile.shape, np.uint8)
    cv2.fillPoly(mask, [at], 1, shift=_SHIFT_BITS)
    width = round(2 * margin / raster.gsd)
    if width > 0:
        cv2.polylines(mask, [at], True, 1, min(width, 32767), shift=_SHIFT_BITS)
    return mask.astype(bool)
