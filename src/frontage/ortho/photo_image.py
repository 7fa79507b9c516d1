"""The pixels that come from photos, tile by tile (paper A, section 3.2)."""

import numpy as np

from frontage.geometry.arrays import Array
from frontage.ortho.bands import Bands
from frontage.ortho.mosaic.compose import Mosaic
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.project import map_tile
from frontage.ortho.surface import DrawingSurface, ImageOf
from frontage.raster import gridding
from frontage.raster.light import brightened
from frontage.raster.resample import resample
from frontage.raster.sourcemap import SourceMap
from frontage.raster.tiles import Tile, tiles

_RESAMPLED_TILE_PX = 512  # one Jacobian per tile


def paint_photos(
    bands: Bands, surface: DrawingSurface, mosaic: Mosaic | None, image_of: ImageOf, options: OrthoOptions
) -> tuple[str, ...]:
    """Paints every pixel from the photo that the mosaic chose for it.

    Fills pixels, source and gsd, tile by tile. Returns the names of the photos, in the order of their source
    numbers; none without a mosaic.
    """
    if mosaic is None:
        return ()
    raster, plan, gsd = surface.raster, mosaic.plan, mosaic.gsd
    into = [surface.projection_into(photo, options.projection) for photo in plan.photos]
    for tile in tiles(raster.height, raster.width, _RESAMPLED_TILE_PX):
        label = plan.window(mosaic.label, tile)
        depth = surface.depth(tile)
        for i in np.unique(label[label >= 0]).tolist():
            mine = label == i
            part = _bounds(mine, tile)
            inside = np.s_[part.r0 - tile.r0 : part.r1 - tile.r0, part.c0 - tile.c0 : part.c1 - tile.c0]
            at = map_tile(into[i], part, None if depth is None else depth[inside])
            camera = plan.photos[i].camera
            inner = mine[inside] & _in_picture(at, camera.width, camera.height)
            _paint(bands, part, inner, i, at, image_of(plan.photos[i].id), mosaic, options)
        bands.gsd[tile.window] = plan.window(gsd, tile)
    return tuple(p.id for p in plan.photos)


def _paint(
    bands: Bands,
    part: Tile,
    inner: Array,
    number: int,
    at: SourceMap,
    image: Array,
    mosaic: Mosaic,
    options: OrthoOptions,
) -> None:
    """Paints the pixels `inner` (m, n) of a part of a tile from photo `number`."""
    bands.source[part.window][inner] = number + 1
    if inner.all():
        own = resample(image, at, options.interpolation, bands.pixels[part.window])
        _correct(own, mosaic, number, part)
        return
    colour = _correct(resample(image, at, options.interpolation), mosaic, number, part)
    np.copyto(bands.pixels[part.window].view(np.uint32), colour.view(np.uint32), where=inner[..., None])


def _correct(colour: Array, mosaic: Mosaic, number: int, tile: Tile) -> Array:
    """Brings the pixels (m, n, 4) of a tile, painted from one photo, to the light of the mosaic, in place."""
    if mosaic.correction is not None:
        cells, step = mosaic.plan.cells, mosaic.plan.step
        fine = OrthoRaster(cells.corner, cells.gsd / step, cells.width * step, cells.height * step)
        (r0, r1, c0, c1), u, v = cells.window_of(fine, tile)
        gain = gridding.bilinear(mosaic.correction[number, r0:r1, c0:c1], u, v)
        colour[..., :3] = brightened(np.ascontiguousarray(colour[..., :3]), gain)
    return colour


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
