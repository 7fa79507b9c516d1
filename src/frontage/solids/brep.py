"""Boundary representations on the integer grid: rings, directed edges, normals and volumes.

Topology and volumes are computed in whole numbers, so that they are exact.
"""

import itertools
from collections.abc import Iterable, Iterator, Sequence
from typing import TypeVar

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.model import Face, Solid

GRID_PER_M = 10_000
"""Grid steps per metre: the vertices of a `Solid` are whole multiples of 0.1 mm."""

Edge = tuple[int, int]
"""A directed edge: the vertex ids of its start and its end."""

Vertex = TypeVar("Vertex")


def rings_of(face: Face) -> tuple[tuple[int, ...], ...]:
    """Returns the rings of a face as vertex ids: the outer ring first, then the holes."""
    return (face.ring, *face.holes)


def ring_edges(ring: Sequence[Vertex]) -> Iterator[tuple[Vertex, Vertex]]:
    """Yields the directed edges of a ring, the closing edge last."""
    return zip(ring, (*ring[1:], ring[0]), strict=True)


def directed_edges(face: Face) -> Iterator[Edge]:
    """Yields the directed edges of all rings of a face; the interior of the face lies on their left."""
    for ring in rings_of(face):
        yield from ring_edges(ring)


def unmatched_edges(faces: Iterable[Face]) -> list[Edge]:
    """Returns the directed edges whose reverse does not occur exactly once.

    A closed and consistently oriented shell has none.
    """
    count: dict[Edge, int] = {}
    for face in faces:
        for edge in directed_edges(face):
            count[edge] = count.get(edge, 0) + 1
    return [e for e, n in count.items() if n != 1 or count.get(e[::-1], 0) != 1]


def newell_normal(points: Float) -> Float:
    """Returns the unit normal (3,) of a ring (k, 3) by Newell's method; zero if the ring spans no area."""
    p = np.asarray(points, np.float64) - points[0]
    n = np.cross(p, np.roll(p, -1, axis=0)).sum(0)
    length = float(np.linalg.norm(n))
    return np.asarray(n / length) if length > 0 else np.zeros(3)


def volume6(solid: Solid) -> int:
    """Returns six times the volume of a closed solid in cubic grid steps (1e-12 m3), as an exact integer.

    The sum of the determinants of triangle fans over all rings (divergence theorem).
    """
    low = solid.vertices.min(0)
    v: list[list[int]] = (solid.vertices - low).tolist()
    return sum(_fan_volume6(v, ring) for face in solid.faces for ring in rings_of(face))


def _fan_volume6(v: Sequence[Sequence[int]], ring: Sequence[int]) -> int:
    """Returns the sum of the determinants of the triangles of a fan."""
    (ax, ay, az), total = v[ring[0]], 0
    for i, j in itertools.pairwise(ring[1:]):
        (bx, by, bz), (cx, cy, cz) = v[i], v[j]
        total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return total


def without_repeats(ring: Sequence[int]) -> tuple[int, ...]:
    """Removes the vertices of a ring that equal the vertex before them."""
    return tuple(v for v, before in zip(ring, (ring[-1], *ring[:-1]), strict=True) if v != before)


def without_spurs(ring: Iterable[Vertex]) -> tuple[Vertex, ...]:
    """Removes repeated vertices and spurs (edges that run out and straight back) from a ring."""
    out: list[Vertex] = []
    for v in ring:
        if len(out) > 1 and out[-2] == v:
            out.pop()
        elif not out or out[-1] != v:
            out.append(v)
    while len(out) > 2 and (out[0] == out[-1] or out[1] == out[-1] or out[0] == out[-2]):
        out = out[1:] if out[1] == out[-1] else out[:-1]
    return tuple(out)


def compact(building: str, vertices: Int, faces: Sequence[Face], origin: Int, lod: str) -> Solid:
    """Makes a solid that keeps only the vertices (v, 3) its faces use, in their order."""
    used = sorted({i for face in faces for ring in rings_of(face) for i in ring})
    new = {old: k for k, old in enumerate(used)}
    renumbered = tuple(
        Face(
            tuple(new[i] for i in f.ring),
            f.semantics,
            tuple(tuple(new[i] for i in h) for h in f.holes),
            f.opening,
        )
        for f in faces
    )
    return Solid(building, vertices[used], origin, renumbered, lod)
