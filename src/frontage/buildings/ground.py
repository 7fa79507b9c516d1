"""The ground: a raster opened step by step, kept only where something flat was really measured.

After the Simple Morphological Filter (Pingel, Clarke & McBride 2013): what an opening with a
growing window lowers
by more than the ground can slope is an object. Unlike it, a cell is ground only if its lowest
surface lies flat:
a facade cut out of its street has a lowest edge, but no ground, and must not lose its foot.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage

from frontage.buildings.options import BuildingOptions
from frontage.buildings.voxels import Level, Shape
from frontage.geometry.arrays import Array, Bool, Float

_OBJECT = 16.0  # m, half width of the widest object that the opening removes
_MIN_AREA = 4.0  # m2, smallest patch called ground


@dataclass(frozen=True, eq=False)
class Ground:
    """A terrain raster: `z` (h, w) m local, `measured` (h, w) bool; cell (0, 0) starts at `corner`
    (x, y) m local."""

    z: Float
    measured: Bool
    corner: Float
    cell: float

    @property
    def beside(self) -> Bool:
        """Cells (h, w) that were measured as ground or touch one that was."""
        return ndimage.binary_dilation(self.measured, np.ones((3, 3), bool))

    def cell_of(self, xy: Float) -> tuple[Array, Array]:
        """Row and column (n,) of points (n, 2) m, clipped to the raster."""
        c = np.floor((xy - self.corner) / self.cell).astype(np.int64)
        return np.clip(c[:, 1], 0, self.z.shape[0] - 1), np.clip(c[:, 0], 0, self.z.shape[1] - 1)

    def height(self, xyz: Float) -> Float:
        """Height (n,) m of points (n, 3) above the terrain, bilinear."""
        at = (xyz[:, :2] - self.corner) / self.cell - 0.5
        below = ndimage.map_coordinates(self.z, [at[:, 1], at[:, 0]], order=1, mode="nearest")
        return xyz[:, 2] - below


def find_ground(level: Level, shape: Shape, touching: Array, options: BuildingOptions) -> Ground | None:
    """The terrain under a level of cells, or None when no ground was measured.

    `touching` (m,) is the number of neighbours of each cell: lonely ones (mirror ghosts below the
    street) are no ground.
    """
    cell = 2 * level.size
    solid = touching >= 3
    if not solid.any():
        return None
    first = level.ijk[solid, :2].min(0) >> 1  # stray points far off must not widen the raster
    h, w = ((level.ijk[solid, :2].max(0) >> 1) - first + 1)[::-1]
    corner = level.origin[:2] + first * cell
    col, row = np.clip((level.ijk[:, :2] >> 1) - first, 0, (w - 1, h - 1)).T
    low = np.full((h, w), np.inf)
    np.minimum.at(low, (row[solid], col[solid]), level.mean[solid, 2])
    if not np.isfinite(low).any():
        return None
    flat = solid & (np.abs(shape.normal[:, 2]) > 0.9) & (shape.scatter < 0.1) & (shape.planarity > 0.2)
    lies = level.mean[:, 2] - low[row, col] < 0.5 * level.size + options.ground_tolerance
    seen = np.zeros((h, w), bool)
    seen[row[flat & lies], col[flat & lies]] = True
    seen &= _terrain(low, cell, options)
    patch, _ = ndimage.label(seen, np.ones((3, 3)))
    area = np.bincount(patch.ravel()) * cell**2
    area[0] = 0
    seen &= area[patch] >= max(_MIN_AREA, 8 * cell**2)
    if not seen.any():
        return None
    surface = np.full((h, w), np.nan)
    surface[seen] = low[seen]
    top = flat & lies & seen[row, col]
    np.maximum.at(surface, (row[top], col[top]), level.mean[top, 2])
    return Ground(_fill(surface, seen), seen, corner, cell)


def _terrain(low: Float, cell: float, options: BuildingOptions) -> Bool:
    """Where the lowest surface `low` (h, w) m (inf = empty) belongs to the terrain and not to an
    object on it."""
    known = np.isfinite(low)
    rows, cols = ndimage.distance_transform_edt(~known, return_distances=False, return_indices=True)
    base = float(low[known].min())
    surface = (low[rows, cols] - base).astype(np.float32)
    keep = known.copy()
    radius = 1
    while True:
        kernel = np.ones((2 * radius + 1, 2 * radius + 1), np.uint8)
        opened = cv2.morphologyEx(surface, cv2.MORPH_OPEN, kernel, borderType=cv2.BORDER_REPLICATE)
        keep &= surface - opened <= options.ground_tolerance + options.ground_slope * radius * cell
        surface = opened
        if radius * cell >= _OBJECT or radius >= max(low.shape):
            return keep
        radius *= 2


def _fill(surface: Float, seen: Bool) -> Float:
    """Terrain everywhere: measured cells as they are, the rest from the nearest ones, smoothed."""
    rows, cols = ndimage.distance_transform_edt(~seen, return_distances=False, return_indices=True)
    filled = surface[rows, cols]
    smooth = ndimage.uniform_filter(filled, 9, mode="nearest")
    return np.where(seen, filled, smooth)
