"""Separate trees, cars, lamps, people and wires from the buildings that they stand before.

Everything on or behind a wall belongs to the building; rooms seen through windows do no harm. Pieces before
the wall are judged one by one. A piece that is attached to the wall, off the ground and built of surfaces is
a balcony, a sign or an oriel. A piece that stands on the ground must lean on the wall for most of its height
and be built of surfaces, as stairs and porches are.
"""

import numpy as np

from frontage.buildings.cloud import StreetCloud
from frontage.buildings.octree.cells import connected_cells
from frontage.buildings.octree.shape import LocalShape
from frontage.geometry.arrays import Array, Bool, Float, Int, distinct
from frontage.model.masonry import MASONRY

_ON_WALL_M = MASONRY.relief  # m in front of the wall: still its relief
_TALL_M = 3.5  # m: an upright surface higher than any vehicle is a wall
_LEAFY = 0.5  # share of scattered cells that makes a piece foliage
_UPRIGHT = 0.35  # |z| of the normal below which a surface is upright: 20 degrees
_LEAST_PLANARITY = 0.35  # planarity of an upright surface, at least
_FOLIAGE_SCATTER = 0.1  # least scatter of foliage
_MOST_LINEARITY = 0.7  # linearity of foliage, at most; branches, poles and wires are more linear
_LEANING = 0.5  # share of its height for which a piece on the ground must lean on the wall
_MOSTLY_UPRIGHT = 0.5  # share of a piece's cells that are upright, for it to be a wall


def find_occluders(cloud: StreetCloud, front_of: Float, near: Bool, wall: Bool) -> Bool:
    """Finds the coarse cells (m,) that stand before the buildings.

    front_of  (m,) m in front of the nearest wall
    near      (m,) within reach of a building
    wall      (m,) wall cells that make up the fronts
    """
    tree, height = cloud.tree, cloud.cell_height
    core = near & ((front_of <= _ON_WALL_M) | wall)
    loose = near & ~core
    if not loose.any():
        return loose
    piece = connected_cells(tree.touch, loose)
    at = np.flatnonzero(loose)
    group, n = piece[at], int(piece.max()) + 1
    bins = tree.level.ijk[at, 2]
    contact = (tree.touch @ core.astype(np.float64)) > 0
    leaning = _occupied_bins(group, bins, contact[at], n)
    tall = _occupied_bins(group, bins, np.ones(len(at), bool), n)
    base = np.full(n, np.inf)
    np.minimum.at(base, group, height[at])
    is_attached = leaning > 0
    is_hanging = base > MASONRY.headroom
    is_leaning = leaning > _LEANING * tall
    is_surface = _share(group, _is_foliage(tree.shape)[at], n) < _LEAFY
    is_tall = tall * tree.level.size >= _TALL_M
    is_wall = is_surface & (_share(group, _is_upright(tree.shape)[at], n) > _MOSTLY_UPRIGHT) & is_tall
    belongs = is_attached & is_surface & (is_hanging | is_leaning)
    belongs |= is_wall
    if not np.isfinite(height).any():  # from a cut-out without ground, only free-standing foliage is taken
        belongs |= is_surface | is_attached
    out = np.zeros(len(tree.level), bool)
    out[at] = ~belongs[group]
    return out


def _is_upright(shape: LocalShape) -> Bool:
    """Returns the cells (m,) whose surroundings are planar and upright."""
    return (np.abs(shape.normal[:, 2]) < _UPRIGHT) & (shape.planarity > _LEAST_PLANARITY)


def _is_foliage(shape: LocalShape) -> Bool:
    """Returns the cells (m,) whose surroundings fill space instead of a surface or a line."""
    return (shape.scatter > _FOLIAGE_SCATTER) & (shape.linearity < _MOST_LINEARITY)


def _share(group: Int, flag: Bool, n: int) -> Array:
    """Returns the share (n,) of flagged cells in each group (k,)."""
    count = np.bincount(group, minlength=n)
    return np.bincount(group, weights=flag.astype(np.float64), minlength=n) / np.maximum(count, 1)


def _occupied_bins(group: Int, k: Array, keep: Bool, n: int) -> Float:
    """Counts the height bins (n,) that the kept cells of each group occupy; `k` is the bin of each cell."""
    pairs = distinct(group[keep] << 32 | k[keep].astype(np.int64))
    return np.bincount(pairs >> 32, minlength=n).astype(np.float64)
