"""Places for openings, before they have names."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.simulate.elevation import Dressing, Oriel
from frontage.simulate.scene import OpeningPlan
from frontage.simulate.shapes import opening_ring
from frontage.simulate.style import WindowType

_LETTER = {"window": "W", "door": "D", "shopfront": "S", "passage": "P", "garage": "G", "basement": "B"}


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
        name = f"{facade}/{_LETTER[slot.type.kind]}{slot.floor}-{bay}"
        openings.append(slot.type.place(name, slot.x, slot.z, slot.floor, bay, slot.wall_y, slot.shutters))
    return tuple(openings), tuple(s.type.dressing for s in order)
