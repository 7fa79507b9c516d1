"""Surfaces and solids as they are stored in files: rings of coordinates that nothing has checked yet."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from frontage.geometry.arrays import Array, Float, Int, freeze

_LARGEST_M = 1e15  # beyond, float64 has no decimals left
ShapeKind = Literal["MultiSurface", "CompositeSurface", "Solid", "MultiSolid", "CompositeSolid"]


@dataclass(frozen=True, eq=False)
class Polygons:
    """The polygons of one shell or surface.

    points    (p, 3) float64 m, world or local
    rings     (r + 1,) int64: ring i is `points[rings[i]:rings[i + 1]]`
    faces     (f + 1,) int64: face i has the rings `faces[i]` to `faces[i + 1]`, its outer one first
    explicit  whether every ring must repeat its first point at its end (GML, JSON-FG)
    names     one name per face, or nothing

    Raises ValueError for coordinates that are not finite or are larger than 1e15 m.
    """

    points: Float
    rings: Int
    faces: Int
    explicit: bool = False
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, points=((None, 3), np.float64), rings=((None,), np.int64), faces=((None,), np.int64))
        if not (np.abs(self.points) < _LARGEST_M).all():
            raise ValueError("points: a coordinate is not a number or is beyond 1e15")

    @classmethod
    def of(
        cls, polygons: Iterable[Sequence[Array]], explicit: bool = False, names: Sequence[str] = ()
    ) -> "Polygons":
        """Makes it from polygons, each a sequence of rings (k, 3), the outer one first."""
        polygons = list(polygons)
        rings = [np.asarray(r, np.float64).reshape(-1, 3) for polygon in polygons for r in polygon]
        return cls(
            np.concatenate([np.zeros((0, 3)), *rings]),
            np.cumsum([0, *(len(r) for r in rings)]),
            np.cumsum([0, *(len(p) for p in polygons)]),
            explicit,
            tuple(names),
        )

    def __len__(self) -> int:
        """The number of faces."""
        return len(self.faces) - 1


@dataclass(frozen=True)
class Shape:
    """One geometry of a feature: its kind, its solids as shells (the outer first), level of detail and name.

    A surface counts as one solid of one shell, so that `solids[s][shell]` works for every kind.
    """

    kind: ShapeKind
    solids: tuple[tuple[Polygons, ...], ...]
    lod: str = ""
    name: str = ""


@dataclass(frozen=True)
class CellGraph:
    """The graph of an IndoorGML model, by identifiers; an empty identifier refers to nothing.

    state_of_cell, cell_of_state  as the file states them, each by itself
    position                      (x, y, z) m of the states that have one
    ends                          the states that each transition connects
    """

    state_of_cell: Mapping[str, str]
    cell_of_state: Mapping[str, str]
    position: Mapping[str, tuple[float, float, float]]
    ends: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True)
class Feature:
    """An object with geometry: a building with its parts, a tree, an object of an OBJ file.

    With a `graph` it is an indoor model and its parts are cells.
    """

    id: str
    kind: str
    shapes: tuple[Shape, ...]
    parts: tuple["Feature", ...] = ()
    graph: CellGraph | None = None
