"""A closed solid on an integer grid."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Int, freeze


@dataclass(frozen=True)
class Face:
    """A planar face: outer ring and holes as vertex ids, semantic class, opening id if it has one."""

    ring: tuple[int, ...]
    semantics: str
    holes: tuple[tuple[int, ...], ...] = ()
    opening: str | None = None


@dataclass(frozen=True)
class Finding:
    """One finding of the validator.

    `code` is val3dity's, `qie` the same thing's code in the older CityGML QIE list where that differs;
    `where` names geometry, shell, face and ring; `location` is (x, y, z) m in the input's coordinates.
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
