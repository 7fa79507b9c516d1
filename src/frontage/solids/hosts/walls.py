"""The host walls that a facade was measured on: groups of coplanar faces, with a frame of their own."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from shapely.geometry import Polygon

from frontage.geometry.arrays import Array, Float
from frontage.geometry.plane import facade_axes
from frontage.geometry.rigid import Rigid3
from frontage.model import Face, Solid
from frontage.solids.relief import GRID, BuildOptions, FacadeReliefs
from frontage.solids.rims import Edge, edges_of, normal, rings_of

_FLAT = 0.005  # m: corners of one wall this far off its plane; half of what a valid face may have
_UPRIGHT = 0.17  # the ground may rise by 10 degrees away from a wall that openings stand on it in


@dataclass(frozen=True, eq=False)
class Wall:
    """Coplanar host faces and their common frame.

    local_from_wall  axes as a facade frame; the origin is a host vertex
    faces            numbers of the host faces
    polygons         the same in whole 0.1 mm (x, z)
    nodes            (x, z) in 0.1 mm -> host vertex
    border           directed host edge -> number of the face beyond it
    ground           those of `border` that openings may be cut down to
    """

    local_from_wall: Rigid3
    faces: tuple[int, ...]
    polygons: tuple[Polygon, ...]
    nodes: dict[tuple[int, int], int]
    border: dict[Edge, int]
    ground: dict[Edge, int] = field(default_factory=dict)


def find_walls(solid: Solid, facade: FacadeReliefs, options: BuildOptions) -> tuple[Wall, ...]:
    """The walls of a solid under a facade's outline, largest first."""
    local = solid.vertices / GRID
    outline = shapely.make_valid(Polygon(facade.outline)).buffer(options.max_offset)
    found: list[tuple[float, int]] = []
    inward = facade.local_from_facade.R[:, 1]
    for k, face in enumerate(solid.faces):
        if face.semantics != "WallSurface" or face.opening is not None:
            continue
        if -normal(local[list(face.ring)]) @ inward < np.cos(np.radians(options.max_angle)):
            continue
        seen = facade.local_from_facade.inverse.apply(local[list(face.ring)])
        shadow = Polygon(seen[:, [0, 2]])
        if abs(seen[:, 1].mean()) <= options.max_offset and shadow.intersects(outline):
            found.append((-shadow.area, k))
    return _grouped(solid, [k for _, k in sorted(found)])


def _grouped(solid: Solid, candidates: Sequence[int]) -> tuple[Wall, ...]:
    """Coplanar candidates together; the largest of each group gives the plane."""
    local = solid.vertices / GRID
    walls, rest = [], list(candidates)
    while rest:
        ring = local[list(solid.faces[rest[0]].ring)]
        n = normal(ring)
        off = [np.abs((local[_ids(solid.faces[k])] - ring.mean(0)) @ n).max() for k in rest]
        own = [k for k, d in zip(rest, off, strict=True) if d <= _FLAT] or rest[:1]
        rest = [k for k in rest if k not in own]
        walls.append(make_wall(solid, own))
    return tuple(walls)


def _ids(face: Face) -> list[int]:
    return [i for ring in rings_of(face) for i in ring]


def make_wall(solid: Solid, own: Sequence[int]) -> Wall:
    """The wall of coplanar faces, the first of which gives its plane."""
    local = solid.vertices / GRID
    n = normal(local[list(solid.faces[own[0]].ring)])
    beyond = {e: k for k, f in enumerate(solid.faces) for e in edges_of(f)}
    first = solid.faces[own[0]].ring[0]
    frame = Rigid3("local", "wall", facade_axes(-n), local[first])
    ids = sorted({i for k in own for i in _ids(solid.faces[k])})
    flat = wall_grid(frame, local[ids])
    place = dict(zip(ids, map(tuple, flat.tolist()), strict=True))
    polygons = tuple(_polygon(solid.faces[k], place) for k in own)
    edges = {e for k in own for e in edges_of(solid.faces[k])}
    border = {e: beyond[e[::-1]] for e in sorted(edges) if e[::-1] not in edges}
    ground = {e: k for e, k in border.items() if _is_ground(solid, frame, k, place[e[0]], place[e[1]])}
    return Wall(frame, tuple(own), polygons, {p: i for i, p in place.items()}, border, ground)


def wall_grid(frame: Rigid3, local: Float) -> Array:
    """Points (n, 3) m local in the wall's plane, whole 0.1 mm (n, 2)."""
    return np.rint(frame.inverse.apply(local)[:, [0, 2]] * GRID).astype(np.int64)


def _polygon(face: Face, place: dict[int, tuple[int, int]]) -> Polygon:
    shell, *holes = ([place[i] for i in ring] for ring in rings_of(face))
    return Polygon(shell, holes)


def _is_ground(solid: Solid, frame: Rigid3, face: int, a: tuple[int, int], b: tuple[int, int]) -> bool:
    """Whether a border edge is a foot of the wall on ground that meets it squarely."""
    if solid.faces[face].semantics != "GroundSurface" or b[0] - a[0] < abs(b[1] - a[1]):
        return False
    n = normal(solid.vertices[list(solid.faces[face].ring)] / GRID)
    return bool(abs(n @ frame.R[:, 1]) < _UPRIGHT and abs(n @ frame.R[:, 2]) > 0.5)


def find_again(solid: Solid, earlier: Solid, wall: Wall) -> Wall | None:
    """A wall of an earlier solid in a later one, if none of its faces was changed."""
    key = {_corners(solid, f): k for k, f in enumerate(solid.faces)}
    own = [key.get(_corners(earlier, earlier.faces[k]), -1) for k in wall.faces]
    return None if -1 in own else make_wall(solid, own)


def _corners(solid: Solid, face: Face) -> tuple[bytes, ...]:
    return tuple(solid.vertices[list(r)].tobytes() for r in rings_of(face))
