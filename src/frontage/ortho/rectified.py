"""The photos rectified on the cells of a plan, each once: what they are compared by and chosen by."""

from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Array
from frontage.model import Photo
from frontage.ortho.project import map_tile
from frontage.ortho.surface import DrawingSurface, ImageOf
from frontage.ortho.views import ViewPlan
from frontage.raster.resample import resample
from frontage.raster.tiles import tiles

_TILE_PX = 512
_MAP_ERROR_PX = 0.05  # in the photo: cells are several pixels wide


@dataclass(frozen=True, eq=False)
class CellPhotos:
    """Rectifies photos on a surface of cells, each when it is first asked for.

    Their pictures (h, w, 4) uint8 are RGBA, zero in the tiles that were not looked at.
    """

    surface: DrawingSurface
    projection: str
    image_of: ImageOf
    _known: dict[str, Array] = field(default_factory=dict)

    @classmethod
    def of(cls, surface: DrawingSurface, plan: ViewPlan | None, image_of: ImageOf) -> "CellPhotos | None":
        """The photos of a plan on its cells, by the full projection; None without a plan."""
        return None if plan is None else cls(surface.on(plan.cells, plan.depth), "full", image_of)

    def __call__(self, photo: Photo, shown: Array) -> Array:
        """Return what a photo shows in the tiles in which it is `shown` (h, w) anywhere."""
        if photo.id not in self._known:
            self._known[photo.id] = self.rectified(photo, self.image_of(photo.id), shown)
        return self._known[photo.id]

    def rectified(self, photo: Photo, image: Array, shown: Array) -> Array:
        """Rectifies a picture (H, W, 3) as that of a photo, in the tiles in which it is `shown` (h, w)."""
        shape = (self.surface.raster.height, self.surface.raster.width)
        codes = np.zeros((*shape, 4), np.uint8)
        to_photo = self.surface.projection_into(photo, self.projection)
        for tile in tiles(shape[0], shape[1], _TILE_PX):
            if shown[tile.window].any():
                at = map_tile(to_photo, tile, self.surface.depth(tile), _MAP_ERROR_PX)
                resample(image, at, out=codes[tile.window], rough=True)
        return codes

    def again(
        self, surface: DrawingSurface, projection: str, image_of: ImageOf, turned: frozenset[str]
    ) -> "CellPhotos":
        """Return the photos on a surface of the same cells, of which those `turned` have new pictures."""
        moved = surface.offset != self.surface.offset or projection != self.projection
        kept = {name: found for name, found in self._known.items() if name not in turned and not moved}
        cells = surface.on(self.surface.raster, self.surface.drawn)
        return CellPhotos(cells, projection, image_of, kept)
