"""The octree of the street: two levels of cells over the points (paper A, section 2.1)."""

from dataclasses import dataclass

from scipy import sparse

from frontage.buildings.octree.cells import OctreeLevel, adjacency, leaf_level, parent_level
from frontage.buildings.octree.shape import LocalShape, local_shape
from frontage.geometry.arrays import Array, Float


@dataclass(frozen=True, eq=False)
class Octree:
    """Two levels of octree cells over n points.

    leaf      the fine level, cells of half the edge; `of_point` (n,) leaf of every point
    level     the coarse level; `of_leaf` (m,) coarse cell of every leaf
    touch     sparse matrix of ones between coarse cells that touch
    shape     local shape of the surface around each coarse cell
    """

    leaf: OctreeLevel
    of_point: Array
    level: OctreeLevel
    of_leaf: Array
    touch: sparse.csr_array
    shape: LocalShape


def build_octree(xyz: Float, cell: float) -> Octree:
    """Distributes points (n, 3) m local into cells of edge `cell` m and leaves of half that edge.

    Raises InputError when the cloud is wider than 2 million leaves.
    """
    leaf, of_point = leaf_level(xyz, cell / 2)
    level, of_leaf = parent_level(leaf, 1)
    touch = adjacency(level)
    return Octree(leaf, of_point, level, of_leaf, touch, local_shape(level, touch))
