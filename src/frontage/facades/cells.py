"""The facade's raster of cells: which are seen wall, which connected part is the facade, its outline."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.geometry.ring import cells_ring

_GAP = 2.0  # m: the widest opening or shadow that a wall bridges (shop window, gate)
_THINNEST = 0.3  # m: what is thinner is no wall (a strip of ground, a wire)


@dataclass(frozen=True, eq=False)
class CellMap:
    """Cells (h, w) of a facade: row r, column c covers `corner + cell * (c, r)` .. + cell, in (x, z) m.

    wall   cells with points on the plane, of the chosen part only
    whole  cells of the outline: the wall with its openings
    """

    corner: tuple[float, float]
    cell: float
    wall: Bool
    whole: Bool

    @property
    def area(self) -> float:
        """m2 of seen wall."""
        return float(self.wall.sum()) * self.cell**2

    @property
    def coverage(self) -> float:
        """Share of the outline with points on the wall."""
        return float((self.wall & self.whole).sum() / max(self.whole.sum(), 1))

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in m of the outline."""
        rows, columns = np.flatnonzero(self.whole.any(1)), np.flatnonzero(self.whole.any(0))
        if len(rows) == 0:
            return 0.0, 0.0
        return float(np.ptp(columns) + 1) * self.cell, float(np.ptp(rows) + 1) * self.cell

    @property
    def outline(self) -> Float:
        """Ring (k, 2) m of the outline."""
        return cells_ring(self.whole, self.corner, self.cell, 0.75 * self.cell)

    def locate(self, x: Float, z: Float) -> tuple[Int, Int, Bool]:
        """Row, column (clipped) and whether inside the raster, of points (n,)."""
        column = np.floor((x - self.corner[0]) / self.cell).astype(np.int64)
        row = np.floor((z - self.corner[1]) / self.cell).astype(np.int64)
        h, w = self.wall.shape
        inside = (row >= 0) & (row < h) & (column >= 0) & (column < w)
        return np.clip(row, 0, h - 1), np.clip(column, 0, w - 1), inside

    def within(self, x: Float, z: Float, mask: Bool | None = None) -> Bool:
        """Whether points (n,) fall on a cell that is set in `mask` (the outline when omitted)."""
        row, column, inside = self.locate(x, z)
        return np.asarray((self.whole if mask is None else mask)[row, column] & inside, np.bool_)


def occupied(x: Float, z: Float, cell: float) -> tuple[Array, tuple[float, float]]:
    """Number of points per cell (h, w) with a margin of one gap, and the raster's corner (x, z) m on whole cells."""
    margin = int(np.ceil(_GAP / cell)) + 2
    c0, r0 = int(np.floor(x.min() / cell)) - margin, int(np.floor(z.min() / cell)) - margin
    column, row = np.floor(x / cell).astype(np.int64) - c0, np.floor(z / cell).astype(np.int64) - r0
    h, w = int(row.max()) + margin + 1, int(column.max()) + margin + 1
    count = np.bincount(row * w + column, minlength=h * w).reshape(h, w)
    return count, (c0 * cell, r0 * cell)


def contrast(x: Float, y: Float, z: Float, cells: CellMap, threshold: float) -> float:
    """Area on the plane over the mean area of equally thick slabs on both sides: a wall has much, a bush has 1.

    x, y, z    (n,) m, facade coordinates; threshold m, half the thickness of a slab
    """
    row, column, inside = cells.locate(x, z)
    area = []
    for slab in (-1, 0, 1):
        use = inside & (np.abs(y - 2.0 * slab * threshold) < threshold)
        mask = np.zeros_like(cells.wall)
        mask[row[use], column[use]] = True
        area.append(int((mask & cells.whole).sum()))
    return 2.0 * area[1] / max(area[0] + area[2], 1)


def _disk(radius: float) -> Bool:
    reach = int(np.ceil(radius))
    grid = np.arange(-reach, reach + 1)
    return np.asarray(np.hypot(grid[:, None], grid[None, :]) <= radius, np.bool_)


def _close(mask: Bool, radius: float) -> Bool:
    """Closing by a disk of `radius` cells, by distance transforms (cost independent of the radius)."""
    grown = ndimage.distance_transform_edt(~mask) <= radius
    return np.asarray(ndimage.distance_transform_edt(grown) > radius, np.bool_)


def largest_part(count: Array, corner: tuple[float, float], cell: float, gap: float = _GAP) -> CellMap | None:
    """The connected part with the most wall, bridging gaps up to `gap` m, its holes filled; None when nothing is left."""
    wall = count > 0
    pruned = ndimage.binary_opening(_close(wall, 1.5), _disk(max(_THINNEST / cell / 2, 1.0)))
    if not pruned.any():
        return None
    whole = ndimage.binary_fill_holes(_close(pruned, 0.5 * gap / cell))
    labels, number = ndimage.label(whole)
    if number > 1:
        weight = np.bincount(labels[wall], minlength=number + 1)
        weight[0] = 0
        whole = labels == int(np.argmax(weight))
    return CellMap(corner, cell, np.asarray(wall & whole, np.bool_), np.asarray(whole, np.bool_))
