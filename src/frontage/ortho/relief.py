"""The relief of a facade: depth y of its surface, cell by cell, and sharpened to pixels.

A window frame 15 cm behind the wall is displaced by ``15 cm x tan(theta)`` in an ortho-image on the plane;
the relief removes that. Cells hold the median depth of their points; mixed cells (a reveal's edge, foliage in
front of a wall) are left out and taken from their neighbours, and at a step the pixel takes one side or the
other, never a mean, so that edges stay straight and sharp.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.ortho.frame import Raster
from frontage.ortho.options import OrthoOptions
from frontage.raster import gridding
from frontage.raster.tiles import Tile

CELL = 0.03  # m
_CELL_SPACINGS = 1.5  # a cell holds about two points of the wall
_COARSEST = 0.15  # m: a coarser relief is worse than the plane, reveals being 0.1 to 0.3 m deep
_STEP = 0.03  # m between neighbouring cells that is an edge and not a slope
_BRIDGE = 2  # cells: gaps up to twice as wide are closed


@dataclass(frozen=True)
class Relief:
    """Depth y (h, w) float64 m by cell of `raster`, NaN where not measured; near and far side at steps."""

    raster: Raster
    y: Array
    near: Array
    far: Array
    known: Array

    def at(self, raster: Raster, tile: Tile) -> Array:
        """Depth (rows, columns) float32 m of the pixels of a tile of the fine raster, NaN where unknown."""
        ratio = raster.gsd / self.raster.gsd
        offset = (raster.corner[0] - self.raster.corner[0], self.raster.corner[1] - raster.corner[1])
        u = (np.arange(tile.c0, tile.c1) + 0.5) * ratio + offset[0] / self.raster.gsd - 0.5
        v = (np.arange(tile.r0, tile.r1) + 0.5) * ratio + offset[1] / self.raster.gsd - 0.5
        take = lambda grid: _bilinear(grid, u, v)  # noqa: E731
        y, near, far, known = take(self.y), take(self.near), take(self.far), take(self.known)
        step = far - near > _STEP
        y = np.where(step, np.where(y > 0.5 * (near + far), far, near), y)
        return np.where(known > 0.5, y, np.nan).astype(np.float32)


def measure_relief(xyz_facade: Float, spacing: float, raster: Raster, options: OrthoOptions) -> Relief | None:
    """The relief from points (n, 3) m in the facade frame; None when the points are too sparse to tell.

    `spacing` m is the cloud's on the wall. Cells are 3 cm or 1.5 spacings, whichever is larger.
    """
    size = max(CELL, _CELL_SPACINGS * spacing, raster.gsd)
    if size > _COARSEST:
        return None
    cells = Raster(
        raster.corner,
        size,
        int(np.ceil(raster.width * raster.gsd / size)) + 1,
        int(np.ceil(raster.height * raster.gsd / size)) + 1,
    )
    shape = (cells.height, cells.width)
    y = xyz_facade[:, 1]
    points = xyz_facade[(y >= -options.front) & (y <= options.back)]
    cell, inside = gridding.cell_index(cells.pixel(points), shape)
    if not inside.any():
        return None
    (low, median, high), _ = gridding.cell_quantiles(cell, points[inside, 1], shape, (0.25, 0.5, 0.75))
    median[high - low > _STEP] = np.nan
    return _regular(cells, median)


def _regular(cells: Raster, median: Array) -> Relief:
    """Median-filtered, small gaps closed, with both sides of every step."""
    smooth = gridding.nan_median(gridding.nan_median(median, 2), 1)
    smooth = np.where(_lonely(smooth), np.nan, smooth)
    known = gridding.closed(np.isfinite(smooth), np.full(smooth.shape, float(_BRIDGE)))
    full = gridding.nearest_filled(smooth)
    full = np.where(np.isfinite(full), full, 0.0)
    box = np.ones((3, 3), np.uint8)
    return Relief(cells, full, cv2.erode(full, box), cv2.dilate(full, box), known.astype(np.float64))


def _lonely(y: Array) -> Array:
    """Cells with fewer than 3 known neighbours of 8 within a step of their own depth: clutter, not a surface."""
    padded = np.pad(y, 1, constant_values=np.nan)
    h, w = y.shape
    friends = np.zeros(y.shape, np.int64)
    for i in range(3):
        for j in range(3):
            if (i, j) != (1, 1):
                with np.errstate(invalid="ignore"):
                    friends += np.abs(padded[i : i + h, j : j + w] - y) <= _STEP
    return friends < 3


def _bilinear(grid: Array, u: Float, v: Float) -> Array:
    """Grid values at the outer product of columns u (n,) and rows v (m,): (m, n), edges held."""
    h, w = grid.shape
    u, v = np.clip(u, 0, w - 1), np.clip(v, 0, h - 1)
    c, r = np.minimum(u.astype(int), max(w - 2, 0)), np.minimum(v.astype(int), max(h - 2, 0))
    c1, r1 = np.minimum(c + 1, w - 1), np.minimum(r + 1, h - 1)
    s, t = (u - c)[None], (v - r)[:, None]
    top = grid[r][:, c] * (1 - s) + grid[r][:, c1] * s
    low = grid[r1][:, c] * (1 - s) + grid[r1][:, c1] * s
    mixed: Array = top * (1 - t) + low * t
    return mixed
