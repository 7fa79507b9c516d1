"""Chooses among photos of a window: one photo for all of it, and the one with the least reflection.

What glass mirrors is added to the light from the room behind it. Of several photos in one light, the darkest
ones therefore show the least reflection, and how much brighter another photo is tells how much it mirrors. As
the darkest of three or more may show a walker, they are compared with the second darkest.
"""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Bool, Int
from frontage.ortho.mosaic.pictures import CellPictures
from frontage.ortho.mosaic.radiometry import PhotoGains

_REFLECTION = 2.0  # cost of e times the light of the darkest: of e^2 times its pixels per area
_FEWEST_CELLS = 4  # of an opening that a photo must show clearly to be judged


@dataclass(frozen=True, eq=False)
class GlassCost:
    """What photos (k) cost in the cells (h, w) of glazed openings.

    opening     (h, w), number of the opening of a cell, 0 = wall
    clear       (k, h, w) bool, seen with nothing in front
    reflection  (k, h, w) float32 >= 0, logarithm of the light over that of the (second) darkest photo
    """

    opening: Int
    clear: Bool
    reflection: Array

    def of_whole_openings(self, cost: Array) -> Array:
        """Replaces the costs (k, h, w) of clear cells by their mean over the opening, with its reflection."""
        out = cost.copy()
        flat, count = self.opening.ravel(), int(self.opening.max(initial=0)) + 1
        for k in range(len(cost)):
            use = (self.clear[k] & (self.opening > 0)).ravel()
            number = np.bincount(flat[use], minlength=count)
            total = cost[k].ravel()[use] + _REFLECTION * self.reflection[k].ravel()[use]
            mean = np.bincount(flat[use], total, count) / np.maximum(number, 1)
            use &= number[flat] >= _FEWEST_CELLS
            out[k].ravel()[use] = mean[flat[use]]
        return out


def glass_cost(opening: Int, clear: Bool, pictures: CellPictures, gains: PhotoGains) -> GlassCost:
    """Compares the light of the photos in the glazed openings (h, w) of a facade."""
    light = np.stack(
        [
            (pictures.log_light[k] - gains.at(k, pictures.radius[k])).mean(-1)
            for k in range(len(pictures.log_light))
        ]
    )
    usable = clear & pictures.shown
    dark = np.sort(np.where(usable, light, np.inf), axis=0)
    least = np.where(usable.sum(0) > 2, dark[min(1, len(dark) - 1)], dark[0])
    reflection = np.where(usable, np.maximum(light - np.where(np.isfinite(least), least, 0.0), 0.0), 0.0)
    return GlassCost(opening, clear, reflection.astype(np.float32))
