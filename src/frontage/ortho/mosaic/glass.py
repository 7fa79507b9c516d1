"""Chooses among photos of a window: one photo for all of it, and one with little reflection.

What glass mirrors is added to the light from the room behind it. Of several photos in one light, the darkest
ones therefore show the least reflection, and how much brighter another photo is tells how much it mirrors. As
the darkest of three or more may show something that stands before the window, photos are compared with the
second darkest, and by the median of their light over the window.
"""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.raster import gridding

_REFLECTION = 2.0  # cost of e times the light of the darkest: of e^2 times its pixels per area
_ENOUGH = 0.5  # share of an opening that a photo must show clearly to be compared


@dataclass(frozen=True, eq=False)
class GlassCost:
    """What photos (k) cost in glazed openings (n).

    opening     (h, w), number of the opening of a cell, 0 = wall
    clear       (k, h, w) bool, seen with nothing in front
    reflection  (k, n) >= 0, logarithm of the light over that of the (second) darkest photo
    """

    opening: Int
    clear: Bool
    reflection: Float

    def of_whole_openings(self, cost: Array) -> Array:
        """Replaces the costs (k, h, w) of clear cells by their mean over the opening, with its reflection."""
        out = cost.copy()
        flat, count = self.opening.ravel(), self.reflection.shape[1]
        for k in range(len(cost)):
            use = np.flatnonzero((self.clear[k] & (self.opening > 0)).ravel())
            own = flat[use]
            number = np.bincount(own, minlength=count)
            mean = np.bincount(own, cost[k].ravel()[use], count) / np.maximum(number, 1)
            out[k].ravel()[use] = (mean + _REFLECTION * self.reflection[k])[own]
        return out


def glass_cost(opening: Int, clear: Bool, shown: Bool, even: Array) -> GlassCost:
    """Compares the even log light (k, h, w, 3) of the photos in the glazed openings (h, w) of a facade."""
    flat, count = opening.ravel().astype(np.int64), int(opening.max(initial=0)) + 1
    area = np.bincount(flat, minlength=count)
    light = np.full((len(clear), count), np.inf)
    for k in range(len(clear)):
        use = np.flatnonzero((clear[k] & shown[k] & (opening > 0)).ravel())
        own = np.take(even[k].reshape(-1, 3), use, axis=0) @ np.full(3, 1.0 / 3.0, np.float32)
        (median,), number = gridding.cell_quantiles(flat[use], own.astype(np.float64), (1, count), (0.5,))
        light[k] = np.where(number[0] >= _ENOUGH * area, median[0], np.inf)
    dark = np.sort(light, axis=0)
    several = np.isfinite(light).sum(0) > 2
    least = np.where(several, dark[min(1, len(dark) - 1)], dark[0])
    with np.errstate(invalid="ignore"):
        excess = np.maximum(light - least, 0.0)
    return GlassCost(opening, clear, np.where(np.isfinite(excess), excess, 0.0))
