"""Finds the inner corners of a facade: where its wall ends at another wall that stands before it.

The outline of a facade follows the points of its plane, and ends beside a corner, where points of both walls
lie in one cell. What is left is a strip as wide as a cell or two, which photos show, and which belongs to the
wall. Seen from the front, the other wall is a line: its points lie over one another, at all depths.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, picked_rows
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.relief import ReliefMap
from frontage.raster import gridding
from frontage.raster.tiles import Tile

_BEFORE_M = (0.05, 0.3)  # the plane: points of the other wall that tell where the corner is
_LAYERS = 2  # of that range, both of which the other wall fills; a pipe or a ledge fills one
_AROUND_M = 0.25  # height in which they are filled
_TALL_M = 2.0  # height of a wall; what is lower is a balcony, a box or a car
_REACH_CELLS = 3  # between the measured wall and the other one, at most
_SHARE = 0.5  # of the height of the other wall beside which this one was measured


@dataclass(frozen=True)
class Corner:
    """The end of a wall, in the facade frame.

    x            m, where it ends
    bottom, top  m, heights between which it does
    wall         on which side of x the wall lies: 1 = right, -1 = left
    reach        m from there, beyond which the wall was measured
    """

    x: float
    bottom: float
    top: float
    wall: int
    reach: float

    def beside(self, raster: OrthoRaster, tile: Tile) -> Bool:
        """Returns which pixels (m, n) of a tile are on the side of the wall, within `reach` of the corner."""
        x = raster.corner[0] + (np.arange(tile.c0, tile.c1) + 0.5) * raster.gsd
        z = raster.corner[1] - (np.arange(tile.r0, tile.r1) + 0.5) * raster.gsd
        inward = (x - self.x) * self.wall
        rows, columns = (z > self.bottom) & (z < self.top), (inward > 0.0) & (inward < self.reach)
        return np.asarray(rows[:, None] & columns)


def find_corners(xyz_facade: Array, relief: ReliefMap | None) -> tuple[Corner, ...]:
    """Finds the inner corners of a facade among all points (n, 3) m of its scan in the facade frame.

    There are none without a relief.
    """
    if relief is None:
        return ()
    size, (left, top) = relief.raster.gsd, relief.raster.corner
    around = 2 * _REACH_CELLS  # the other wall may lie beyond the picture
    known = np.pad(relief.known > 0.5, around)
    cells = OrthoRaster((left - around * size, top + around * size), size, *known.shape[::-1])
    y = xyz_facade[:, 1]
    ahead = picked_rows((y < -_BEFORE_M[0]) & (y > -_BEFORE_M[1]), xyz_facade)
    upright = _upright(ahead, cells)
    if not upright.any():
        return ()
    count, _, boxes, _ = cv2.connectedComponentsWithStats(upright, connectivity=8)
    found = (_corner(boxes[number], known & (upright == 0), ahead, cells) for number in range(1, count))
    return tuple(corner for corner in found if corner is not None)


def _upright(ahead: Array, cells: OrthoRaster) -> Array:
    """The cells (h, w) uint8 of tall walls: in or beside each, points (n, 3) m lie in both layers."""
    shape = (cells.height, cells.width)
    cell, inside = gridding.cell_index(cells.pixel(ahead), shape)
    share = (-ahead[inside, 1] - _BEFORE_M[0]) / (_BEFORE_M[1] - _BEFORE_M[0])
    filled = np.zeros((shape[0] * shape[1], _LAYERS), np.uint8)
    filled[cell, np.minimum((share * _LAYERS).astype(np.int64), _LAYERS - 1)] = 1
    # Walls stand between cells, too, and their points may be sparse.
    around = np.ones((round(_AROUND_M / cells.gsd) | 1, 3), np.uint8)
    near = cv2.dilate(filled.reshape(*shape, _LAYERS), around)
    upright = np.ascontiguousarray(near[..., 0] & near[..., 1])
    tall = np.ones((max(1, round(_TALL_M / cells.gsd)), 1), np.uint8)
    return np.asarray(cv2.morphologyEx(upright, cv2.MORPH_OPEN, tall))


def _corner(box: Array, known: Bool, ahead: Float, cells: OrthoRaster) -> Corner | None:
    """The corner at the other wall, whose cells fill a box of the raster.

    None where the facade was measured on both sides of that wall, or on neither.
    """
    left, top, width, height = box[:4].tolist()
    rows = known[top : top + height]
    sides = rows[:, max(left - _REACH_CELLS, 0) : left], rows[:, left + width :][:, :_REACH_CELLS]
    before, after = (side.any(1) for side in sides)
    if (before.mean() > _SHARE) == (after.mean() > _SHARE):
        return None
    wall, beside = (1, after) if after.mean() > _SHARE else (-1, before)
    first, last = np.flatnonzero(beside)[[0, -1]].tolist()  # the other wall may be higher than this one
    x0, z1 = cells.corner[0] + left * cells.gsd, cells.corner[1] - (top + first) * cells.gsd
    x1, z0 = x0 + width * cells.gsd, z1 - (last + 1 - first) * cells.gsd
    x, _, z = ahead.T
    own = x[(x >= x0) & (x <= x1) & (z >= z0) & (z <= z1)]
    return Corner(float(np.median(own)), z0, z1, wall, (_REACH_CELLS + width) * cells.gsd)
