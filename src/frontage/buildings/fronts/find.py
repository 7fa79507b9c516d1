"""Find the street fronts, and tell which side of each is the street."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from frontage.buildings.cloud import StreetCloud
from frontage.buildings.fronts.lines import StreetFront, draw_fronts
from frontage.buildings.fronts.street_side import face_street
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
        s, d = front.coordinates(level.mean[:, :2])
        near = (of_cell == f) & (s > front.lo) & (s < front.hi) & (np.abs(d) < cloud.options.max_depth)
        s, d = np.where(near, s, np.nan), np.where(near, d, np.nan)
        turned.append(face_street(front, cloud, walls, s, d))
    return StreetFronts(tuple(turned), of_cell)
