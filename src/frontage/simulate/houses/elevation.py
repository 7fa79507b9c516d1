"""An elevation: everything on one facade of a house, before it becomes triangles."""

from dataclasses import dataclass, field

import numpy as np
import shapely

from frontage.errors import OptionError
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.simulate.scene import OpeningPlan, Part

CLEARANCE_M = 0.05  # least distance of openings from each other and from the wall's border


@dataclass(frozen=True)
class Dressing:
    """What surrounds and fills an opening.

    sill       height and projection m; None = no sill
    surround   width and projection m of the moulding around the opening; None = none
    curtain    "none", "sides", "net", "blind", "cafe" (the lower part) or "venetian" (slats from above),
               covering `share` of the window
    things     what stands behind the pane on the sill: x (share of the width), width, height (m), material
    joinery    whether the frame holds casements or sashes with stiles of their own, and every pane is a sheet
    leaf       pattern of an opaque leaf: "panels", "boards" or "ribs"
    flare      m, by which the inner reveal widens towards the room (behind an oriel's windows)
    """

    sill: tuple[float, float] | None = None
    surround: tuple[float, float] | None = None
    curtain: str = "none"
    share: float = 0.0
    things: tuple[tuple[float, float, float, str], ...] = ()
    joinery: bool = False
    leaf: str = "panels"
    flare: float = 0.0


@dataclass(frozen=True)
class Band:
    """A flat block on the wall, from y0 to y1 m: a plinth, a string course, a cornice or a pilaster."""

    name: str
    part: Part
    polygon: shapely.Polygon
    y0: float
    y1: float = 0.0


@dataclass(frozen=True)
class Balcony:
    """A slab with a railing: from x0 to x1 m, `projection` m deep, its upper face at z m."""

    x0: float
    x1: float
    z: float
    projection: float
    thickness: float = 0.16
    height: float = 1.0
    style: str = "bars"  # of the railing: "bars", "solid"


@dataclass(frozen=True)
class Oriel:
    """A closed bay in front of the wall, x0 to x1 and z0 to z1 m, whose front is `slant` m narrower per side.

    projection   m, from the wall to the front
    """

    x0: float
    x1: float
    z0: float
    z1: float
    projection: float
    slant: float = 0.0

    @property
    def ring(self) -> Float:
        """Outline (4, 2) m on the main plane."""
        return np.array([[self.x0, self.z0], [self.x1, self.z0], [self.x1, self.z1], [self.x0, self.z1]])


@dataclass(frozen=True, eq=False)
class Elevation:
    """One facade of a house: its pose in the house's frame, its outline (k, 2) m (x, z), and what is on it.

    dressings   of the openings, in the same order
    """

    id: str
    house_from_facade: Rigid3
    outline: Float
    openings: tuple[OpeningPlan, ...] = ()
    dressings: tuple[Dressing, ...] = ()
    bands: tuple[Band, ...] = ()
    balconies: tuple[Balcony, ...] = ()
    oriels: tuple[Oriel, ...] = field(default=())

    @property
    def side(self) -> int:
        """Side of the house: 0 front, 1 right, 2 back, 3 left."""
        return int(self.id.rsplit("/F", 1)[1]) - 1


def placement_problems(rings: list[Float], walls: list[Float]) -> list[str]:
    """Check openings against their walls and against each other.

    `rings` are their outlines (k, 2) and `walls` the outlines of the walls they are cut into. Returns one
    text per opening, empty where nothing is wrong; of two that overlap, the later one is at fault.
    """
    if not rings:
        return []
    shapes = np.array([shapely.Polygon(r) for r in rings])
    grown = shapely.buffer(shapes, CLEARANCE_M, join_style="mitre")
    near: dict[int, list[int]] = {}
    for k, j in shapely.STRtree(shapes).query(grown, predicate="intersects").T.tolist():
        near.setdefault(k, []).append(j)
    problems: list[str] = []
    for k, wall in enumerate(walls):
        hit = [j for j in sorted(near[k]) if j < k and not problems[j]]
        if not shapely.Polygon(wall).contains(grown[k]):
            problems.append(
                f"reaches beyond the wall ({_extent(wall)}; keep {CLEARANCE_M:g} m from its border)"
            )
        elif hit:
            problems.append(f"overlaps or touches opening {hit[0] + 1}")
        else:
            problems.append("")
    return problems


def check_placements(rings: list[Float], wall: Float, name: str) -> None:
    """Raise OptionError for the first opening that leaves the wall or overlaps another one."""
    for k, problem in enumerate(placement_problems(rings, [wall] * len(rings))):
        if problem:
            raise OptionError(f"{name}: opening {k + 1} {problem}; move it or make it smaller")


def _extent(wall: Float) -> str:
    (x0, z0), (x1, z1) = wall.min(0), wall.max(0)
    return f"x {x0:.2f} to {x1:.2f} m, z {z0:.2f} to {z1:.2f} m"
