"""Rasterises the outline of a facade; sky, neighbours and the roof behind it do not belong in the picture."""

from functools import lru_cache

import cv2
import numpy as np
from shapely.geometry import Polygon, box
from shapely.ops import unary_union

from frontage.geometry.arrays import Bool, Float
from frontage.model import Facade
from frontage.ortho.orthoraster import OrthoRaster
from frontage.raster.tiles import Tile

_SHIFT_BITS = 4  # fractional bits of the coordinates that OpenCV draws with
_NARROWEST_M = 0.61  # DIN 18101, narrowest door leaf: what is narrower is a ragged border and no recess
_NEAR_M = 0.01


def inside_outline(facade: Facade, raster: OrthoRaster, tile: Tile, margin: float) -> Bool:
    """Returns which pixels (m, n) of a tile lie in the outline of the facade or within `margin` m of it."""
    x, z = _with_recesses(np.ascontiguousarray(facade.outline, np.float64).tobytes()).T
    ring = np.column_stack([(x - raster.corner[0]) / raster.gsd, (raster.corner[1] - z) / raster.gsd])
    at = np.rint((ring - [tile.c0, tile.r0] - 0.5) * (1 << _SHIFT_BITS)).astype(np.int32)
    mask = np.zeros(tile.shape, np.uint8)
    cv2.fillPoly(mask, [at], 1, shift=_SHIFT_BITS)
    width = round(2 * margin / raster.gsd)
    if width > 0:
        cv2.polylines(mask, [at], True, 1, min(width, 32767), shift=_SHIFT_BITS)
    return mask.astype(bool)


@lru_cache(maxsize=16)
def _with_recesses(corners: bytes) -> Float:
    """Adds its recesses to an outline (k, 2) m: entrances and passages with wall on three sides.

    Their backs lie too deep to belong to the wall, but they are part of the picture of the facade. The
    outline comes as the bytes of its float64, because every tile of a picture asks again.
    """
    outline = np.frombuffer(corners, np.float64).reshape(-1, 2)
    ring = Polygon(outline)
    if not ring.is_valid:
        return outline
    x0, z0, x1, z1 = ring.bounds
    half = 0.5 * _NARROWEST_M
    missing = box(x0, z0, x1, z1).difference(ring)
    wide = missing.buffer(-half, join_style="mitre").buffer(half, join_style="mitre")
    recesses = [
        piece
        for piece in getattr(wide, "geoms", [wide])
        if not piece.is_empty
        and x0 + _NEAR_M < piece.bounds[0]
        and piece.bounds[2] < x1 - _NEAR_M
        and piece.bounds[3] < z1 - _NEAR_M
    ]
    if not recesses:
        return outline
    joined = unary_union([ring, *(piece.buffer(_NEAR_M, join_style="mitre") for piece in recesses)])
    largest = max(getattr(joined, "geoms", [joined]), key=lambda part: part.area)
    return np.asarray(largest.exterior.coords[:-1], np.float64)
