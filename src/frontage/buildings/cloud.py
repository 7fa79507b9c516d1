"""The street cloud as every step sees it: octree, ground, options and footprints."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from frontage.buildings.octree.spacing import measure_spacing
from frontage.buildings.octree.tree import Octree, build_octree
from frontage.buildings.options import BuildingOptions
from frontage.buildings.terrain import Ground, find_ground
from frontage.geometry.arrays import Bool, Float
from frontage.model import Footprint, Scan

_FINEST_CELL_M = 0.25  # m, edge of the octree cells of a dense cloud
_SPACINGS = 3.0  # edge of the cells of a sparse cloud, in spacings of its points
_UPRIGHT = 0.5  # |z| of the normal below which a leaf is upright


@dataclass(frozen=True, eq=False)
class StreetCloud:
    """A scan of a street, distributed into an octree, with the terrain below it.

    ground      the terrain, or None where no ground was measured
    spacing     m, median distance between neighbouring points
    footprints  of a map or a city model; empty where there is none
    mirrored    whether left and right are swapped in this frame
    """

    scan: Scan
    tree: Octree
    ground: Ground | None
    spacing: float
    options: BuildingOptions
    footprints: Sequence[Footprint] = ()
    mirrored: bool = False

    @cached_property
    def cell_height(self) -> Float:
        """Height (m,) in m of the coarse cells above ground, infinite where no ground was measured."""
        level = self.tree.level
        return np.full(len(level), np.inf) if self.ground is None else self.ground.height(level.mean)

    @cached_property
    def leaf_height(self) -> Float:
        """Height (m,) in m of the leaves above ground, infinite where no ground was measured."""
        leaf = self.tree.leaf
        return np.full(len(leaf), np.inf) if self.ground is None else self.ground.height(leaf.mean)

    @property
    def above_ground(self) -> Bool:
        """Coarse cells (m,) that lie above the ground's tolerance."""
        return self.cell_height > self.options.ground_tolerance

    @cached_property
    def ground_leaves(self) -> Bool:
        """Leaves (m,) that are ground.

        They lie within the tolerance of the terrain. Leaves on a wall count only beside measured ground.
        """
        if self.ground is None:
            return np.zeros(len(self.tree.leaf), bool)
        row, col = self.ground.cell_of(self.tree.leaf.mean[:, :2])
        upright = (np.abs(self.tree.shape.normal[:, 2]) < _UPRIGHT)[self.tree.of_leaf]
        level = np.abs(self.leaf_height) <= self.options.ground_tolerance
        return level & (self.ground.beside[row, col] | ~upright)


def prepare_cloud(scan: Scan, options: BuildingOptions, footprints: Sequence[Footprint]) -> StreetCloud:
    """Measures the spacing, builds the octree (paper A, section 2.1) and finds the ground.

    Raises InputError when the cloud is too wide for an octree.
    """
    spacing, coarse = measure_spacing(scan.xyz)
    tree = build_octree(scan.xyz, options.cell or max(_FINEST_CELL_M, _SPACINGS * coarse))
    return StreetCloud(scan, tree, find_ground(tree, options), spacing, options, footprints)
