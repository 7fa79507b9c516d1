"""Surfaces and solids as files hold them: rings of coordinates, not yet checked for anything."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from frontage.geometry.arrays import Array, Float, Int, freeze

_LARGEST = 1e15  # m
ShapeKind = Literal["MultiSurface", "CompositeSurface", "Solid", "MultiSolid", "CompositeSolid"]


@dataclass(frozen=True, eq=False)
class Polygons:
    """Polygons of one shell or surface: coordinates and where rings and faces begin.

    `points` (p, 3) m, world or local; ring r is `points[rings[r]:rings[r + 1]]`, face f has the rings
    `faces[f]` to `faces[f + 1]`, its outer one first. `explicit` = every ring must repeat its first point
    at the end (GML, JSON-FG). `names` holds one name per face, or nothing.

    Raises ValueError for coordinates that are not finite or so large that doubles have no metres left.
    """

    points: Float
    rings: Int
    faces: Int
    explicit: bool = False
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, points=((None, 3), np.float64), rings=((None,), np.int64), faces=((None,), np.int64))
        if not (np.abs(self.points) < _LARGEST).all():
            raise ValueError("points: a coordinate that is not a number or beyond 1e15")

    @classmethod
    def of(
        cls, polygons: Iterable[Sequence[Array]], explicit: bool = False, names: Sequence[str] = ()
    ) -> "Polygons":
        """From polygons, each a sequence of rings (k, 3), the outer one first."""
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
        """How many faces."""
        return len(self.faces) - 1


@dataclass(frozen=True)
class Shape:
    """One geometry of a feature: its kind, its solids as shells (outer first), level of detail, name.

    A surface is one "solid" of one shell, so that every kind reads `solids[s][shell]`.
    """

    kind: ShapeKind
    solids: tuple[tuple[Polygons, ...], ...]
    lod: str = ""
    name: str = ""


@dataclass(frozen=True)
class CellGraph:
    """IndoorGML's graph by identifiers; an empty one means: refers to nothing.

    The state of each cell and the cell of each state as the file says, a state's position (m) where it has
    one, and the states that each transition connects.
    """

    state_of_cell: Mapping[str, str]
    cell_of_state: Mapping[str, str]
    position: Mapping[str, tuple[float, float, float]]
    ends: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True)
class Feature:
    """A thing with geometry: a building with its parts, a tree, an object of an OBJ file.

    With a `graph` it is an indoor model, its parts are cells.
    """

    id: str
    kind: str
    shapes: tuple[Shape, ...]
    parts: tuple["Feature", ...] = ()
    graph: CellGraph | None = None
