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
_BEHIND = 0.05  # m behind the farther side of its neighbourhood: a point inside the building
_BRIDGE = 2  # cells: gaps up to twice as wide are closed
_REVEAL = 0.35  # m: frames and glass lie no deeper behind a wall; what does is a passage or a room
_PASSAGE = (
    1.2  # m: a measured surface deeper than a reveal is a part of the facade when it is as wide as this
)


@dataclass(frozen=True)
class Relief:
    """Depth y (h, w) float64 m by cell of `raster`, gaps filled; both sides of steps; 1 where measured."""

    raster: Raster
    y: Array
    near: Array
    far: Array
    known: Array

    def at(self, raster: Raster, tile: Tile, filled: bool = False) -> Array:
        """Depth (rows, columns) float32 m of the pixels of a tile of a raster of the same facade.

        Where it was not measured it is NaN, or if `filled` that of the nearest surface: glass without
        returns lies where its frame does, and drawing it on the plane would repeat the frame in it.
        """
        ratio = raster.gsd / self.raster.gsd
        offset = (raster.corner[0] - self.raster.corner[0], self.raster.corner[1] - raster.corner[1])
        u = (np.arange(tile.c0, tile.c1) + 0.5) * ratio + offset[0] / self.raster.gsd - 0.5
        v = (np.arange(tile.r0, tile.r1) + 0.5) * ratio + offset[1] / self.raster.gsd - 0.5
        y, near, far, known = (_bilinear(grid, u, v) for grid in (self.y, self.near, self.far, self.known))
        step = far - near > _STEP
        y = np.where(step, np.where(y > 0.5 * (near + far), far, near), y)
        return np.where((known > 0.5) | filled, y, np.nan).astype(np.float32)

    def in_front(self, xyz_facade: Float) -> Array:
        """Which points (n, 3) m in the facade frame are on the surface, or before it, and not behind."""
        c, r = np.floor(self.raster.pixel(xyz_facade)).astype(np.int64).T
        h, w = self.far.shape
        behind = xyz_facade[:, 1] > self.far[np.clip(r, 0, h - 1), np.clip(c, 0, w - 1)] + _BEHIND
        kept: Array = ~behind
        return kept


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
    median[_rooms(median, size)] = np.nan
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


def _rooms(y: Array, size: float) -> Array:
    """Cells (h, w) deeper than a reveal that do not make up a wide surface: interiors seen through glass."""
    with np.errstate(invalid="ignore"):
        deep = y > _REVEAL
    if not deep.any():
        return deep
    whole = gridding.closed(deep, np.full(y.shape, float(_BRIDGE)))
    radius = np.full(y.shape, 0.5 * _PASSAGE / size)
    wide = ~gridding.closed(~whole, radius)  # opening = closing of the background
    near_wide = gridding.distance_to(wide) <= _BRIDGE + 1
    return deep & ~near_wide


def _lonely(y: Array) -> Array:
    """Cells with fewer than 3 of 8 neighbours within a step of their own depth: clutter, not a surface."""
    padded = np.pad(y, 1, constant_values=np.nan)
    h, w = y.shape
    friends = np.zeros(y.shape, np.int64)
    for i in range(3):
        for j in range(3):
            if (i, j) != (1, 1):
                with np.errstate(invalid="ignore"):
                    friends += np.abs(padded[i : i + h, j : j + w] - y) <= _STEP
    return friends < 3


def _bilinear(grid: Array, u: Array, v: Array) -> Array:
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
