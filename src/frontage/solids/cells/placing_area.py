"""The part of a wall that reliefs may be placed on."""

from dataclasses import dataclass

import shapely
from shapely.geometry import LineString
from shapely.geometry.base import BaseGeometry
from shapely.ops import substring

from frontage.model import Solid
from frontage.solids.brep import rings_of
from frontage.solids.walls import HostWall

SAME = 2.0  # 0.1 mm: lines this close coincide but for rounding
_TRIM = 4.0  # 0.1 mm that a line of the ground ends before a vertex that other faces use
_SEAM = 1.0  # 0.1 mm: a boundary closer than this to the border of the whole wall is no seam


@dataclass(frozen=True, eq=False)
class PlacingArea:
    """Where reliefs may be placed, in 0.1 mm (x, z) of the wall.

    region  the wall, or the surface of a relief
    ground  the lines that reliefs may be cut down to
    seams   the lines between the wall's own polygons, which reliefs may cross
    """

    region: BaseGeometry
    ground: BaseGeometry
    seams: tuple[LineString, ...] = ()

    @classmethod
    def of(cls, solid: Solid, wall: HostWall) -> "PlacingArea":
        """Returns the area of a wall."""
        region = wall_region(wall)
        seams = [p.boundary.difference(region.boundary.buffer(_SEAM)) for p in wall.polygons[1:]]
        parts = [g for s in seams for g in shapely.get_parts(s) if isinstance(g, LineString)]
        return cls(region, _ground_lines(solid, wall), tuple(parts))

    def room(self, gap: float) -> BaseGeometry:
        """Returns the region without a strip `gap` (0.1 mm) wide along its border, except on the ground."""
        border = self.region.boundary.difference(self.ground.buffer(SAME))
        strip = border.buffer(gap, cap_style="square", join_style="mitre")
        return shapely.set_precision(self.region.difference(strip), 1.0)


def wall_region(wall: HostWall) -> BaseGeometry:
    """Returns the union of a wall's polygons in 0.1 mm (x, z)."""
    return shapely.union_all(list(wall.polygons), grid_size=1.0)


def _ground_lines(solid: Solid, wall: HostWall) -> BaseGeometry:
    """Returns the wall's lines on the ground; they end before vertices that further faces use."""
    place_of = {i: n for n, i in wall.nodes.items()}
    users: dict[int, set[int]] = {}
    for k, face in enumerate(solid.faces):
        for ring in rings_of(face):
            for i in ring:
                users.setdefault(i, set()).add(k)
    on_other_border = {i for e in wall.border if e not in wall.ground for i in e}
    lines = []
    for edge, ground in wall.ground.items():
        line = LineString([place_of[edge[0]], place_of[edge[1]]])
        trims = [
            _TRIM if i not in on_other_border and users[i] - {ground, *wall.faces} else 0.0 for i in edge
        ]
        if line.length > 2 * _TRIM:
            lines.append(substring(line, trims[0], line.length - trims[1]))
    return shapely.union_all(lines)
