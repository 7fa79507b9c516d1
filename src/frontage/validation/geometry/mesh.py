"""Polygon meshes whose vertices are welded by the snap tolerance and lie on an integer grid.

On that grid all later predicates are exact.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.model import Polygons
from frontage.validation.geometry.rows import distinct_rows

_QUANTUM_M = 2.0**-30  # grid step; a thousandth of the smallest tolerance that is used in practice
_NOISE_M = 1e-7  # rounding of projections and rotations; nothing is told apart below it
_NOISE_ULPS = 8  # the same in units of the last place of the largest coordinate
_EXACT_BITS = 52  # coordinates with more bits are not exact as float64


@dataclass(frozen=True, eq=False)
class Vertices:
    """Vertices that several meshes share.

    grid     (v, 3) int64 in steps of `quantum` m from `origin`
    origin   (3,) m, world
    noise    m: what rounding of the input's coordinates amounts to
    """

    grid: Int
    quantum: float
    origin: Float
    noise: float

    @cached_property
    def xyz(self) -> Float:
        """Coordinates (v, 3) in metres from `origin`."""
        return np.asarray(self.grid * self.quantum, np.float64)


@dataclass(frozen=True, eq=False)
class Mesh:
    """Faces as rings of vertex ids.

    vertices  shared with other meshes
    corners   (c,) vertex ids of all rings one after the other, without a repeated closing point
    rings     (r + 1,) offsets: ring k is ``corners[rings[k]:rings[k + 1]]``
    faces     (f + 1,) offsets: face k has the rings ``faces[k]`` to ``faces[k + 1]``, the outer one first
    unclosed  (r,) whether the closing point was required and missing
    names     of the faces in the input, where they have any
    """

    vertices: Vertices
    corners: Int
    rings: Int
    faces: Int
    unclosed: Bool
    names: tuple[str, ...]

    @property
    def grid(self) -> Int:
        """Vertices (v, 3) as integers."""
        return self.vertices.grid

    @property
    def xyz(self) -> Float:
        """Vertices (v, 3) in metres from `origin`."""
        return self.vertices.xyz

    @property
    def origin(self) -> Float:
        """Origin (3,) of the coordinates, m, world."""
        return self.vertices.origin

    @property
    def noise(self) -> float:
        """What rounding of the input's coordinates amounts to, m."""
        return self.vertices.noise

    @cached_property
    def ring_of_corner(self) -> Int:
        """Ring that each corner is in (c,)."""
        return np.repeat(np.arange(len(self.rings) - 1), np.diff(self.rings))

    @cached_property
    def face_of_ring(self) -> Int:
        """Face that each ring is in (r,)."""
        return np.repeat(np.arange(len(self.faces) - 1), np.diff(self.faces))

    @cached_property
    def face_of_corner(self) -> Int:
        """Face that each corner is in (c,)."""
        return self.face_of_ring[self.ring_of_corner]

    @cached_property
    def after(self) -> Int:
        """Index of the corner that follows each corner in its ring (c,)."""
        after = np.arange(1, len(self.corners) + 1)
        full = np.diff(self.rings) > 0
        after[self.rings[1:][full] - 1] = self.rings[:-1][full]
        return after

    @cached_property
    def following(self) -> Int:
        """Vertex that follows each corner in its ring (c,)."""
        return self.corners[self.after]

    def face_name(self, face: int) -> str:
        """Returns how findings name a face."""
        name = self.names[face] if face < len(self.names) else ""
        return f"face={face}" + (f"({name})" if name else "")

    def ring_name(self, ring: int) -> str:
        """Returns how findings name a ring: its face and its number there; ring 0 is the outer one."""
        face = int(self.face_of_ring[ring])
        return f"{self.face_name(face)}|ring={ring - int(self.faces[face])}"

    def location(self, local: Array) -> tuple[float, float, float]:
        """Returns the world position of a local point (3,), rounded to a micrometre."""
        x, y, z = (round(float(v), 6) for v in np.asarray(local, np.float64) + self.origin)
        return x, y, z


def weld(
    surfaces: Sequence[Polygons],
    snap: float,
    quantum: float | None = None,
    groups: Sequence[int] | None = None,
) -> list[Mesh]:
    """Makes meshes of surfaces over one set of vertices in which no two are closer than `snap` (m).

    A vertex takes the place of the first one, in order of coordinates, within the tolerance. `quantum` (m) is
    given if the coordinates are known to be whole multiples of it; else it is 2^-30 m, or coarser for extents
    beyond 4000 km. Surfaces of different `groups`, by default none, keep their own vertices.
    """
    points = np.concatenate([np.zeros((0, 3)), *(s.points for s in surfaces)])
    origin = np.floor(points.min(0)) if len(points) else np.zeros(3)
    local = points - origin
    extent = float(np.abs(local).max(initial=1.0))
    step = quantum or max(_QUANTUM_M, 2.0 ** (int(np.ceil(np.log2(extent))) - _EXACT_BITS))
    noise = max(_NOISE_M, _NOISE_ULPS * float(np.spacing(np.abs(points).max(initial=1.0))))
    group = np.repeat(
        groups if groups is not None else [0] * len(surfaces), [len(s.points) for s in surfaces]
    )
    rows = np.column_stack([np.rint(local / step).astype(np.int64), group.astype(np.int64)])
    unique, inverse, _ = distinct_rows(rows)
    reach = snap + 2 * min(step, _QUANTUM_M)
    target = _snap_targets(unique * [step, step, step, 2 * (reach + step)], reach)
    kept = target == np.arange(len(target))
    ids = (np.cumsum(kept) - 1)[target][inverse]
    vertices = Vertices(unique[kept, :3], step, origin, noise)
    starts = np.cumsum([0, *(len(s.points) for s in surfaces)])
    return [_mesh(s, ids[a : a + len(s.points)], vertices) for s, a in zip(surfaces, starts, strict=False)]


def _snap_targets(xyz: Float, snap: float) -> Int:
    """Returns for each vertex the one whose place it takes; chains of close vertices do not collapse."""
    target = np.arange(len(xyz))
    if len(xyz) < 2:
        return target
    pairs = cKDTree(xyz).query_pairs(snap, output_type="ndarray")
    pairs = np.sort(pairs, axis=1)
    for first, second in pairs[np.lexsort(pairs.T[::-1])]:
        if target[first] == first and target[second] == second:
            target[second] = first
    return target


def _mesh(surfaces: Polygons, ids: Int, vertices: Vertices) -> Mesh:
    """Makes the mesh of one set of surfaces; the repeated closing point is removed where one is required."""
    starts, stops = surfaces.rings[:-1], surfaces.rings[1:]
    length = stops - starts
    if surfaces.explicit:
        closed = length > 1
        closed[closed] = ids[starts[closed]] == ids[stops[closed] - 1]
        keep = np.ones(len(ids), np.bool_)
        keep[stops[closed] - 1] = False
        ids, length = ids[keep], length - closed
        unclosed = ~closed
    else:
        unclosed = np.zeros(len(length), np.bool_)
    rings = np.concatenate([[0], np.cumsum(length)])
    return Mesh(vertices, ids, rings, surfaces.faces, unclosed, surfaces.names)
