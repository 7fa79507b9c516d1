"""Find the ground: a raster opened step by step, kept only where a flat surface was measured.

It follows the Simple Morphological Filter (Pingel, Clarke and McBride 2013): an object is what an opening
with a growing window lowers by more than the ground can slope. Unlike in that filter, a cell is ground only
if its lowest surface is flat. A facade that was cut out of its street has a lowest edge but no ground, and
must not lose its foot.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage

from frontage.buildings.octree.shape import LocalShape
from frontage.buildings.octree.tree import Octree
from frontage.buildings.options import BuildingOptions
from frontage.geometry.arrays import Array, Bool, Float

_OBJECT_M = 16.0  # m, half width of the widest object that the opening removes
_MIN_AREA_M2 = 4.0  # m2, smallest patch of ground
_FEWEST_NEIGHBOURS = 3  # cells that touch a cell of the ground
_LEVEL_COS = 0.9  # |z| of the normal above which a surface is level
_MOST_SCATTER = 0.1  # scatter of a flat surface, at most
_LEAST_PLANARITY = 0.2  # planarity of a flat surface, at least


@dataclass(frozen=True, eq=False)
class Ground:
    """A terrain raster.

    z         (h, w) m local, everywhere; `measured` (h, w) where ground was measured
    corner    (x, y) m local, where cell (0, 0) starts; `cell` m
    """

    z: Float
    measured: Bool
    corner: Float
    cell: float

    @property
    def beside(self) -> Bool:
        """Cells (h, w) that were measured as ground or touch one that was."""
        return ndimage.binary_dilation(self.measured, np.ones((3, 3), bool))

    def cell_of(self, xy: Float) -> tuple[Array, Array]:
        """Returns row (n,) and column (n,) of points (n, 2) m local, clipped to the raster."""
        c = np.floor((xy - self.corner) / self.cell).astype(np.int64)
        return np.clip(c[:, 1], 0, self.z.shape[0] - 1), np.clip(c[:, 0], 0, self.z.shape[1] - 1)

    def height(self, xyz: Float) -> Float:
        """Returns the height (n,) m of points (n, 3) m local above the terrain, interpolated bilinearly."""
        at = (xyz[:, :2] - self.corner) / self.cell - 0.5
        below = ndimage.map_coordinates(self.z, [at[:, 1], at[:, 0]], order=1, mode="nearest")
        return xyz[:, 2] - below


def find_ground(tree: Octree, options: BuildingOptions) -> Ground | None:
    """Finds the terrain under the cells of an octree; None when no ground was measured.

    Isolated cells (mirror ghosts below the street) are not ground.
    """
    level = tree.level
    cell = 2 * level.size
    connected = np.diff(tree.touch.indptr) >= _FEWEST_NEIGHBOURS
    if not connected.any():
        return None
    first = level.ijk[connected, :2].min(0) >> 1  # stray points far off must not widen the raster
    h, w = ((level.ijk[connected, :2].max(0) >> 1) - first + 1)[::-1]
    corner = level.origin[:2] + first * cell
    col, row = np.clip((level.ijk[:, :2] >> 1) - first, 0, (w - 1, h - 1)).T
    low = np.full((h, w), np.inf)
    np.minimum.at(low, (row[connected], col[connected]), level.mean[connected, 2])
    if not np.isfinite(low).any():
        return None
    lowest = level.mean[:, 2] - low[row, col] < 0.5 * level.size + options.ground_tolerance
    on_floor = connected & _is_flat(tree.shape) & lowest
    seen = np.zeros((h, w), bool)
    seen[row[on_floor], col[on_floor]] = True
    seen = _without_small_patches(seen & _terrain(low, cell, options), cell)
    if not seen.any():
        return None
    surface = np.full((h, w), np.nan)
    surface[seen] = low[seen]
    top = on_floor & seen[row, col]
    np.maximum.at(surface, (row[top], col[top]), level.mean[top, 2])
    return Ground(_fill(surface, seen), seen, corner, cell)


def _is_flat(shape: LocalShape) -> Bool:
    """Returns the cells (m,) whose surroundings are a level plane."""
    level = np.abs(shape.normal[:, 2]) > _LEVEL_COS
    return level & (shape.scatter < _MOST_SCATTER) & (shape.planarity > _LEAST_PLANARITY)


def _without_small_patches(seen: Bool, cell: float) -> Bool:
    """Removes patches of ground that are smaller than 4 m2 or 8 cells of `cell` m."""
    patch, _ = ndimage.label(seen, np.ones((3, 3)))
    area = np.bincount(patch.ravel()) * cell**2
    area[0] = 0
    return seen & (area[patch] >= max(_MIN_AREA_M2, 8 * cell**2))


def _terrain(low: Float, cell: float, options: BuildingOptions) -> Bool:
    """Returns where the lowest surface `low` (h, w) m (inf = empty) is terrain and not an object on it."""
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
        if radius * cell >= _OBJECT_M or radius >= max(low.shape):
            return keep
        radius *= 2


def _fill(surface: Float, seen: Bool) -> Float:
    """Fills the terrain: measured cells keep their height, the others take that of the nearest, smoothed."""
    rows, cols = ndimage.distance_transform_edt(~seen, return_distances=False, return_indices=True)
    filled = surface[rows, cols]
    smooth = ndimage.uniform_filter(filled, 9, mode="nearest")
    return np.where(seen, filled, smooth)
