"""The walls of a coarse solid that a facade was measured on: coplanar faces with a common frame."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from shapely.geometry import Polygon

from frontage.geometry.arrays import Array, Float
from frontage.geometry.plane import facade_axes
from frontage.geometry.rigid import Rigid3
from frontage.model import Face, Solid
from frontage.solids.brep import GRID_PER_M, Edge, directed_edges, newell_normal, rings_of
from frontage.solids.options import BuildOptions
from frontage.solids.relief import FacadeReliefs

_COPLANAR_M = 0.005  # largest distance of a wall's corner from its plane; half of what the validator accepts
_GROUND_SINE = 0.17  # ground may rise by 10 degrees away from a wall whose openings stand on it
_GROUND_UP = 0.5  # vertical component of the normal of such ground, at least


@dataclass(frozen=True, eq=False)
class HostWall:
    """Coplanar faces of a coarse solid and their common frame.

    local_from_wall  axes as in a facade frame; the origin is a vertex of the solid
    faces            indices of the faces in the solid
    polygons         the same faces as polygons in whole 0.1 mm (x, z)
    nodes            (x, z) in 0.1 mm -> vertex id of the solid
    border           directed edge of the border -> index of the face beyond it
    ground           the part of `border` that openings may be cut down to
    """

    local_from_wall: Rigid3
    faces: tuple[int, ...]
    polygons: tuple[Polygon, ...]
    nodes: dict[tuple[int, int], int]
    border: dict[Edge, int]
    ground: dict[Edge, int] = field(default_factory=dict)


def find_walls(solid: Solid, facade: FacadeReliefs, options: BuildOptions) -> tuple[HostWall, ...]:
    """Finds the walls of a solid that lie under a facade's outline, largest first.

    A wall qualifies if it is parallel to the facade within `max_angle`, lies within `max_offset` of its plane
    and meets its outline.
    """
    local = solid.vertices / GRID_PER_M
    outline = shapely.make_valid(Polygon(facade.outline)).buffer(options.max_offset)
    found: list[tuple[float, int]] = []
    inward = facade.local_from_facade.R[:, 1]
    for k, face in enumerate(solid.faces):
        if face.semantics != "WallSurface" or face.opening is not None:
            continue
        if -newell_normal(local[list(face.ring)]) @ inward < np.cos(np.radians(options.max_angle)):
            continue
        in_facade = facade.local_from_facade.inverse.apply(local[list(face.ring)])
        projected = Polygon(in_facade[:, [0, 2]])
        if abs(in_facade[:, 1].mean()) <= options.max_offset and projected.intersects(outline):
            found.append((-projected.area, k))
    return _coplanar_groups(solid, [k for _, k in sorted(found)])


def _coplanar_groups(solid: Solid, candidates: Sequence[int]) -> tuple[HostWall, ...]:
    """Groups coplanar faces; the largest face of each group gives the plane."""
    local = solid.vertices / GRID_PER_M
    walls, rest = [], list(candidates)
    while rest:
        ring = local[list(solid.faces[rest[0]].ring)]
        n = newell_normal(ring)
        off = [np.abs((local[_vertex_ids(solid.faces[k])] - ring.mean(0)) @ n).max() for k in rest]
        near = [k for k, d in zip(rest, off, strict=True) if d <= _COPLANAR_M] or rest[:1]
        own = _without_steps(solid, near)
        rest = [k for k in rest if k not in own]
        walls.append(_make_wall(solid, own))
    return tuple(walls)


def _without_steps(solid: Solid, faces: Sequence[int]) -> list[int]:
    """Returns the faces that no step, however small, separates from the earlier ones.

    At a step, two vertices of the solid have the same place on the wall.
    """
    local = solid.vertices / GRID_PER_M
    n = newell_normal(local[list(solid.faces[faces[0]].ring)])
    frame = Rigid3("local", "wall", facade_axes(-n), local[solid.faces[faces[0]].ring[0]])
    vertex_at: dict[tuple[int, int], int] = {}
    kept = []
    for k in faces:
        ids = _vertex_ids(solid.faces[k])
        places = [(int(x), int(z)) for x, z in _on_wall_grid(frame, local[ids])]
        if all(vertex_at.get(p, i) == i for p, i in zip(places, ids, strict=True)):
            vertex_at |= zip(places, ids, strict=True)
            kept.append(k)
    return kept


def _vertex_ids(face: Face) -> list[int]:
    return [i for ring in rings_of(face) for i in ring]


def _make_wall(solid: Solid, own: Sequence[int]) -> HostWall:
    """Makes the wall of coplanar faces; the first face gives the plane."""
    local = solid.vertices / GRID_PER_M
    n = newell_normal(local[list(solid.faces[own[0]].ring)])
    beyond = {e: k for k, f in enumerate(solid.faces) for e in directed_edges(f)}
    first = solid.faces[own[0]].ring[0]
    frame = Rigid3("local", "wall", facade_axes(-n), local[first])
    ids = sorted({i for k in own for i in _vertex_ids(solid.faces[k])})
    flat = _on_wall_grid(frame, local[ids])
    place = dict(zip(ids, map(tuple, flat.tolist()), strict=True))
    polygons = tuple(_polygon(solid.faces[k], place) for k in own)
    edges = {e for k in own for e in directed_edges(solid.faces[k])}
    border = {e: beyond[e[::-1]] for e in sorted(edges) if e[::-1] not in edges}
    ground = {e: k for e, k in border.items() if _is_ground(solid, frame, k, place[e[0]], place[e[1]])}
    return HostWall(frame, tuple(own), polygons, {p: i for i, p in place.items()}, border, ground)


def _on_wall_grid(frame: Rigid3, local: Float) -> Array:
    """Projects points (n, 3) m local onto the wall's plane: (x, z) in whole 0.1 mm (n, 2)."""
    return np.rint(frame.inverse.apply(local)[:, [0, 2]] * GRID_PER_M).astype(np.int64)


def _polygon(face: Face, place: dict[int, tuple[int, int]]) -> Polygon:
    shell, *holes = ([place[i] for i in ring] for ring in rings_of(face))
    return Polygon(shell, holes)


def _is_ground(solid: Solid, frame: Rigid3, face: int, a: tuple[int, int], b: tuple[int, int]) -> bool:
    """Decides whether a border edge is the foot of the wall on ground that meets the wall squarely."""
    if solid.faces[face].semantics != "GroundSurface" or b[0] - a[0] < abs(b[1] - a[1]):
        return False
    n = newell_normal(solid.vertices[list(solid.faces[face].ring)] / GRID_PER_M)
    return bool(abs(n @ frame.R[:, 1]) < _GROUND_SINE and abs(n @ frame.R[:, 2]) > _GROUND_UP)


def find_again(solid: Solid, earlier: Solid, wall: HostWall) -> HostWall | None:
    """Finds a wall of an earlier solid in a later one; returns None if any of its faces has changed."""
    key = {_corner_bytes(solid, f): k for k, f in enumerate(solid.faces)}
    own = [key.get(_corner_bytes(earlier, earlier.faces[k]), -1) for k in wall.faces]
    return None if -1 in own else _make_wall(solid, own)


def _corner_bytes(solid: Solid, face: Face) -> tuple[bytes, ...]:
    return tuple(solid.vertices[list(r)].tobytes() for r in rings_of(face))
