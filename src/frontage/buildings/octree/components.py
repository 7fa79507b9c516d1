"""Buildings as connected components of octree cells, the method of paper A, section 2.1, kept as baseline."""

import numpy as np

from frontage.buildings.octree.cells import connected_cells
from frontage.buildings.octree.tree import Octree
from frontage.geometry.arrays import Bool, Int

_LEAST_SHARE = 0.01  # share of the largest component's cells that a building has, at least
_FEWEST_CELLS = 10  # cells of a building, at least


def component_buildings(tree: Octree, above: Bool) -> Int:
    """Numbers the connected components (m,) of the cells `above` (m,) ground; each is a building.

    Components too small to be a building get -1.
    """
    label = connected_cells(tree.touch, above)
    if not above.any():
        return label
    size = np.bincount(label[above])
    keep = size >= max(_FEWEST_CELLS, _LEAST_SHARE * size.max())
    number = np.where(keep, np.cumsum(keep) - 1, -1)
    return np.where(label >= 0, number[label], -1).astype(np.int64)
