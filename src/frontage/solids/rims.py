"""Rings of faces: directed edges, normals, volume. Exact where the answer is a whole number."""

import itertools
from collections.abc import Iterable, Iterator, Sequence
from typing import TypeVar

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.model import Face, Solid

Edge = tuple[int, int]
V = TypeVar("V")


def rings_of(face: Face) -> tuple[tuple[int, ...], ...]:
    """The outer ring and the holes."""
    return (face.ring, *face.holes)


def edges_of(face: Face) -> Iterator[Edge]:
    """The directed edges of a face; its inside lies to the left."""
    for ring in rings_of(face):
        yield from zip(ring, (*ring[1:], ring[0]), strict=True)


def unmatched(faces: Iterable[Face]) -> list[Edge]:
    """Directed edges that do not have their reverse exactly once; a closed, oriented shell has none."""
    count: dict[Edge, int] = {}
    for face in faces:
        for edge in edges_of(face):
            count[edge] = count.get(edge, 0) + 1
    return [e for e, n in count.items() if n != 1 or count.get(e[::-1], 0) != 1]


def normal(points: Float) -> Float:
    """Newell's unit normal (3,) of a ring (k, 3); zero where the ring spans no area."""
    p = np.asarray(points, np.float64) - points[0]
    n = np.cross(p, np.roll(p, -1, axis=0)).sum(0)
    length = float(np.linalg.norm(n))
    return np.asarray(n / length) if length > 0 else np.zeros(3)


def volume6(solid: Solid) -> int:
    """Six times the volume in cubic grid steps (1e-12 m3), as a whole number, by fans of triangles."""
    low = solid.vertices.min(0)
    v: list[list[int]] = (solid.vertices - low).tolist()
    return sum(_fan(v, ring) for face in solid.faces for ring in rings_of(face))


def _fan(v: Sequence[Sequence[int]], ring: Sequence[int]) -> int:
    """Sum of the determinants of the triangles of a fan."""
    (ax, ay, az), total = v[ring[0]], 0
    for i, j in itertools.pairwise(ring[1:]):
        (bx, by, bz), (cx, cy, cz) = v[i], v[j]
        total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return total


def without_repeats(ring: Sequence[int]) -> tuple[int, ...]:
    """A ring without vertices that repeat the one before."""
    return tuple(v for v, before in zip(ring, (ring[-1], *ring[:-1]), strict=True) if v != before)


def without_spurs(ring: Iterable[V]) -> tuple[V, ...]:
    """A ring without repeated vertices and without ways there and back again."""
    out: list[V] = []
    for v in ring:
        if len(out) > 1 and out[-2] == v:
            out.pop()
        elif not out or out[-1] != v:
            out.append(v)
    while len(out) > 2 and (out[0] == out[-1] or out[1] == out[-1] or out[0] == out[-2]):
        out = out[1:] if out[1] == out[-1] else out[:-1]
    return tuple(out)


def compact(building: str, vertices: Int, faces: Sequence[Face], origin: Int, lod: str) -> Solid:
    """A solid with only the vertices that its faces use, in their order."""
    used = sorted({i for face in faces for ring in rings_of(face) for i in ring})
    new = {old: k for k, old in enumerate(used)}
    renamed = tuple(
        Face(
            tuple(new[i] for i in f.ring),
            f.semantics,
            tuple(tuple(new[i] for i in h) for h in f.holes),
            f.opening,
        )
        for f in faces
    )
    return Solid(building, vertices[used], origin, renamed, lod)
