"""One building: which points are its own, and what a city model knows of it."""

from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Float, Int, freeze


@dataclass(frozen=True, eq=False)
class Surface:
    """A host polygon of a city model: outer ring (k, 3) m local, semantic class, id in its source."""

    ring: Float
    semantics: str
    source_id: str = ""
    holes: tuple[Float, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, ring=((None, 3), np.float64))


@dataclass(frozen=True, eq=False)
class Building:
    """A building of the scene.

    id          stable and readable, "B07"
    index       (m,) int64 into the scan: the building's own points (facade, roof, balconies)
    ground_z    m, height of the ground at its foot, local
    footprint   (k, 2) m local, or None when only facades were seen
    surfaces    host surfaces of a city model
    cuts        where the building was cut from its neighbours: ((x, y) m local, posterior 0..1), ...
    """

    id: str
    index: Int
    ground_z: float
    address: str | None = None
    footprint: Float | None = None
    surfaces: tuple[Surface, ...] = ()
    cuts: tuple[tuple[tuple[float, float], float], ...] = ()
    notes: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        freeze(self, index=((None,), np.int64))
        freeze(self, footprint=((None, 2), np.float64))


@dataclass(frozen=True, eq=False)
class Footprint:
    """A building on a map: id and address of its source, outer ring (k, 2) m local, not closed."""

    id: str
    ring: Float
    address: str | None = None

    def __post_init__(self) -> None:
        freeze(self, ring=((None, 2), np.float64))
        if len(self.ring) < 3:
            raise ValueError(f"footprint {self.id}: a ring needs 3 corners, got {len(self.ring)}")
