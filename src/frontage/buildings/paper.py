"""The paper's own method: octree cells, connected components, each a building (paper A, section
2.1). The baseline."""

import numpy as np

from frontage.buildings.voxels import Level, components
from frontage.geometry.arrays import Bool, Int

_SHARE = 0.01  # a component with fewer cells than this share of the largest is no building


def component_buildings(level: Level, touch: object, above: Bool) -> Int:
    """Building number (m,) of every cell above ground: its connected component; -1 = too small to
    be a building."""
    label = components(touch, above)  # type: ignore[arg-type]
    if not above.any():
        return label
    size = np.bincount(label[above])
    keep = size >= max(10, _SHARE * size.max())
    number = np.where(keep, np.cumsum(keep) - 1, -1)
    return np.where(label >= 0, number[label], -1).astype(np.int64)
