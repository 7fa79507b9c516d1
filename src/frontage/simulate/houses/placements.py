"""Where openings are placed on a facade, before they are numbered."""

from dataclasses import dataclass, replace

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.model import OpeningKind
from frontage.simulate.houses.elevation import Dressing, Oriel
from frontage.simulate.houses.shapes import opening_ring
from frontage.simulate.houses.style import WindowType
from frontage.simulate.scene import OpeningPlan

_APART_M = 0.01  # least distance of surrounds and shutters from other openings


@dataclass(frozen=True)
class PlacedOpening:
    """An opening with its position: type, lower left corner (x, z) m of its bounding box, storey.

    wall_y     m, plane of the wall that it is cut into: 0, or negative for the front of an oriel
    shutters   "none", "open" or "closed"
    """

    type: WindowType
    x: float
    z: float
    floor: int
    wall_y: float = 0.0
    shutters: str = "none"

    @property
    def ring(self) -> Float:
        """Outline (k, 2) m."""
        t = self.type
        return opening_ring(t.shape, self.x, self.z, t.width, t.height, rise=t.rise)


def without_collisions(placements: list[PlacedOpening]) -> list[PlacedOpening]:
    """Remove surrounds and open shutters that would cover a neighbouring opening or its shutters."""
    shapes = np.array([shapely.Polygon(s.ring) for s in placements])
    leaves: list[shapely.Geometry] = []
    found = []
    for k, placement in enumerate(placements):
        others = np.delete(shapes, k)
        surround = placement.type.dressing.surround
        if surround:
            moulding = shapely.buffer(shapes[k], surround[0], join_style="mitre")
            if shapely.dwithin(others, moulding, _APART_M).any():
                dressing = replace(placement.type.dressing, surround=None)
                placement = replace(placement, type=replace(placement.type, dressing=dressing))
        if placement.shutters == "open":
            own = shapely.union_all([shapely.box(*leaf) for leaf in shutter_leaves(placement.ring)])
            if shapely.dwithin(others, own, _APART_M).any() or any(own.intersects(leaf) for leaf in leaves):
                placement = replace(placement, shutters="none")
            else:
                leaves.append(own)
        found.append(placement)
    return found


def shutter_leaves(ring: Float) -> list[tuple[float, float, float, float]]:
    """Return the two open shutters beside an opening as x0, z0, x1, z1 m; they end where an arch springs."""
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    half = (x1 - x0) / 2
    top = z1 if len(ring) == 4 else float(ring[2, 1])
    return [(x - half, z0, x, top) for x in (x0 - 0.02, x1 + 0.02 + half)]


def oriel_wall(oriel: Oriel) -> Float:
    """Return the front of an oriel (4, 2) m (x, z), into which windows may be cut."""
    x0, x1 = oriel.x0 + oriel.slant, oriel.x1 - oriel.slant
    return np.array([[x0, oriel.z0], [x1, oriel.z0], [x1, oriel.z1], [x0, oriel.z1]])


def name_openings(
    facade: str, placements: tuple[PlacedOpening, ...]
) -> tuple[tuple[OpeningPlan, ...], tuple[Dressing, ...]]:
    """Name the openings of a facade storey by storey, numbered from the left; return them with dressings."""
    order = sorted(placements, key=lambda s: (s.floor, s.x + s.type.width / 2, s.z))
    count: dict[int, int] = {}
    openings = []
    for placement in order:
        bay = count[placement.floor] = count.get(placement.floor, 0) + 1
        name = f"{facade}/{OpeningKind(placement.type.kind).letter}{placement.floor}-{bay}"
        openings.append(
            placement.type.place(
                name,
                placement.x,
                placement.z,
                floor=placement.floor,
                bay=bay,
                wall_y=placement.wall_y,
                shutters=placement.shutters,
            )
        )
    return tuple(openings), tuple(s.type.dressing for s in order)
