"""Closed triangulated surfaces: the shells of a solid, and valid solids made of them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from frontage.geometry.arrays import Array, Float, Int
from frontage.validation.geometry.mesh import Mesh
from frontage.validation.geometry.triangulate import Triangles


@dataclass(frozen=True, eq=False)
class ClosedSurface:
    """The triangles of one or several shells: `xyz` (v, 3) m, vertex ids `ids` (t, 3), `noise` in m."""

    xyz: Float
    ids: Int
    noise: float

    @property
    def corners(self) -> Float:
        """The triangles as coordinates (t, 3, 3)."""
        return self.xyz[self.ids]


@dataclass(frozen=True, eq=False)
class TriangulatedShell:
    """A shell whose faces are all valid, with their triangles."""

    mesh: Mesh
    triangles: Triangles

    @property
    def surface(self) -> ClosedSurface:
        """Its triangles as a closed surface."""
        return ClosedSurface(self.mesh.xyz, self.triangles.ids, self.mesh.noise)


@dataclass(frozen=True, eq=False)
class ValidSolid:
    """A solid without findings: its shells, the outer one first, and how findings name it."""

    shells: tuple[TriangulatedShell, ...]
    name: str

    @property
    def mesh(self) -> Mesh:
        """The mesh of its outer shell."""
        return self.shells[0].mesh

    @cached_property
    def surface(self) -> ClosedSurface:
        """The triangles of all its shells."""
        ids = np.concatenate([s.triangles.ids for s in self.shells])
        return ClosedSurface(self.mesh.xyz, ids, self.mesh.noise)

    def location(self, local: Array) -> tuple[float, float, float]:
        """Returns the world position of a local point (3,)."""
        return self.mesh.location(local)
