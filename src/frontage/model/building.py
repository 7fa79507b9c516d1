"""A building: the points that belong to it, and what a city model knows of it."""

from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Float, Int, freeze


@dataclass(frozen=True, eq=False)
class Surface:
    """A polygon of a city model.

    ring       (k, 3) m local, outer ring, counter-clockwise as seen from outside
    semantics  semantic class, such as "WallSurface"
    source_id  id in its source
    holes      inner rings (j, 3) m local
    """

    ring: Float
    semantics: str
    source_id: str = ""
    holes: tuple[Float, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, ring=((None, 3), np.float64))


@dataclass(frozen=True, eq=False)
class Building:
    """A building of the scene.

    id          stable and readable, such as "B07"
    index       (m,) int64 into the scan: the points of the building (facade, roof, balconies)
    ground_z    m local, height of the ground at its foot
    footprint   (k, 2) m local, or None when only facades are known
    surfaces    its polygons in the city model
    cuts        where it was cut from its neighbours: ((x, y) m local, posterior probability 0..1), ...
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
    """A building on a map: id and address from its source, outer ring (k, 2) m local, not closed.

    Raises ValueError for a ring with fewer than three corners.
    """

    id: str
    ring: Float
    address: str | None = None

    def __post_init__(self) -> None:
        freeze(self, ring=((None, 2), np.float64))
        if len(self.ring) < 3:
            raise ValueError(f"footprint {self.id}: a ring needs 3 corners, got {len(self.ring)}")
