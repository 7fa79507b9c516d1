"""The pixels that come from photos, tile by tile (paper A, section 3.2)."""

from collections.abc import Iterator

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool
from frontage.model import Camera
from frontage.ortho.bands import Bands
from frontage.ortho.mosaic.compose import Mosaic
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.project import map_tile
from frontage.ortho.surface import DrawingSurface, ImageOf
from frontage.ortho.views import ViewPlan
from frontage.raster import gridding
from frontage.raster.light import code_scale, scaled
from frontage.raster.resample import resample
from frontage.raster.sourcemap import SourceMap
from frontage.raster.tiles import Tile, tiles
from frontage.solve.abreast import each

_RESAMPLED_TILE_PX = 512  # one Jacobian per tile
_STRIP_PX = 128  # rows that are painted at once, and columns of another photo that part two places
_Window = tuple[slice, slice]


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
    size = max(1, _RESAMPLED_TILE_PX // plan.step) * plan.step  # whole cells

    def paint(tile: Tile) -> None:
        label, depth = plan.window(mosaic.label, tile), surface.depth(tile)
        for i, photo in enumerate(plan.photos):
            mine = label == i
            if mine.any():
                part = _bounds(mine, tile)
                inside = np.s_[part.r0 - tile.r0 : part.r1 - tile.r0, part.c0 - tile.c0 : part.c1 - tile.c0]
                at = map_tile(into[i], part, None if depth is None else depth[inside])
                _paint_part(bands, mosaic, i, image_of(photo.id), (part, mine[inside], at), options)
        bands.gsd[tile.window] = plan.window(gsd, tile)

    for _ in each(paint, list(tiles(raster.height, raster.width, size))):
        pass
    return tuple(p.id for p in plan.photos)


def _paint_part(
    bands: Bands,
    mosaic: Mosaic,
    number: int,
    image: Array,
    place: tuple[Tile, Bool, SourceMap],
    options: OrthoOptions,
) -> None:
    """Paints the pixels of a part of the picture that show photo `number`, which (m, n), along its map."""
    part, mine, at = place
    for window in _places(mine):
        inner = mine[window] & _in_picture(at, window, mosaic.plan.photos[number].camera)
        colour = resample(image, at, options.interpolation, window=window)
        if mosaic.correction is not None:
            colour = scaled(colour, _code_scale(mosaic.correction[number], mosaic.plan, part, window))
        cv2.copyTo(colour, inner.view(np.uint8), bands.pixels[part.window][window])
        bands.source[part.window][window][inner] = number + 1


def _places(mask: Bool) -> Iterator[_Window]:
    """Yields windows that together hold all True pixels of a mask (m, n), and little else."""
    for first in range(0, len(mask), _STRIP_PX):
        rows = slice(first, min(first + _STRIP_PX, len(mask)))
        columns = np.flatnonzero(mask[rows].any(0))
        gaps = np.flatnonzero(np.diff(columns) > _STRIP_PX)
        for c in np.split(columns, gaps + 1):
            if len(c):
                yield rows, slice(int(c[0]), int(c[-1]) + 1)


def _code_scale(correction: Array, plan: ViewPlan, part: Tile, window: _Window) -> Array:
    """The scale (m, n, 4) of the codes in a window of a part, by the correction (h, w, 3) of a photo."""
    cells, step = plan.cells, plan.step
    fine = OrthoRaster(cells.corner, cells.gsd / step, cells.width * step, cells.height * step)
    rows, columns = window
    place = Tile(part.r0 + rows.start, part.r0 + rows.stop, part.c0 + columns.start, part.c0 + columns.stop)
    (r0, r1, c0, c1), u, v = cells.window_of(fine, place)
    scale = code_scale(correction[r0:r1, c0:c1])
    return gridding.bilinear(cv2.cvtColor(scale, cv2.COLOR_RGB2RGBA), u, v)


def _in_picture(at: SourceMap, window: _Window, camera: Camera) -> Array | bool:
    """Which pixels (m, n) of a window of a map fall inside a photo; True when all do."""
    if at.complete and (at.low >= 0).all() and at.high[0] <= camera.width and at.high[1] <= camera.height:
        return True
    u, v = at.planes((-0.5, -0.5), 1.0, window)
    inside: Array = (u >= 0) & (v >= 0) & (u <= camera.width) & (v <= camera.height)
    return inside


def _bounds(mask: Bool, tile: Tile) -> Tile:
    """Returns the smallest part of a tile that holds all True pixels of its mask."""
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    return Tile(
        tile.r0 + int(rows[0]),
        tile.r0 + int(rows[-1]) + 1,
        tile.c0 + int(columns[0]),
        tile.c0 + int(columns[-1]) + 1,
    )
