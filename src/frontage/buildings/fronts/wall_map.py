"""The wall map: columns of the street's plan in which a vertical, planar surface stands.

A column counts *occupied height bins*, not points. The number of points tells how near the scanner stood; the
number of bins tells how high the wall is.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from frontage.buildings.cloud import StreetCloud
from frontage.buildings.groups import mean_of
from frontage.buildings.octree.shape import LocalShape
from frontage.geometry.arrays import Array, Bool, Float, Int, distinct
from frontage.model.masonry import MASONRY

_UPRIGHT = 0.35  # |z| of the normal below which a surface is upright: 20 degrees
_LEAST_PLANARITY = 0.35  # planarity of a wall, at least
_MOST_SCATTER = 0.12  # scatter of a wall, at most
_FEWEST_LEAVES = 5  # leaves around a cell of a wall, at least
_LEAST_FILL = 0.35  # share of a column's bins that are occupied: windows and shadows take the rest
_FEWEST_BINS = 3  # height bins of a wall column, at least
_LINK_M = 2.0  # m, wall columns closer than this belong to one block


@dataclass(frozen=True, eq=False)
class WallMap:
    """Wall columns of the street's plan.

    cells   (m,) coarse octree cells that show a wall
    xy      (k, 2) m local, columns
    bins    (k,) occupied height bins of each column
    normal  (k, 2) unit normal, of either sign
    block   (k,) number of the group of columns that each belongs to
    lintels (j, 2) m local, columns that show too little wall for a front, but some of it above an opening
    """

    cells: Bool
    xy: Float
    bins: Float
    normal: Float
    block: Int
    lintels: Float


def map_walls(cloud: StreetCloud, *, sparse: bool = False) -> WallMap:
    """Maps the columns that rise high and full enough to be a wall.

    `sparse`: columns that rise high enough need not be filled as high, as in a single storey of windows.
    """
    level, shape = cloud.tree.level, cloud.tree.shape
    cells = cloud.above_ground & wall_like(shape)
    at = np.flatnonzero(cells)
    ij, z = level.ijk[at, :2].astype(np.int64), level.ijk[at, 2].astype(np.int64)
    own, of_cell = np.unique(ij[:, 0] << 32 | ij[:, 1], return_inverse=True)
    bins, height = _occupied_bins(own, of_cell, z)
    need = max(_FEWEST_BINS, int(np.ceil(cloud.options.min_wall_height / level.size - 1e-9)))
    tall = (height >= need) & (bins >= _LEAST_FILL * height)
    count = np.bincount(of_cell, minlength=len(own)).astype(np.float64)
    xy = np.column_stack([mean_of(of_cell, level.mean[at, a], count) for a in (0, 1)])
    normal = _mean_normals(of_cell, shape.normal[at, :2], count)
    keep = tall & (sparse | (bins >= need))
    above = of_cell[cloud.cell_height[at] > MASONRY.headroom]
    high = np.bincount(above, minlength=len(own)) >= _FEWEST_BINS
    # columns with wide openings show too little wall for a front, but both sides of them are one block
    linked = tall | high
    block = _blocks(xy[linked], max(_LINK_M, 3 * level.size))[keep[linked]]
    return WallMap(cells, xy[keep], bins[keep], normal[keep], block, xy[high & ~keep])


def wall_like(shape: LocalShape) -> Bool:
    """Returns the cells (m,) whose surroundings are planar and upright."""
    upright = np.abs(shape.normal[:, 2]) < _UPRIGHT
    planar = (shape.planarity > _LEAST_PLANARITY) & (shape.scatter < _MOST_SCATTER)
    return upright & planar & (shape.support >= _FEWEST_LEAVES)


def _occupied_bins(own: Int, of_cell: Array, z: Int) -> tuple[Float, Int]:
    """Counts the occupied height bins (k,) of every column, and how many bins lie from its foot to its top.

    own      (k,) sorted keys of the columns; of_cell (m,) column of each cell; z (m,) its height bin

    A column has one vote per height bin, to which its eight neighbours contribute.
    """
    n = len(own)
    wide = np.concatenate([(own[of_cell] + (i << 32) + j) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    target = np.searchsorted(own, wide)
    target[target == n] = 0
    hit = own[target] == wide
    pair = distinct(target[hit] << 24 | np.tile(z, 9)[hit])
    column, bin_ = pair >> 24, pair & ((1 << 24) - 1)
    first = np.full(n, 1 << 24)
    last = np.zeros(n, np.int64)
    np.minimum.at(first, column, bin_)
    np.maximum.at(last, column, bin_)
    return np.bincount(column, minlength=n).astype(np.float64), last - first + 1


def _mean_normals(group: Array, normal: Float, count: Float) -> Float:
    """Mean normal (k, 2) per group; normals (m, 2) without sign are averaged as doubled angles."""
    double = 2 * np.arctan2(normal[:, 1], normal[:, 0])
    angle = 0.5 * np.arctan2(mean_of(group, np.sin(double), count), mean_of(group, np.cos(double), count))
    return np.column_stack([np.cos(angle), np.sin(angle)])


def _blocks(xy: Float, link: float) -> Int:
    """Labels (k,) the groups of columns (k, 2) m that are closer than `link` m."""
    if not len(xy):
        return np.empty(0, np.int64)
    pairs = cKDTree(xy).query_pairs(link, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(xy), len(xy)))
    return connected_components(graph, directed=False)[1].astype(np.int64)
