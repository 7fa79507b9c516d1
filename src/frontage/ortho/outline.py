"""What lies outside a facade is not its picture: sky, neighbours, the roof behind."""

import cv2
import numpy as np

from frontage.geometry.arrays import Bool
from frontage.model import Facade
from frontage.ortho.orthoraster import OrthoRaster
from frontage.raster.tiles import Tile

_SHIFT = 4  # fractional bits of OpenCV's drawing


def inside_outline(facade: Facade, raster: OrthoRaster, tile: Tile, margin: float) -> Bool:
    """Which pixels (m, n) of a tile lie in the facade's outline or within `margin` m of it."""
    x, z = facade.outline.T
    ring = np.column_stack([(x - raster.corner[0]) / raster.gsd, (raster.corner[1] - z) / raster.gsd])
    at = np.rint((ring - [tile.c0, tile.r0] - 0.5) * (1 << _SHIFT)).astype(np.int32)
    mask = np.zeros(tile.shape, np.uint8)
    cv2.fillPoly(mask, [at], 1, shift=_SHIFT)
    width = round(2 * margin / raster.gsd)
    if width > 0:
        cv2.polylines(mask, [at], True, 1, min(width, 32767), shift=_SHIFT)
    return mask.astype(bool)
