"""Find the street fronts, and tell which side of each is the street."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from frontage.buildings.cloud import StreetCloud
from frontage.buildings.fronts.front import StreetFront
from frontage.buildings.fronts.lines import draw_fronts
from frontage.buildings.fronts.street_side import opaque_side
from frontage.buildings.fronts.wall_map import WallMap
from frontage.geometry.arrays import Int


@dataclass(frozen=True, eq=False)
class StreetFronts:
    """All fronts of a street, turned to it; `of_cell` (m,) is the front nearest to each coarse cell."""

    fronts: tuple[StreetFront, ...]
    of_cell: Int

    def __len__(self) -> int:
        return len(self.fronts)


def find_fronts(cloud: StreetCloud, walls: WallMap) -> StreetFronts:
    """Draws fronts through the wall columns and turns each to its street."""
    found = draw_fronts(cloud, walls)
    if not found:
        return StreetFronts((), np.empty(0, np.int64))
    owner = np.full(len(walls.xy), -1, np.int64)
    for f, front in enumerate(found):
        owner[front.members] = f
    level = cloud.tree.level
    of_cell = owner[cKDTree(walls.xy).query(level.mean[:, :2])[1]]
    turned = []
    for f, front in enumerate(found):
        if front.faces_street:
            turned.append(front)
            continue
        s, d = front.coordinates(level.mean[:, :2])
        near = (of_cell == f) & (s > front.lo) & (s < front.hi) & (np.abs(d) < cloud.options.max_depth)
        s, d = np.where(near, s, np.nan), np.where(near, d, np.nan)
        turned.append(front.facing(opaque_side(cloud, walls, s, d) or 1.0))
    return StreetFronts(tuple(turned), of_cell)
