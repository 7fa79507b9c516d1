"""A closed solid on an integer grid."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Int, freeze


@dataclass(frozen=True)
class Face:
    """A planar face: outer ring and holes as vertex numbers, semantic class, id of its opening if any."""

    ring: tuple[int, ...]
    semantics: str
    holes: tuple[tuple[int, ...], ...] = ()
    opening: str | None = None


@dataclass(frozen=True)
class Finding:
    """One finding of the validator.

    code      val3dity's code of the error
    where     geometry, shell, face and ring
    location  (x, y, z) m in the coordinates of the input
    qie       code of the same error in the older CityGML QIE list, where it differs
    """

    code: int
    message: str
    where: str = ""
    feature: str = ""
    location: tuple[float, float, float] | None = None
    qie: int | None = None


@dataclass(frozen=True, eq=False)
class Solid:
    """A building's solid: vertices (v, 3) int64 in 0.1 mm from `origin` (3,) int64 m, world."""

    building: str
    vertices: Int
    origin: Int
    faces: tuple[Face, ...]
    lod: str
    findings: tuple[Finding, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, vertices=((None, 3), np.int64), origin=((3,), np.int64))
