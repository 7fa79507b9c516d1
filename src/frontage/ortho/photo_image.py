"""The pixels that come from photos, tile by tile (paper A, section 3.2)."""

import numpy as np

from frontage.geometry.arrays import Array
from frontage.ortho.bands import TILE_PX, Bands
from frontage.ortho.options import OrthoOptions
from frontage.ortho.project import map_tile
from frontage.ortho.surface import DrawingSurface, ImageOf
from frontage.ortho.views import ViewPlan
from frontage.raster.resample import resample
from frontage.raster.sourcemap import SourceMap
from frontage.raster.tiles import Tile, tiles

_RESAMPLED_TILE_PX = 512  # one Jacobian per tile


def paint_photos(
    bands: Bands, surface: DrawingSurface, plan: ViewPlan | None, image_of: ImageOf, options: OrthoOptions
) -> tuple[str, ...]:
    """Paints every pixel from the photo that the plan chose for it, holding one photo in memory at a time.

    Fills pixels, source and gsd. Returns the names of the photos, in the order of their source numbers;
    none without a plan.
    """
    if plan is None:
        return ()
    raster = surface.raster
    for i, photo in enumerate(plan.photos):
        if not (plan.label == i).any():
            continue
        image = image_of(photo.id)
        to_photo = surface.projection_into(photo, options.projection)
        for tile in tiles(raster.height, raster.width, _RESAMPLED_TILE_PX):
            mine = plan.window(plan.label, tile) == i
            if not mine.any():
                continue
            part = _bounds(mine, tile)
            inner = mine[part.r0 - tile.r0 : part.r1 - tile.r0, part.c0 - tile.c0 : part.c1 - tile.c0]
            at = map_tile(to_photo, part, surface.depth(part))
            inner = inner & _in_picture(at, photo.camera.width, photo.camera.height)
            if inner.all():
                resample(image, at, options.interpolation, bands.pixels[part.window])
                bands.source[part.window] = i + 1
                continue
            colour = resample(image, at, options.interpolation)
            np.copyto(
                bands.pixels[part.window].view(np.uint32), colour.view(np.uint32), where=inner[..., None]
            )
            bands.source[part.window][inner] = i + 1
    for tile in tiles(raster.height, raster.width, TILE_PX):
        bands.gsd[tile.window] = plan.window(plan.gsd, tile)
    return tuple(p.id for p in plan.photos)


def _in_picture(at: SourceMap, width: int, height: int) -> Array | bool:
    """Which pixels (m, n) of a map fall inside a photo; True when all do."""
    if at.complete and (at.low >= 0).all() and at.high[0] <= width and at.high[1] <= height:
        return True
    u, v = at.planes((-0.5, -0.5), 1.0)
    inside: Array = (u >= 0) & (v >= 0) & (u <= width) & (v <= height)
    return inside


def _bounds(mask: Array, tile: Tile) -> Tile:
    """Returns the smallest part of a tile that holds all True pixels of its mask."""
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    return Tile(
        tile.r0 + int(rows[0]),
        tile.r0 + int(rows[-1]) + 1,
        tile.c0 + int(columns[0]),
        tile.c0 + int(columns[-1]) + 1,
    )
