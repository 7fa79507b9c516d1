"""The bands of an ortho-image while it is made, and what is done to all of them at once."""

import numpy as np

from frontage.geometry.arrays import Array
from frontage.model import Facade
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.outline import inside_outline
from frontage.raster.tiles import allocate, tiles

TILE = 1024  # px
_MISSED = 0.25  # share of the facade that photos must miss before a picture of two kinds is the better one


class Bands:
    """Empty pixels (h, w, 4) uint8, depth, gsd (h, w) float32 m (NaN = none), source (h, w) uint16.

    Without `relief` the depth is one NaN, shown (h, w) times.
    """

    def __init__(self, raster: OrthoRaster, relief: bool = False) -> None:
        shape = (raster.height, raster.width)
        self.relief = relief
        self.pixels = allocate((*shape, 4), np.uint8)
        self.depth = (
            allocate(shape, np.float32, np.nan) if relief else np.broadcast_to(np.float32(np.nan), shape)
        )
        self.source = allocate(shape, np.uint16)
        self.gsd = allocate(shape, np.float32, np.nan)


def missed_by_photos(bands: Bands, facade: Facade, raster: OrthoRaster) -> bool:
    """Whether so much of the facade's inside has no source that the scan should show it."""
    inside, missed = 0, 0
    for tile in tiles(raster.height, raster.width, TILE):
        mask = inside_outline(facade, raster, tile, 0.0)
        inside += int(mask.sum())
        missed += int((mask & (bands.source[tile.window] == 0)).sum())
    return missed > _MISSED * inside


def fill(bands: Bands, other: Bands, number: int, raster: OrthoRaster) -> bool:
    """Put pixels of `other` where `bands` has none, with `number` as their source; whether it was done.

    It is when more than a quarter of what the other shows is missing; otherwise nothing is changed.
    """
    shown, gained = 0, 0
    for tile in tiles(raster.height, raster.width, TILE):
        known = other.source[tile.window] > 0
        shown += int(known.sum())
        gained += int((known & (bands.source[tile.window] == 0)).sum())
    if gained <= _MISSED * shown:
        return False
    for tile in tiles(raster.height, raster.width, TILE):
        take = (other.source[tile.window] > 0) & (bands.source[tile.window] == 0)
        bands.pixels[tile.window][take] = other.pixels[tile.window][take]
        bands.gsd[tile.window][take] = other.gsd[tile.window][take]
        bands.source[tile.window][take] = number
    return True


def cut_out(
    bands: Bands, intensity: Array | None, facade: Facade, raster: OrthoRaster, options: OrthoOptions
) -> None:
    """Clear what lies outside the facade's outline; within its margin a measured surface stays.

    Without any relief, which could tell a cornice from the sky, the whole margin stays.
    """
    measured = bands.relief and any(
        np.isfinite(bands.depth[t.window]).any() for t in tiles(raster.height, raster.width, TILE)
    )
    for tile in tiles(raster.height, raster.width, TILE):
        outside = ~inside_outline(facade, raster, tile, options.margin)
        if measured:
            outside |= ~np.isfinite(bands.depth[tile.window]) & ~inside_outline(facade, raster, tile, 0.0)
        if outside.any():
            bands.pixels[tile.window][outside] = 0
            bands.source[tile.window][outside] = 0
            for band in (bands.depth if bands.relief else None, bands.gsd, intensity):
                if band is not None:
                    band[tile.window][outside] = np.nan
