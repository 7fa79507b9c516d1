"""The surface that the picture of a facade is drawn on, and its projection into photos."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Array, Int
from frontage.model import Facade, Photo, PhotoOffset
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.project import PixelMap, pixel_map, shifted
from frontage.ortho.relief import ReliefMap
from frontage.raster.tiles import Tile

ImageOf = Callable[[str], Array]
"""The picture (h, w, 3) uint8 RGB of a photo, by the photo's id."""


@dataclass(frozen=True, eq=False)
class DrawingSurface:
    """The surface that the picture is drawn on: the measured relief of a facade, or its plane.

    raster  the pixels of the picture, or coarser cells of it
    relief  None = the plane y = 0
    offset  m that the surface lies behind the relief or the plane
    drawn   (h, w) float32 m, depths of all pixels of the raster where they are known already
    """

    facade: Facade
    raster: OrthoRaster
    relief: ReliefMap | None
    offset: float = 0.0
    drawn: Array | None = None

    def on(self, raster: OrthoRaster, drawn: Array | None = None) -> "DrawingSurface":
        """Returns the same surface for the pixels of another raster, whose depths may be known already."""
        return replace(self, raster=raster, drawn=drawn)

    def moved_by(self, found: PhotoOffset | None) -> "DrawingSurface":
        """Returns the surface at the depth at which the photos see it, where that offset is to be applied."""
        return self if found is None or not found.applied else replace(self, offset=found.value)

    def depth(self, tile: Tile) -> Array | None:
        """Returns y (m, n) float32 m of the pixels of a tile without the offset; None for the plane.

        Where the relief was not measured, the pixel takes the depth of the nearest measured surface. Callers
        must not write to it.
        """
        if self.drawn is not None:
            return self.drawn[tile.window]
        return None if self.relief is None else self.relief.at(self.raster, tile)

    def openings(self, tile: Tile) -> Int:
        """Returns the number (m, n) of the glazed opening at the pixels of a tile; 0 = wall."""
        return (
            np.zeros(tile.shape, np.int64) if self.relief is None else self.relief.openings(self.raster, tile)
        )

    def projection_into(self, photo: Photo, projection: str) -> PixelMap:
        """Returns the map from raster pixels and depths to photo pixels, the offset included."""
        return shifted(pixel_map(photo, self.facade, self.raster, projection), self.offset)
