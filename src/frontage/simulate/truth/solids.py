"""The true LoD3 solid of a house: its closed shell, with every opening and oriel."""

from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import at_depth
from frontage.model import Face, OpeningKind, Solid, WorldRef
from frontage.simulate.scene import FacadePlan, House, OpeningPlan, ProtrusionPlan

GRID = 10_000  # steps per metre: vertices of solids lie on a grid of 0.1 mm


def truth_solid(house: House, world: WorldRef) -> Solid:
    """Return the closed LoD3 solid of a house.

    The shell stands on the lowest pavement. Openings are recesses that end at the front of their frame in a
    "Window" or "Door" naming the opening, with "WallSurface" sides; oriels stand out. Balconies, dormers,
    bands, shutters and bars are not part of the solid.
    """
    work = _Faces()
    facades = {int(f.id.rsplit("/F", 1)[1]) - 1: f for f in house.facades}
    for side, (semantics, ring) in enumerate(house.shell):
        if side in facades:
            _draw_facade(work, ring, facades[side])
        else:
            work.add(semantics, ring)
    grid = np.array(list(work.vertices), np.int64).reshape(-1, 3)
    return Solid(house.id, grid, world.origin, tuple(work.faces), "3")


@dataclass
class _Faces:
    """Collects faces over shared vertices on the grid."""

    vertices: dict[tuple[int, int, int], int] = field(default_factory=dict)
    faces: list[Face] = field(default_factory=list)

    def add(
        self, semantics: str, ring: Float, holes: tuple[Float, ...] = (), opening: str | None = None
    ) -> None:
        """Add a face: rings (k, 3) m local, the outer one counter-clockwise as seen from outside."""
        inner = tuple(self._ids(h) for h in holes)
        self.faces.append(Face(self._ids(ring), semantics, inner, opening))

    def _ids(self, ring: Float) -> tuple[int, ...]:
        grid = np.round(ring * GRID).astype(np.int64).tolist()
        return tuple(self.vertices.setdefault((x, y, z), len(self.vertices)) for x, y, z in grid)


def _draw_facade(work: _Faces, wall: Float, facade: FacadePlan) -> None:
    frame = facade.local_from_facade
    oriels = [p for p in facade.protrusions if p.kind == "oriel"]
    main = [o for o in facade.openings if o.wall_y == 0.0]
    holes = [_at(frame, o.ring[::-1], 0.0) for o in main] + [_at(frame, p.ring[::-1], 0.0) for p in oriels]
    work.add("WallSurface", wall, tuple(holes))
    for opening in main:
        _draw_recess(work, frame, opening)
    for oriel in oriels:
        own = [o for o in facade.openings if o.wall_y == oriel.y_range[0]]
        _draw_oriel(work, frame, oriel, own)


def _draw_recess(work: _Faces, frame: Rigid3, opening: OpeningPlan) -> None:
    near = _at(frame, opening.ring, opening.wall_y)
    far = _at(frame, opening.ring, opening.wall_y + opening.depth)
    _draw_sides(work, near, far)
    work.add(OpeningKind(opening.kind).surface.semantics, far, (), opening.id)


def _draw_oriel(work: _Faces, frame: Rigid3, oriel: ProtrusionPlan, openings: list[OpeningPlan]) -> None:
    y = oriel.y_range[0]
    front = _at(frame, oriel.ring if oriel.front is None else oriel.front, y)
    _draw_sides(work, _at(frame, oriel.ring, 0.0), front)
    work.add("WallSurface", front, tuple(_at(frame, o.ring[::-1], y) for o in openings))
    for opening in openings:
        _draw_recess(work, frame, opening)


def _draw_sides(work: _Faces, start: Float, end: Float) -> None:
    """Adds quadrilaterals from one ring to another; they face inwards where `end` lies further inside."""
    for a, b, c, d in zip(start, np.roll(start, -1, 0), np.roll(end, -1, 0), end, strict=True):
        work.add("WallSurface", np.array([a, b, c, d]))


def _at(frame: Rigid3, ring: Float, y: float) -> Float:
    return frame.apply(at_depth(ring, y))
