"""Pixels from photos, tile by tile."""

from collections.abc import Callable

import numpy as np

from frontage.geometry.arrays import Array
from frontage.model import Facade
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.project import map_tile, pixel_map, shifted
from frontage.ortho.relief import ReliefMap
from frontage.ortho.views import ViewPlan
from frontage.raster.resample import resample
from frontage.raster.sourcemap import SourceMap
from frontage.raster.tiles import Tile, tiles

TILE = 512  # px; one Jacobian per tile


def paint_photos(
    pixels: Array,
    source: Array,
    relief: ReliefMap | None,
    facade: Facade,
    raster: OrthoRaster,
    plan: ViewPlan,
    image_of: Callable[[str], Array],
    options: OrthoOptions,
    offset: float = 0.0,
) -> None:
    """Fill `pixels` (h, w, 4) and `source` (h, w) where the plan has a photo, one photo in memory.

    The surface lies `offset` m behind the relief, or the plane.
    """
    for i, photo in enumerate(plan.photos):
        if not (plan.label == i).any():
            continue
        image = image_of(photo.id)
        to_photo = shifted(pixel_map(photo, facade, raster, options.projection), offset)
        for tile in tiles(raster.height, raster.width, TILE):
            mine = plan.window(plan.label, tile) == i
            if not mine.any():
                continue
            part = _bounds(mine, tile)
            inner = mine[part.r0 - tile.r0 : part.r1 - tile.r0, part.c0 - tile.c0 : part.c1 - tile.c0]
            y = None if relief is None else relief.at(raster, part, filled=True)
            at = map_tile(to_photo, part, y)
            inner = inner & _in_picture(at, photo.camera.width, photo.camera.height)
            if inner.all():
                resample(image, at, options.interpolation, pixels[part.window])
                source[part.window] = i + 1
                continue
            colour = resample(image, at, options.interpolation)
            np.copyto(pixels[part.window].view(np.uint32), colour.view(np.uint32), where=inner[..., None])
            source[part.window][inner] = i + 1


def _in_picture(at: SourceMap, width: int, height: int) -> Array | bool:
    """Which pixels (m, n) of a map have a place in a photo; True when all have."""
    if at.complete and (at.low >= 0).all() and at.high[0] <= width and at.high[1] <= height:
        return True
    u, v = at.planes((-0.5, -0.5), 1.0)
    inside: Array = (u >= 0) & (v >= 0) & (u <= width) & (v <= height)
    return inside


def _bounds(mask: Array, tile: Tile) -> Tile:
    """The part of a tile that holds the True pixels of its mask."""
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    return Tile(
        tile.r0 + int(rows[0]),
        tile.r0 + int(rows[-1]) + 1,
        tile.c0 + int(columns[0]),
        tile.c0 + int(columns[-1]) + 1,
    )
