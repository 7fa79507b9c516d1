"""Cells over the plane of a facade, to count beams and points in."""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Bool, Float, Int
from frontage.model.facade import Facade
from frontage.raster.memory import require_memory

_ROUNDING = 1e-6  # of a cell, by which places may be off
_CELL_BYTES = 64  # of a cell: eight numbers, its evidence and what it is computed from

TILE = 0.25
"""m, side of the tiles that hold the depth of the wall."""

FITTING = 0.3
"""m: sills, surrounds, open shutters and cut stone stand out no further, and close what they cover."""


@dataclass(frozen=True)
class WallRaster:
    """Cells over the facade plane.

    corner  x, z m of the lower left corner
    cell    m, side of a cell
    shape   number of rows (upwards) and columns
    """

    corner: tuple[float, float]
    cell: float
    shape: tuple[int, int]

    @classmethod
    def over(cls, facade: Facade, cell: float) -> "WallRaster":
        """Returns the raster with cells of `cell` m over the facade's bounding box.

        From left to right it is centred and has an even number of cells, so that blocks of cells begin at the
        same places in a mirrored facade. Raises InputError (I322) when it needs more memory than there is.
        """
        x0, z0, x1, z1 = facade.extent
        shape = (int((z1 - z0) / cell) + 1, 2 * (int((x1 - x0) / (2.0 * cell)) + 1))
        what = f"facade {facade.id} of {x1 - x0:.1f} x {z1 - z0:.1f} m in cells of {cell:.3g} m"
        require_memory(_CELL_BYTES * shape[0] * shape[1], what)
        return cls((0.5 * (x0 + x1 - shape[1] * cell), z0), cell, shape)

    def flat(self, x: Float, z: Float) -> Int:
        """Returns the number of the cell of every place (n,), row by row; -1 outside or for NaN."""
        with np.errstate(invalid="ignore"):
            c, r = x - self.corner[0], z - self.corner[1]
            for steps in (c, r):
                steps /= self.cell
                np.floor(steps, out=steps)
            inside = (c >= 0) & (r >= 0) & (c < self.shape[1]) & (r < self.shape[0])
            r *= self.shape[1]
            r += c
            return np.where(inside, r, -1.0).astype(np.int64)

    def box(self, r0: int, c0: int, r1: int, c1: int) -> tuple[float, float, float, float]:
        """Returns the box x0, z0, x1, z1 m of the cells in the rows [r0, r1) and columns [c0, c1)."""
        x, z = self.corner
        return x + c0 * self.cell, z + r0 * self.cell, x + c1 * self.cell, z + r1 * self.cell

    def cells(self, box: tuple[float, float, float, float]) -> tuple[slice, slice]:
        """Returns the rows and columns of the cells within a box x0, z0, x1, z1 m, as far as they exist."""
        low, high = self.ends(np.array([box]))
        (c0, r0), (c1, r1) = low[0].tolist(), high[0].tolist()
        return slice(r0, r1), slice(c0, c1)

    def ends(self, boxes: Float) -> tuple[Int, Int]:
        """Returns the first cells and those after the last (n, 2), column and row, of boxes (n, 4) m.

        They are those whose borders lie nearest, as far as they exist. A box that ends in the middle of a
        cell has this cell at either end, so that it has the same cells in a mirrored facade.
        """
        at = (boxes - np.array(self.corner * 2)) / self.cell
        size = np.array(self.shape[::-1])
        low = np.clip(np.ceil(at[:, :2] - 0.5 - _ROUNDING), 0, size)
        high = np.clip(np.floor(at[:, 2:] + 0.5 + _ROUNDING), 0, size)
        return low.astype(np.int64), high.astype(np.int64)

    def middles(self, which: Bool) -> Float:
        """Returns the middles (n, 2) x, z m of the cells that are set in `which` (h, w), row by row."""
        rows, columns = np.nonzero(which)
        return np.column_stack([columns + 0.5, rows + 0.5]) * self.cell + self.corner

    def count(self, x: Float, z: Float, weight: Float | None = None) -> Float:
        """Counts the places (n,) in each cell (h, w), or sums their weights (n,)."""
        at = self.flat(x, z)
        on, size = at >= 0, self.shape[0] * self.shape[1]
        sums = np.bincount(at[on], None if weight is None else weight[on], size)
        return sums.reshape(self.shape).astype(np.float64)


def summed(values: Float) -> Float:
    """Returns the sums (h + 1, w + 1, ...) of the values (h, w, ...) below and left of all cell corners."""
    return np.asarray(cv2.integral(values, sdepth=cv2.CV_64F))


def averaged(values: Float) -> Float:
    """Averages values (h, w) over 3 x 3 cells; at the border the outermost cells count twice."""
    return np.asarray(cv2.blur(values, (3, 3), borderType=cv2.BORDER_REFLECT))


def opened(cells: Bool, size: tuple[int, int]) -> Bool:
    """Leaves of the cells (h, w) what rectangles of `size` (rows, columns) cover within them."""
    return _grown(_shrunk(cells, size), size)


def closed(cells: Bool, size: tuple[int, int]) -> Bool:
    """Adds to the cells (h, w) the gaps that no rectangle of `size` (rows, columns) fits into."""
    return _shrunk(_grown(cells, size), size)


def _shrunk(cells: Bool, size: tuple[int, int]) -> Bool:
    """Leaves the cells (h, w) that are the middle of a rectangle of cells, none of them beyond the border."""
    kernel, middle = np.ones(size, np.uint8), (size[1] // 2, size[0] // 2)
    found = cv2.erode(
        cells.view(np.uint8), kernel, anchor=middle, borderType=cv2.BORDER_CONSTANT, borderValue=0
    )
    return np.asarray(found.view(np.bool_))


def _grown(cells: Bool, size: tuple[int, int]) -> Bool:
    """Adds the rectangle around each of the cells (h, w), whose middle is that of `_shrunk`."""
    kernel, middle = np.ones(size, np.uint8), ((size[1] - 1) // 2, (size[0] - 1) // 2)
    return np.asarray(cv2.dilate(cells.view(np.uint8), kernel, anchor=middle).view(np.bool_))
