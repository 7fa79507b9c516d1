"""The relief of a facade: depth y of its surface, cell by cell, and sharpened to pixels.

A window frame 15 cm behind the wall is displaced by ``15 cm x tan(theta)`` in an ortho-image on the plane;
the relief removes that. Cells hold the median depth of their points; mixed cells (a reveal's edge, foliage in
front of a wall) are left out and taken from their neighbours. Openings without returns lie at the depth that
most of the recessed points around them have: their frame. At a step the pixel takes one side or the other,
never a mean, and which one the points themselves say (`edges.py`), so that edges stay straight and sharp.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.ortho.edges import Steps, measure_steps
from frontage.ortho.gaps import Gaps
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.recess import DEEPEST_REVEAL, framed, rooms
from frontage.raster import gridding
from frontage.raster.tiles import Tile

CELL = 0.03  # m
STEP = 0.03  # m between neighbouring cells that is an edge and not a slope
_CELL_SPACINGS = 1.5  # a cell holds about two points of the wall
_COARSEST = 0.1  # m: wider than a window frame, cells tear and bend what the plane leaves straight
_BEHIND = 0.05  # m behind the farther side of its neighbourhood: a point inside the building
_BRIDGE = 2  # cells: gaps up to twice as wide are closed
_OPAQUE = 2  # points of a cell that are a wall, behind which nothing is the facade
_FRIENDS = 3  # of the 24 neighbours that must agree with a cell within a step, or it is clutter


@dataclass(frozen=True)
class ReliefMap:
    """Depth y (h, w) float32 m by cell of `raster`, gaps filled; both sides of steps; 1 where measured."""

    raster: OrthoRaster
    y: Array
    near: Array
    far: Array
    known: Array
    steps: Steps

    def at(self, raster: OrthoRaster, tile: Tile, filled: bool = False) -> Array:
        """Depth (rows, columns) float32 m of the pixels of a tile of a raster of the same facade.

        Where it was not measured it is NaN, or if `filled` that of the nearest surface: glass without
        returns lies where its frame does, and drawing it on the plane would repeat the frame in it.
        """
        (r0, r1, c0, c1), u, v = self.raster.window_of(raster, tile)
        window = (slice(r0, r1), slice(c0, c1))
        cells, near, far, known = (g[window] for g in (self.y, self.near, self.far, self.known))
        y = gridding.bilinear(cells, u, v)
        if (far - near).max() > STEP:
            near, far, own = (gridding.nearest(g, u, v) for g in (near, far, cells))
            third = (own - near > STEP) & (far - own > STEP)  # a sill before a wall before a window
            side = np.where(third, own, np.where(self.steps.recessed(raster, tile), far, near))
            y = np.where(far - near > STEP, side, y)
        if not filled and not known.all():
            y[gridding.bilinear(known, u, v) <= 0.5] = np.nan
        return y

    def in_front(self, xyz_facade: Float) -> Array:
        """Which points (n, 3) m in the facade frame are on the surface, or before it, and not behind."""
        c, r = np.floor(self.raster.pixel(xyz_facade)).astype(np.int64).T
        h, w = self.far.shape
        behind = xyz_facade[:, 1] > self.far[np.clip(r, 0, h - 1), np.clip(c, 0, w - 1)] + _BEHIND
        kept: Array = ~behind
        return kept


def measure_relief(
    xyz_facade: Float, spacing: float, raster: OrthoRaster, options: OrthoOptions, gaps: Gaps
) -> ReliefMap | None:
    """The relief from points (n, 3) m in the facade frame; None when the points are too sparse to tell.

    `spacing` m is the cloud's on the wall, `gaps` its local gaps. Cells are 3 cm or 1.5 spacings, whichever
    is larger.
    """
    size = max(CELL, _CELL_SPACINGS * spacing, raster.gsd)
    if size > _COARSEST:
        return None
    cells = raster.of_cells(size)
    shape = (cells.height, cells.width)
    y = xyz_facade[:, 1]
    points = xyz_facade[(y >= -options.front) & (y <= options.back)]
    cell, inside = gridding.cell_index(cells.pixel(points), shape)
    if not inside.any():
        return None
    points = points[inside]
    front = points[:, 1] <= DEEPEST_REVEAL
    opaque = np.bincount(cell[front], minlength=shape[0] * shape[1]) >= _OPAQUE
    seen = front | ~opaque[cell]  # a room's far wall, seen through the window beside, is behind this one
    points, cell = points[seen], cell[seen]
    (low, median, high), _ = gridding.cell_quantiles(cell, points[:, 1], shape, (0.25, 0.5, 0.75))
    median[high - low > STEP] = np.nan
    median[rooms(median, size, STEP)] = np.nan
    smooth = _agreed(median.astype(np.float32))
    known = gridding.closed(np.isfinite(smooth), np.full(shape, float(_BRIDGE)))
    full = framed(smooth, known, cell, points[:, 1], size, STEP)
    box = np.ones((5, 5), np.uint8)
    near, far = cv2.erode(full, box), cv2.dilate(full, box)
    steps = measure_steps(points, cells, near, far, STEP, raster, gaps)
    return ReliefMap(cells, full, near, far, known.astype(np.float32), steps)


def _agreed(y: Array) -> Array:
    """Mean of the cells (h, w) of a 5 x 5 window that agree with the middle one; NaN where too few do.

    A median would round the corners of openings and swallow frames narrower than half its window.
    """
    padded = np.pad(y, 2, constant_values=np.nan)
    h, w = y.shape
    total, count = np.zeros_like(y), np.zeros(y.shape, np.int32)
    for i in range(5):
        for j in range(5):
            other = padded[i : i + h, j : j + w]
            with np.errstate(invalid="ignore"):
                same = np.abs(other - y) <= STEP
            total += np.where(same, other, 0.0)
            count += same
    with np.errstate(invalid="ignore", divide="ignore"):
        mean: Array = np.where(count > _FRIENDS, total / count, np.nan).astype(np.float32)
    return mean
