"""The bands of an ortho-image while it is being made, and the operations that concern all of them at once."""

from collections.abc import Sequence

import numpy as np

from frontage.geometry.arrays import Array
from frontage.model import NOT_SEEN, Facade, OrthoImage, PhotoOffset
from frontage.ortho.corners import Corner
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.outline import inside_outline
from frontage.ortho.relief import ReliefMap
from frontage.ortho.sky import SkyColours
from frontage.ortho.surface import DrawingSurface
from frontage.raster.tiles import allocate, tiles

TILE_PX = 1024
_SAMPLED = 8  # one of so many pixels or more, along rows and columns, tells the colours of the facade
_SAMPLED_ABOVE = 3  # likewise, of what lies above it, which is less
_ENOUGH = 1_000_000  # of the pixels of the facade
_MUCH_MISSING = 0.25  # share that must be missing before a picture of two kinds is better than one with holes


class Bands:
    """The pixels (h, w, 4) uint8, depth (h, w) float32 m, source (h, w) uint16 and gsd (h, w) float32 m.

    All bands start empty (0 or NaN) except the depth, which holds the `relief` with its gaps filled until
    `clear_outside` is called. Without a relief the depth is a single NaN, broadcast to (h, w).
    """

    def __init__(self, raster: OrthoRaster, relief: ReliefMap | None = None) -> None:
        shape = (raster.height, raster.width)
        self.relief = relief
        self.pixels = allocate((*shape, 4), np.uint8)
        self.depth = np.broadcast_to(np.float32(np.nan), shape)
        if relief is not None:
            self.depth = allocate(shape, np.float32)
            for tile in tiles(raster.height, raster.width, TILE_PX):
                self.depth[tile.window] = relief.at(raster, tile)
        self.source = allocate(shape, np.uint16)
        self.gsd = allocate(shape, np.float32, np.nan)

    def surface(self, facade: Facade, raster: OrthoRaster) -> DrawingSurface:
        """The surface that the pixels are drawn on, with the depths of all of them."""
        return DrawingSurface(facade, raster, self.relief, drawn=None if self.relief is None else self.depth)

    def forget_gaps(self, raster: OrthoRaster) -> None:
        """Sets the depth to NaN where the relief was not measured."""
        if self.relief is not None:
            for tile in tiles(raster.height, raster.width, TILE_PX):
                np.copyto(self.depth[tile.window], np.nan, where=~self.relief.measured(raster, tile))

    def as_ortho_image(
        self,
        facade: Facade,
        raster: OrthoRaster,
        sources: Sequence[str],
        *,
        intensity: Array | None,
        photo_offset: PhotoOffset | None,
        photos: int,
    ) -> OrthoImage:
        """Returns the finished image; the first `photos` of its sources are photos."""
        return OrthoImage(
            self.pixels,
            raster.gsd,
            raster.corner,
            facade,
            self.depth,
            self.source,
            tuple(sources),
            self.gsd,
            intensity,
            photo_offset,
            photos,
        )


def much_is_missing(bands: Bands, surface: DrawingSurface) -> bool:
    """Whether so much of the inside of the outline has no source yet that the scan should show it."""
    raster = surface.raster
    inside, missed = 0, 0
    for tile in tiles(raster.height, raster.width, TILE_PX):
        mask = inside_outline(surface.facade, raster, tile, 0.0)
        inside += int(mask.sum())
        missed += int((mask & (bands.source[tile.window] == 0)).sum())
    return missed > _MUCH_MISSING * inside


def fill_missing(bands: Bands, other: Bands, number: int, raster: OrthoRaster) -> bool:
    """Fills the pixels without a source from `other`, with `number` as their source.

    Returns False and changes nothing when no more than a quarter of what `other` shows is missing.
    """
    shown, gained = 0, 0
    for tile in tiles(raster.height, raster.width, TILE_PX):
        known = other.source[tile.window] > 0
        shown += int(known.sum())
        gained += int((known & (bands.source[tile.window] == 0)).sum())
    if gained <= _MUCH_MISSING * shown:
        return False
    for tile in tiles(raster.height, raster.width, TILE_PX):
        take = (other.source[tile.window] > 0) & (bands.source[tile.window] == 0)
        bands.pixels[tile.window][take] = other.pixels[tile.window][take]
        bands.gsd[tile.window][take] = other.gsd[tile.window][take]
        bands.source[tile.window][take] = number
    return True


def clear_outside(
    bands: Bands,
    intensity: Array | None,
    surface: DrawingSurface,
    corners: Sequence[Corner],
    options: OrthoOptions,
) -> None:
    """Clears all bands outside the outline of the facade, and the depth where it was not measured.

    What is on the facade and not seen is marked.

    The wall ends half a spacing beyond its last points, on which the outline runs. Within the margin of the
    outline, measured surfaces stay. Beside inner `corners`, the wall goes on to the other wall.

    The sky above the wall is cleared, even in the outline, which is straight between its corners (`sky.py`).

    Where no relief was measured at all, nothing can tell a cornice from the sky, and the whole margin stays.
    """
    facade, raster = surface.facade, surface.raster
    bands.forget_gaps(raster)
    measured = bands.relief is not None and any(
        np.isfinite(bands.depth[t.window]).any() for t in tiles(raster.height, raster.width, TILE_PX)
    )
    sky = _sky_colours(bands, raster)
    for tile in tiles(raster.height, raster.width, TILE_PX):
        outside = ~inside_outline(facade, raster, tile, options.margin)
        within = inside_outline(facade, raster, tile, 0.5 * facade.spacing)
        for corner in corners:
            within |= corner.beside(raster, tile)
        if measured:
            outside |= ~(np.isfinite(bands.depth[tile.window]) | within)
        if bands.relief is not None:
            outside |= sky.shown(bands.pixels[tile.window], bands.relief.above_wall(raster, tile))
        source = bands.source[tile.window]
        source[within & ~outside & (source == 0)] = NOT_SEEN
        if outside.any():
            np.copyto(bands.pixels.view(np.uint32)[tile.window][..., 0], 0, where=outside)
            np.copyto(source, 0, where=outside)
            for band in (bands.depth if bands.relief else None, bands.gsd, intensity):
                if band is not None:
                    np.copyto(band[tile.window], np.nan, where=outside)


def _sky_colours(bands: Bands, raster: OrthoRaster) -> SkyColours:
    """Learns the colours of the sky and of the facade from its picture; without a relief, there are none."""
    if bands.relief is None:
        return SkyColours(np.inf, np.inf, None)
    step = max(_SAMPLED, round(np.sqrt(bands.source.size / _ENOUGH)))
    facade, over = [np.zeros((0, 3), np.uint8)], [np.zeros((0, 3), np.uint8)]
    for tile in tiles(raster.height, raster.width, TILE_PX):
        above, pixels = bands.relief.above_wall(raster, tile), bands.pixels[tile.window]
        some, shown = above[::step, ::step], pixels[::step, ::step]
        facade.append(shown[(some == 0) & (shown[..., 3] > 0)][:, :3])
        some, shown = above[::_SAMPLED_ABOVE, ::_SAMPLED_ABOVE], pixels[::_SAMPLED_ABOVE, ::_SAMPLED_ABOVE]
        over.append(shown[(some > 0) & (shown[..., 3] > 0)][:, :3])
    return SkyColours.of(np.concatenate(facade), np.concatenate(over))
