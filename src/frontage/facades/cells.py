"""The raster of a facade: which cells show wall, and which belong to the outline."""

from dataclasses import dataclass, replace

import numpy as np
import shapely
from scipy import ndimage
from shapely.geometry import Polygon

from frontage.geometry.arrays import Bool, Float, Int
from frontage.geometry.ring import cells_ring, polygon_ring


@dataclass(frozen=True, eq=False)
class CellMap:
    """Cells (h, w) of a facade. Row r, column c starts at ``corner + cell * (c, r)`` in (x, z) m, rows up.

    wall   (h, w) cells with points on the plane, of the chosen connected component only
    whole  (h, w) cells of the outline: the wall together with its openings
    shut   (h, w) cells with points on the wall or in front of it, which no line of sight passes
    """

    corner: tuple[float, float]
    cell: float
    wall: Bool
    whole: Bool
    shut: Bool

    @property
    def area(self) -> float:
        """Area of the wall that was seen, m2."""
        return float(self.wall.sum()) * self.cell**2

    @property
    def coverage(self) -> float:
        """Share of the outline that has points on the wall, 0..1."""
        return float((self.wall & self.whole).sum() / max(self.whole.sum(), 1))

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the outline, m."""
        rows, columns = np.flatnonzero(self.whole.any(1)), np.flatnonzero(self.whole.any(0))
        if len(rows) == 0:
            return 0.0, 0.0
        return float(np.ptp(columns) + 1) * self.cell, float(np.ptp(rows) + 1) * self.cell

    @property
    def outline(self) -> Float:
        """Ring (k, 2) m of the outline, through the middles of its border cells, which are half filled."""
        ring = cells_ring(self.whole, self.corner, self.cell, 0.75 * self.cell)
        inner = Polygon(ring).buffer(-0.5 * self.cell, join_style="mitre")
        parts = [p for p in shapely.get_parts(inner) if isinstance(p, Polygon) and not p.is_empty]
        return polygon_ring(max(parts, key=lambda part: float(part.area))) if parts else ring

    def marked(self, x: Float, z: Float) -> Bool:
        """Returns the cells (h, w) of the outline that hold at least one of the points (n,) m."""
        mask = np.zeros(self.whole.size, np.bool_)
        mask[self.flat(x, z)] = True
        return mask.reshape(self.whole.shape) & self.whole

    def flat(self, x: Float, z: Float) -> Int:
        """Returns the cell number (n,), counted row by row, of points (n,) m.

        Points outside the raster get the nearest border cell. No outline reaches that far, because the
        raster has a margin.
        """
        h, w = self.wall.shape
        column = ((x - self.corner[0]) * (1.0 / self.cell)).astype(np.int64)
        row = ((z - self.corner[1]) * (1.0 / self.cell)).astype(np.int64)
        np.clip(column, 0, w - 1, out=column)
        np.clip(row, 0, h - 1, out=row)
        row *= w
        row += column
        return row

    def shrunk(self, border: float) -> Bool:
        """Returns the cells (h, w) of the outline that lie more than `border` m inside it."""
        return np.asarray(ndimage.distance_transform_edt(self.whole) * self.cell > border, np.bool_)

    def with_outline(self, whole: Bool) -> "CellMap":
        """Returns the map with another outline, the cells `whole` (h, w), and the wall within that."""
        return replace(self, whole=whole, wall=self.wall & whole, shut=self.shut & whole)

    def moved(self, x: float, z: float) -> "CellMap":
        """Returns the same cells with coordinates counted from the point (x, z) m."""
        return replace(self, corner=(self.corner[0] - x, self.corner[1] - z))

    @property
    def mirrored(self) -> "CellMap":
        """The same cells seen from the other side of the wall: x changes sign."""
        corner = (-self.corner[0] - self.wall.shape[1] * self.cell, self.corner[1])
        return CellMap(corner, self.cell, self.wall[:, ::-1], self.whole[:, ::-1], self.shut[:, ::-1])

    def locate(self, x: Float, z: Float) -> tuple[Int, Int, Bool]:
        """Returns row (n,), column (n,), both clipped to the raster, and whether the point is inside (n,)."""
        column = np.floor((x - self.corner[0]) / self.cell).astype(np.int64)
        row = np.floor((z - self.corner[1]) / self.cell).astype(np.int64)
        h, w = self.wall.shape
        inside = (row >= 0) & (row < h) & (column >= 0) & (column < w)
        return np.clip(row, 0, h - 1), np.clip(column, 0, w - 1), inside

    def within(self, x: Float, z: Float, mask: Bool | None = None) -> Bool:
        """Returns whether points (n,) m fall on an outline cell, or on one that `mask` (h, w) also sets."""
        return np.asarray(
            (self.whole if mask is None else mask & self.whole).ravel()[self.flat(x, z)], np.bool_
        )
