"""Measures the relief of a facade: the depth y of its surface by cells, sharpened to pixels at steps.

A window frame 15 cm behind the wall is displaced by ``15 cm x tan(theta)`` in an ortho-image on the plane;
the relief removes this displacement. Cells hold the median depth of their points. Mixed cells (the edge of a
reveal, foliage in front of a wall) are left out. Gaps are filled by the wall, in openings by the plane of the
frame (`glazing.py`). At a step, a pixel takes
the depth of one side or the other and never a mean; the points themselves decide which (`edges.py`), so that
edges stay straight and sharp.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int, picked_rows
from frontage.model import Facade
from frontage.ortho.edges import Steps, measure_steps
from frontage.ortho.gaps import Gaps
from frontage.ortho.glazing import fill_openings
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.outline import inside_outline
from frontage.ortho.recess import DEEPEST_REVEAL_M, room_cells
from frontage.ortho.sky import above_wall
from frontage.raster import gridding, interpolation
from frontage.raster.tiles import Tile

_CELL_M = 0.03
_STEP_M = 0.03  # between neighbouring cells: a larger difference is an edge and not a slope
_CELL_SPACINGS = 1.5  # a cell holds about two points of the wall
_COARSEST_M = 0.1  # cells wider than a window frame distort what the plane would leave straight
_BEHIND_M = 0.05  # a point so far behind the farther side of its surroundings is inside the building
_BRIDGE_CELLS = 2  # gaps up to twice as wide are closed
_OPAQUE_POINTS = 2  # points that make a cell opaque: what lies behind is not the facade
_AGREEING = 3  # of the 24 neighbours must agree with a cell within a step, or it is clutter


@dataclass(frozen=True)
class ReliefMap:
    """The relief by cells of `raster`.

    y          (h, w) float32 m, depth of the cells, gaps filled
    near, far  (h, w) float32 m, smallest and largest depth around each cell: the two sides of a step
    deepest    (h, w) float32 m, the largest depth around each cell, with what was measured behind frames
    known      (h, w) float32, 1 where the depth was measured, else 0
    opening    (h, w) int32, number of the opening whose frame or glass a cell shows; 0 = wall
    above      (h, w) uint8, cells above the top of the wall, which may end below its outline (`above_wall`)
    """

    raster: OrthoRaster
    y: Array
    near: Array
    far: Array
    deepest: Array
    known: Array
    opening: Array
    above: Array
    steps: Steps

    def at(self, raster: OrthoRaster, tile: Tile) -> Array:
        """Returns the depth (m, n) float32 m at the pixels of a tile of a raster of the same facade.

        Where it was not measured it is that of the nearest surface. Glass without returns lies at the depth
        of its frame; drawn on the plane, it would show the frame a second time.
        """
        (r0, r1, c0, c1), u, v = self.raster.window_of(raster, tile)
        window = (slice(r0, r1), slice(c0, c1))
        cells, near, far = (g[window] for g in (self.y, self.near, self.far))
        y = interpolation.bilinear(cells, u, v)
        stepped = far - near > _STEP_M
        if stepped.any():
            third = (cells - near > _STEP_M) & (far - cells > _STEP_M)  # a sill before a wall before a window
            side, behind = (interpolation.nearest(np.where(third, cells, g), u, v) for g in (near, far))
            cv2.copyTo(behind, self.steps.recessed(raster, tile).view(np.uint8), side)
            cv2.copyTo(side, interpolation.nearest(stepped.view(np.uint8), u, v), y)
        return y

    def measured(self, raster: OrthoRaster, tile: Tile) -> Bool:
        """Returns at which pixels (m, n) of a tile of another raster the depth was measured."""
        (r0, r1, c0, c1), u, v = self.raster.window_of(raster, tile)
        found: Bool = interpolation.bilinear(self.known[r0:r1, c0:c1], u, v) > 0.5
        return found

    def above_wall(self, raster: OrthoRaster, tile: Tile) -> Array:
        """Returns which pixels (m, n) uint8 of a tile of another raster lie above the top of the wall."""
        (r0, r1, c0, c1), u, v = self.raster.window_of(raster, tile)
        return interpolation.nearest(self.above[r0:r1, c0:c1], u, v)

    def openings(self, raster: OrthoRaster, tile: Tile) -> Int:
        """Returns the number (m, n) of the opening at the pixels of a tile of another raster; 0 = wall."""
        (r0, r1, c0, c1), u, v = self.raster.window_of(raster, tile)
        return interpolation.nearest(self.opening[r0:r1, c0:c1], u, v)

    def in_front(self, xyz_facade: Float) -> Array:
        """Returns which points (n, 3) m of the facade frame lie on the surface or in front of it."""
        (x, y, z), (h, w) = xyz_facade.T, self.deepest.shape
        column = np.clip((x - self.raster.corner[0]) / self.raster.gsd, 0, w - 1).astype(np.int32)
        row = np.clip((self.raster.corner[1] - z) / self.raster.gsd, 0, h - 1).astype(np.int32)
        kept: Array = y <= np.take(self.deepest.ravel(), row * w + column) + _BEHIND_M
        return kept


def measure_relief(
    xyz_facade: Float, facade: Facade, raster: OrthoRaster, options: OrthoOptions, gaps: Gaps
) -> ReliefMap | None:
    """Measures the relief from points (n, 3) m in the facade frame; None when they are too sparse.

    `gaps` are the local gaps of the cloud. Cells are 3 cm, 1.5 spacings of the cloud on the wall, or a pixel
    wide, whichever is largest.
    """
    size = max(_CELL_M, _CELL_SPACINGS * facade.spacing, raster.gsd)
    if size > _COARSEST_M:
        return None
    cells = raster.of_cells(size)
    shape = (cells.height, cells.width)
    within = (xyz_facade[:, 1] >= -options.front) & (xyz_facade[:, 1] <= options.back)
    points = picked_rows(within, xyz_facade)
    cell, inside = gridding.cell_index(cells.pixel(points), shape)
    if not inside.any():
        return None
    points = picked_rows(inside, points)
    front = points[:, 1] <= DEEPEST_REVEAL_M
    many = np.bincount(np.take(cell, np.flatnonzero(front)), minlength=shape[0] * shape[1])
    opaque = many >= _OPAQUE_POINTS
    seen = front | ~np.take(opaque, cell)  # the far wall of a room, seen through a window beside, lies behind
    points, cell = picked_rows(seen, points), np.take(cell, np.flatnonzero(seen))
    (low, median, high), _ = gridding.cell_quantiles(cell, points[:, 1], shape, (0.25, 0.5, 0.75))
    median[high - low > _STEP_M] = np.nan
    median[room_cells(median, size, _STEP_M)] = np.nan
    smooth = _agreed(median.astype(np.float32))
    known = gridding.closed(np.isfinite(smooth), np.full(shape, float(_BRIDGE_CELLS)))
    inside = inside_outline(facade, cells, Tile(0, cells.height, 0, cells.width), 0.0)
    found = fill_openings(smooth, known, inside, (cell, points[:, 1]), size=size, step=_STEP_M)
    box = np.ones((5, 5), np.uint8)
    near, far = cv2.erode(found.y, box), cv2.dilate(found.y, box)
    deepest = cv2.dilate(np.fmax(found.y, smooth), box)
    steps = measure_steps((cell, points), cells, near, far, step=_STEP_M, raster=raster, gaps=gaps)
    surface = np.isfinite(smooth)
    above = above_wall(surface, surface | (many > 0).reshape(shape), inside, size)
    measured = found.known.astype(np.float32)
    return ReliefMap(cells, found.y, near, far, deepest, measured, found.opening, above, steps)


def _agreed(y: Array) -> Array:
    """Averages the cells (h, w) of a 5 x 5 window that agree with the middle one; NaN where too few do.

    A median would round the corners of openings and remove frames narrower than half of its window.
    """
    padded = cv2.copyMakeBorder(y, 2, 2, 2, 2, cv2.BORDER_CONSTANT, value=float("nan"))
    h, w = y.shape
    total, count = np.zeros_like(y), np.zeros(y.shape, np.uint8)
    for i in range(5):
        for j in range(5):
            other = padded[i : i + h, j : j + w]
            same = cv2.compare(cv2.absdiff(other, y), _STEP_M, cv2.CMP_LE)
            cv2.add(total, other, dst=total, mask=same)
            count -= same  # 255, which is -1
    with np.errstate(invalid="ignore", divide="ignore"):
        mean: Array = np.where(count > _AGREEING, total / count, np.nan).astype(np.float32)
    return mean
