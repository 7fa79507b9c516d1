"""The pixels that come from photos, tile by tile (paper A, section 3.2)."""

from collections.abc import Iterator

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Int
from frontage.model import Camera
from frontage.ortho.bands import Bands
from frontage.ortho.mosaic.compose import Mosaic
from frontage.ortho.options import OrthoOptions
from frontage.ortho.project import map_tile
from frontage.ortho.surface import DrawingSurface, ImageOf
from frontage.raster.light import code_scale, scaled
from frontage.raster.resample import resample
from frontage.raster.sourcemap import SourceMap
from frontage.raster.tiles import Tile, tiles

_RESAMPLED_TILE_PX = 768  # one projection and one Jacobian per tile and photo
_STRIP_PX = 128  # rows that are painted at once
_APART_PX = 32  # columns of other photos that part two places: fewer take less time than another place
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
    for tile in tiles(raster.height, raster.width, size):
        label, depth = plan.of_tile(mosaic.label, tile), surface.depth(tile)
        for i in np.unique(label[label >= 0]).tolist():
            cells = _bounds(label == i)
            part, inside = _pixels(cells, tile, plan.step)
            at = map_tile(into[i], part, None if depth is None else depth[inside])
            _paint_part(bands, mosaic, i, image_of(plan.photos[i].id), (part, label[cells] == i, at), options)
        # Every painted pixel has alpha.
        painted = cv2.extractChannel(bands.pixels[tile.window], 3)
        number = _enlarged((label + 1).astype(np.uint16), plan.step, tile.shape)
        cv2.copyTo(number, painted, bands.source[tile.window])
        bands.gsd[tile.window] = _enlarged(plan.of_tile(gsd, tile), plan.step, tile.shape)
    return tuple(p.id for p in plan.photos)


def _paint_part(
    bands: Bands,
    mosaic: Mosaic,
    number: int,
    image: Array,
    place: tuple[Tile, Bool, SourceMap],
    options: OrthoOptions,
) -> None:
    """Paints the cells (h, w) bool of a part of the picture that show photo `number`, along its map."""
    part, mine, at = place
    step, camera = mosaic.plan.step, mosaic.plan.photos[number].camera
    scale = None
    if mosaic.correction is not None:
        scale = _code_scale(mosaic.correction[number], part.r0 // step, part.c0 // step, mine.shape)
    whole = _whole(at, camera)
    for cells in _places(mine, max(1, _STRIP_PX // step), max(1, _APART_PX // step)):
        own, window = _pixels(cells, part, step)
        inner = _enlarged(mine[cells].view(np.uint8), step, own.shape)
        if not whole:
            inner &= _in_picture(at, window, camera)
        colour = resample(image, at, options.interpolation, window=window)
        if scale is not None:
            around = scale[cells[0].start : cells[0].stop + 2, cells[1].start : cells[1].stop + 2]
            large = cv2.resize(around, (around.shape[1] * step, around.shape[0] * step))
            colour = scaled(colour, large[step:, step:][: own.shape[0], : own.shape[1]])
        cv2.copyTo(colour, inner, bands.pixels[own.window])


def _bounds(mask: Bool) -> _Window:
    """Returns the smallest window that holds all True cells of a mask (m, n)."""
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def _places(mask: Bool, most: int, apart: int) -> Iterator[_Window]:
    """Yields windows of at most so many rows that hold all True cells of a mask (m, n), and little else.

    Columns that are farther `apart` come in windows of their own.
    """
    for first in range(0, len(mask), most):
        strip = mask[first : first + most]
        for left, right in _runs(np.flatnonzero(strip.any(0)), apart):
            rows = np.flatnonzero(strip[:, left : right + 1].any(1))
            yield slice(first + int(rows[0]), first + int(rows[-1]) + 1), slice(left, right + 1)


def _runs(numbers: Int, apart: int) -> Iterator[tuple[int, int]]:
    """The first and the last of each group of sorted numbers (n,) that are not farther `apart`."""
    if len(numbers):
        breaks = np.flatnonzero(np.diff(numbers) > apart)
        firsts, lasts = [0, *(breaks + 1).tolist()], [*breaks.tolist(), -1]
        yield from zip(numbers[firsts].tolist(), numbers[lasts].tolist(), strict=True)


def _pixels(cells: _Window, tile: Tile, step: int) -> tuple[Tile, _Window]:
    """The pixels of a window of cells of a tile: as a tile of the raster, and as a window of that tile."""
    (r0, r1), (c0, c1) = (
        (c.start * step, min(c.stop * step, size)) for c, size in zip(cells, tile.shape, strict=True)
    )
    return Tile(tile.r0 + r0, tile.r0 + r1, tile.c0 + c0, tile.c0 + c1), (slice(r0, r1), slice(c0, c1))


def _enlarged(cells: Array, step: int, shape: tuple[int, int]) -> Array:
    """The values of cells at their step x step pixels, as many as the shape (m, n) says."""
    size = (cells.shape[1] * step, cells.shape[0] * step)
    every: Array = cv2.resize(cells, size, interpolation=cv2.INTER_NEAREST)
    return every[: shape[0], : shape[1]]


def _code_scale(correction: Array, row: int, column: int, shape: tuple[int, int]) -> Array:
    """The scale (m + 2, n + 2, 4) of the codes of the (m, n) cells from a place on, and of those around them.

    `correction` (h, w, 3) is that of a photo; its edges repeat.
    """
    (h, w), (m, n) = correction.shape[:2], shape
    known = correction[max(row - 1, 0) : row + m + 1, max(column - 1, 0) : column + n + 1]
    scale = cv2.cvtColor(code_scale(known), cv2.COLOR_RGB2RGBA)
    above, below, left, right = (int(at) for at in (row == 0, row + m == h, column == 0, column + n == w))
    if above or below or left or right:
        scale = cv2.copyMakeBorder(scale, above, below, left, right, cv2.BORDER_REPLICATE)
    return np.asarray(scale)


def _whole(at: SourceMap, camera: Camera) -> bool:
    """Whether all pixels of a map fall inside a photo."""
    inside = (at.low >= 0).all() and at.high[0] <= camera.width and at.high[1] <= camera.height
    return bool(at.complete and inside)


def _in_picture(at: SourceMap, window: _Window, camera: Camera) -> Bool:
    """Which pixels (m, n) of a window of a map fall inside a photo."""
    u, v = at.planes((-0.5, -0.5), 1.0, window)
    inside: Bool = (u >= 0) & (v >= 0) & (u <= camera.width) & (v <= camera.height)
    return inside
