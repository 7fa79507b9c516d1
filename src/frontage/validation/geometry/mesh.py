"""Vertices welded by the snap tolerance, on an integer grid on which every later predicate is exact."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.model import Polygons
from frontage.validation.geometry.rows import distinct

_QUANTUM = 2.0**-30  # m: coordinates are rounded to this; a thousandth of the smallest tolerance anyone sets
_NOISE = 1e-7  # m: rounding of projections and rotations; nothing is told apart below it
_EXACT_BITS = 52


@dataclass(frozen=True, eq=False)
class Mesh:
    """Faces as rings of vertex ids; several meshes may share one set of vertices.

    `grid` (v, 3) int64 in `quantum` metres from `origin` (3,) m, world; `corners` (c,) vertex ids of all
    rings in turn, without a repeated closing point; ring r is `corners[rings[r]:rings[r + 1]]`, face f has
    the rings `faces[f]` to `faces[f + 1]`. `unclosed` (r,): the closing point was needed and missing.
    `noise` m: what rounding in the input's coordinates amounts to.
    """

    grid: Int
    quantum: float
    origin: Float
    noise: float
    corners: Int
    rings: Int
    faces: Int
    unclosed: Bool
    names: tuple[str, ...]

    @cached_property
    def xyz(self) -> Float:
        """Vertices (v, 3) in metres from `origin`."""
        return np.asarray(self.grid * self.quantum, np.float64)

    @cached_property
    def ring_of_corner(self) -> Int:
        """Which ring each corner is in (c,)."""
        return np.repeat(np.arange(len(self.rings) - 1), np.diff(self.rings))

    @cached_property
    def face_of_ring(self) -> Int:
        """Which face each ring is in (r,)."""
        return np.repeat(np.arange(len(self.faces) - 1), np.diff(self.faces))

    @cached_property
    def face_of_corner(self) -> Int:
        """Which face each corner is in (c,)."""
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
        """The vertex after each corner in its ring (c,)."""
        return self.corners[self.after]

    def face(self, number: int) -> str:
        """How a face is called in findings."""
        name = self.names[number] if number < len(self.names) else ""
        return f"face={number}" + (f"({name})" if name else "")

    def place(self, local: Array) -> tuple[float, float, float]:
        """World position of a local one."""
        x, y, z = (round(float(v), 6) for v in np.asarray(local, np.float64) + self.origin)
        return x, y, z


def weld(surfaces: Sequence[Polygons], snap: float, quantum: float | None = None) -> list[Mesh]:
    """Meshes of surfaces over one set of vertices in which no two are closer than `snap` (m).

    A vertex takes the place of the first one, in order of coordinates, within the tolerance. `quantum`
    is given where the coordinates are known to be whole multiples of it; else 2^-30 m, coarser only for
    extents beyond 4000 km.
    """
    points = np.concatenate([np.zeros((0, 3)), *(s.points for s in surfaces)])
    origin = np.floor(points.min(0)) if len(points) else np.zeros(3)
    local = points - origin
    extent = float(np.abs(local).max(initial=1.0))
    step = quantum or max(_QUANTUM, 2.0 ** (int(np.ceil(np.log2(extent))) - _EXACT_BITS))
    noise = max(_NOISE, 8 * float(np.spacing(np.abs(points).max(initial=1.0))))
    unique, inverse, _ = distinct(np.rint(local / step).astype(np.int64))
    target = _snapped(unique * step, snap + 2 * min(step, _QUANTUM))
    kept = target == np.arange(len(target))
    ids = (np.cumsum(kept) - 1)[target][inverse]
    grid = unique[kept]
    starts = np.cumsum([0, *(len(s.points) for s in surfaces)])
    return [
        _mesh(s, ids[a : a + len(s.points)], grid, step, origin, noise)
        for s, a in zip(surfaces, starts, strict=False)
    ]


def _snapped(xyz: Float, snap: float) -> Int:
    """For each vertex the one whose place it takes; chains are cut, not collapsed."""
    target = np.arange(len(xyz))
    if len(xyz) < 2:
        return target
    pairs = cKDTree(xyz).query_pairs(snap, output_type="ndarray")
    pairs = np.sort(pairs, axis=1)
    for first, second in pairs[np.lexsort(pairs.T[::-1])]:
        if target[first] == first and target[second] == second:
            target[second] = first
    return target


def _mesh(surfaces: Polygons, ids: Int, grid: Int, quantum: float, origin: Float, noise: float) -> Mesh:
    """Ring bookkeeping: the repeated closing point goes where one is required."""
    starts, stops = surfaces.rings[:-1], surfaces.rings[1:]
    length = stops - starts
    if surfaces.explicit:
        closed = (length > 1) & (ids[np.minimum(starts, len(ids) - 1)] == ids[stops - 1])
        keep = np.ones(len(ids), np.bool_)
        keep[stops[closed] - 1] = False
        ids, length = ids[keep], length - closed
        unclosed = ~closed
    else:
        unclosed = np.zeros(len(length), np.bool_)
    rings = np.concatenate([[0], np.cumsum(length)])
    return Mesh(grid, quantum, origin, noise, ids, rings, surfaces.faces, unclosed, surfaces.names)
