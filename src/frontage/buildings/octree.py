"""The octree of the stage: two levels of cells over the points, and their heights above ground."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from frontage.buildings.ground import Ground
from frontage.buildings.options import BuildingOptions
from frontage.buildings.voxels import Level, Shape, adjacency, leaves, parents, shape_of
from frontage.geometry.arrays import Array, Bool, Float


@dataclass(frozen=True, eq=False)
class Octree:
    """Two levels of octree cells over the points, how the coarse ones touch and what lies in them."""

    leaf: Level
    of_point: Array
    level: Level
    of_leaf: Array
    touch: sparse.csr_array
    shape: Shape


def octree(xyz: Float, cell: float) -> Octree:
    """Leaves of half a cell and cells of edge `cell` m over points (n, 3) m local."""
    leaf, of_point = leaves(xyz, cell / 2)
    level, of_leaf = parents(leaf, 1)
    touch = adjacency(level)
    return Octree(leaf, of_point, level, of_leaf, touch, shape_of(level, touch))


def cell_height(level: Level, ground: Ground | None) -> Float:
    """Height (m,) of the cells above ground, infinite where no ground was measured."""
    return np.full(len(level), np.inf) if ground is None else ground.height(level.mean)


def leaf_height(tree: Octree, ground: Ground | None) -> Float:
    """Height (m,) of the leaves above ground, infinite where no ground was measured."""
    return np.full(len(tree.leaf), np.inf) if ground is None else ground.height(tree.leaf.mean)


def ground_leaves(tree: Octree, ground: Ground | None, options: BuildingOptions) -> Bool:
    """Leaves (m,) that are ground: within the tolerance of the terrain, and not on a wall away
    from where it was measured."""
    if ground is None:
        return np.zeros(len(tree.leaf), bool)
    row, col = ground.cell_of(tree.leaf.mean[:, :2])
    upright = (np.abs(tree.shape.normal[:, 2]) < 0.5)[tree.of_leaf]
    return (np.abs(ground.height(tree.leaf.mean)) <= options.ground_tolerance) & (
        ground.beside[row, col] | ~upright
    )
