"""The point-availability map (paper B, section 3.2.2, first paragraph)."""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float
from frontage.raster.gridding import cell_index

ELEMENT = 1.5
"""Grid element over the point distance: "a value a little higher than the point sampling distance"."""


@dataclass(frozen=True, eq=False)
class AvailabilityMap:
    """A binary image of the facade: which grid elements hold points.

    available  (h, w) bool; row r, column c covers ``corner + cell * (c..c+1, r..r+1)`` (x, z) m
    inside     (h, w) bool, the elements whose centre lies within the facade's outline
    corner     x, z m of the lower left corner
    cell       m, side of an element
    """

    available: Bool
    inside: Bool
    corner: tuple[float, float]
    cell: float

    @classmethod
    def of(cls, xz: Float, outline: Float, distance: float) -> Self:
        """Makes the map of points (n, 2) m on a facade with `outline` (k, 2) m; `distance` m apart."""
        cell = ELEMENT * distance
        low, high = outline.min(0), outline.max(0)
        w, h = (np.maximum(np.ceil((high - low) / cell), 1)).astype(int)
        flat, _ = cell_index((xz - low) / cell, (h, w))
        available = np.zeros(h * w, np.bool_)
        available[flat] = True
        x, z = np.meshgrid(low[0] + cell * (np.arange(w) + 0.5), low[1] + cell * (np.arange(h) + 0.5))
        inside = np.asarray(shapely.contains_xy(shapely.Polygon(outline), x, z), np.bool_)
        return cls(available.reshape(h, w), inside, (float(low[0]), float(low[1])), float(cell))

    def share(self, xs: Float, zs: Float) -> tuple[Float, Float]:
        """Returns the share of available elements of cells, and the share of each within the outline.

        xs  (m + 1,) m
        zs  (n + 1,) m

        Both are (n, m), the first NaN outside. Elements cut by a plane count by their area.
        """
        held, within = (self._sums(total, xs, zs) for total in self._totals)
        area = np.diff(zs)[:, None] * np.diff(xs)[None] / self.cell**2
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.where(within > 1e-9, held / within, np.nan)
        return share, within / np.maximum(area, 1e-12)

    def box_share(self, box: tuple[float, float, float, float]) -> tuple[float, float]:
        """Returns the share of available elements in a rectangle x0, z0, x1, z1 m, and their number."""
        x0, z0, x1, z1 = box
        share, _ = self.share(np.array([x0, x1]), np.array([z0, z1]))
        return float(np.nan_to_num(share[0, 0])), (x1 - x0) * (z1 - z0) / self.cell**2

    @cached_property
    def _totals(self) -> tuple[Float, Float]:
        """Integral images (h + 1, w + 1) of the available elements within the outline, and of all there."""
        totals = np.zeros((2, self.inside.shape[0] + 1, self.inside.shape[1] + 1))
        for total, mask in zip(totals, (self.available & self.inside, self.inside), strict=True):
            total[1:, 1:] = mask.cumsum(0).cumsum(1)
        return totals[0], totals[1]

    def _sums(self, total: Float, xs: Float, zs: Float) -> Float:
        """Returns the sums (n, m) over the cells, in elements, by bilinear reading of an integral image."""
        rows = _between(total, (zs - self.corner[1]) / self.cell)
        corners = _between(rows.T, (xs - self.corner[0]) / self.cell).T
        return np.asarray(np.diff(np.diff(corners, axis=0), axis=1))

    def centres(self, box: tuple[float, float, float, float]) -> tuple[Float, Bool]:
        """Returns the centres (k, 2) m of the elements wholly in a rectangle, and which are available."""
        x0, z0, x1, z1 = box
        c0, r0 = (int(np.ceil((v - o) / self.cell)) for v, o in zip((x0, z0), self.corner, strict=True))
        c1, r1 = (int(np.floor((v - o) / self.cell)) for v, o in zip((x1, z1), self.corner, strict=True))
        part = self.available[max(r0, 0) : max(r1, 0), max(c0, 0) : max(c1, 0)]
        r, c = np.indices(part.shape)
        x = self.corner[0] + self.cell * (c + max(c0, 0) + 0.5)
        z = self.corner[1] + self.cell * (r + max(r0, 0) + 0.5)
        return np.column_stack([x.ravel(), z.ravel()]), part.ravel()


def _between(table: Float, at: Float) -> Float:
    """Returns the rows (k, m) of a table (n, m) at fractional places (k,), its ends held."""
    at = np.clip(at, 0, len(table) - 1)
    low = np.minimum(at.astype(int), len(table) - 2)
    part = (at - low)[:, None]
    return np.asarray(table[low] * (1 - part) + table[low + 1] * part)
