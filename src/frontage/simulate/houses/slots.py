"""Places for openings, before they have names."""

from dataclasses import dataclass, replace

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.model import OpeningKind
from frontage.simulate.houses.elevation import Dressing, Oriel
from frontage.simulate.houses.shapes import opening_ring
from frontage.simulate.houses.style import WindowType
from frontage.simulate.scene import OpeningPlan

_APART = 0.01  # m, least distance of surrounds and shutters from other openings


@dataclass(frozen=True)
class Slot:
    """An opening to be: its type, the lower left corner of its bounding box (m), storey, wall, shutters."""

    type: WindowType
    x: float
    z: float
    floor: int
    wall_y: float = 0.0
    shutters: str = "none"

    @property
    def ring(self) -> Float:
        """Its outline (k, 2) m."""
        t = self.type
        return opening_ring(t.shape, self.x, self.z, t.width, t.height, t.rise)


def undisturbed(slots: list[Slot]) -> list[Slot]:
    """The slots without those surrounds and open shutters that would cover a neighbour, or its shutters."""
    shapes = np.array([shapely.Polygon(s.ring) for s in slots])
    leaves: list[shapely.Geometry] = []
    found = []
    for k, slot in enumerate(slots):
        others = np.delete(shapes, k)
        surround = slot.type.dressing.surround
        if surround:
            moulding = shapely.buffer(shapes[k], surround[0], join_style="mitre")
            if shapely.dwithin(others, moulding, _APART).any():
                dressing = replace(slot.type.dressing, surround=None)
                slot = replace(slot, type=replace(slot.type, dressing=dressing))
        if slot.shutters == "open":
            own = shapely.union_all([shapely.box(*leaf) for leaf in shutter_leaves(slot.ring)])
            if shapely.dwithin(others, own, _APART).any() or any(own.intersects(leaf) for leaf in leaves):
                slot = replace(slot, shutters="none")
            else:
                leaves.append(own)
        found.append(slot)
    return found


def shutter_leaves(ring: Float) -> list[tuple[float, float, float, float]]:
    """The two open shutters beside an opening: x0, z0, x1, z1 m; they reach to where an arch springs."""
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    half = (x1 - x0) / 2
    top = z1 if len(ring) == 4 else float(ring[2, 1])
    return [(x - half, z0, x, top) for x in (x0 - 0.02, x1 + 0.02 + half)]


def oriel_wall(oriel: Oriel) -> Float:
    """The front of an oriel (4, 2) m (x, z), which windows may be cut into."""
    x0, x1 = oriel.x0 + oriel.slant, oriel.x1 - oriel.slant
    return np.array([[x0, oriel.z0], [x1, oriel.z0], [x1, oriel.z1], [x0, oriel.z1]])


def name_openings(
    facade: str, slots: tuple[Slot, ...]
) -> tuple[tuple[OpeningPlan, ...], tuple[Dressing, ...]]:
    """Openings in reading order, numbered from the left on every storey, and how each is dressed."""
    order = sorted(slots, key=lambda s: (s.floor, s.x + s.type.width / 2, s.z))
    count: dict[int, int] = {}
    openings = []
    for slot in order:
        bay = count[slot.floor] = count.get(slot.floor, 0) + 1
        name = f"{facade}/{OpeningKind(slot.type.kind).letter}{slot.floor}-{bay}"
        openings.append(slot.type.place(name, slot.x, slot.z, slot.floor, bay, slot.wall_y, slot.shutters))
    return tuple(openings), tuple(s.type.dressing for s in order)
