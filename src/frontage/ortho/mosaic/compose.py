"""Decides on one picture from many photos: which photo paints which cell, and in what light."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array
from frontage.ortho.mosaic.blending import light_corrections
from frontage.ortho.mosaic.consensus import compare_photos, even_colours
from frontage.ortho.mosaic.glass import glass_cost
from frontage.ortho.mosaic.pairs import judge_pairs
from frontage.ortho.mosaic.pictures import cell_pictures, picked
from frontage.ortho.mosaic.places import whole_places
from frontage.ortho.mosaic.radiometry import PhotoGains, balance_photos, even_light
from frontage.ortho.mosaic.seethrough import see_through
from frontage.ortho.mosaic.selection import choose_photos
from frontage.ortho.options import OrthoOptions
from frontage.ortho.rectified import CellPhotos
from frontage.ortho.surface import DrawingSurface
from frontage.ortho.views import ViewPlan
from frontage.raster.tiles import Tile


@dataclass(frozen=True, eq=False)
class Mosaic:
    """Which photo of a plan paints which cell (h, w), and in what light.

    label       (h, w) int16, index into `plan.photos`, -1 = none
    correction  (k, h, w, 3) float32, logarithm of the factor on the light of a photo; None = as it was shot
    gains       by how much the photos are brighter; None = nothing to compare a photo with
    """

    plan: ViewPlan
    label: Array
    correction: Array | None = None
    gains: PhotoGains | None = None

    @property
    def light(self) -> dict[str, Array]:
        """What was found about the light of every photo (`PhotoGains.rows`), by its id."""
        if self.gains is None:
            return {}
        return {photo.id: self.gains.rows(k) for k, photo in enumerate(self.plan.photos)}

    @property
    def gsd(self) -> Array:
        """The size (h, w) float32 m of a pixel of the chosen photo on the facade; NaN where there is none."""
        gsd = picked(self.plan.gsd, self.label)
        return np.asarray(np.where(self.label >= 0, gsd, np.float32(np.nan)))


def compose_mosaic(
    surface: DrawingSurface,
    plan: ViewPlan | None,
    rectified: CellPhotos | None,
    options: OrthoOptions,
    light: Mapping[str, Array],
) -> Mosaic | None:
    """Chooses the photos of the cells and the light that they are painted in; None without a plan.

    `light` is what other facades have told of photos, see `balance_photos`.
    """
    if plan is None or rectified is None:
        return None
    if len(plan.photos) == 1 and plan.photos[0].id not in light:
        plan = plan.seeing(np.zeros_like(plan.behind))
        return Mosaic(plan, np.where(plan.quality[0] > 0, 0, -1).astype(np.int16))
    pictures = cell_pictures(plan, rectified)
    gains = balance_photos(plan, pictures, light)
    opening = surface.on(plan.cells).openings(Tile(0, plan.cells.height, 0, plan.cells.width))
    even = even_light(pictures, gains)
    glass = glass_cost(opening, plan.clear, pictures.shown, even)
    codes = even_colours(even)
    found = judge_pairs(codes, compare_photos(codes, plan.clear), plan.clear, opening > 0)
    through = see_through(codes, found, plan, opening > 0)
    place = whole_places(found, plan.clear, plan.cells.gsd)
    plan = plan.seeing(through)
    label = choose_photos(plan, found, pictures.exposed, glass, place)
    if options.radiometry == "as shot":
        return Mosaic(plan, label, gains=gains)
    usable = plan.clear & pictures.exposed & found.accepted
    return Mosaic(plan, label, light_corrections(label, usable, pictures, gains), gains)
