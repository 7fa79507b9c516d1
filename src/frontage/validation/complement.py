"""Counts the components of space that touching closed surfaces leave (code 404).

By Alexander duality the complement of a surface S in space has 1 + b2(S) components, where b2, the second
Betti number over two elements, is the number of independent closed surfaces in S. S is made a proper complex
first: its triangles are cut wherever another shell touches them.
"""

import itertools
from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Float, Int
from frontage.validation.closed_surface import ClosedSurface
from frontage.validation.geometry.distances import to_segments
from frontage.validation.geometry.rows import distinct_rows
from frontage.validation.pieces import contact_lines, cut_triangle

_SAME_NOISES = 8  # vertices this many noises apart are one


def complement_components(surfaces: Sequence[ClosedSurface]) -> int:
    """Returns the number of components of space between shells that touch in points and along lines only.

    n shells that do not touch leave n + 1 components.
    """
    lines = [_lines_of_others(surfaces, k) for k in range(len(surfaces))]
    if not any(lines):
        return len(surfaces) + 1
    pieces = [rings for one, own in zip(surfaces, lines, strict=True) for rings in _cut(one, own)]
    edges, piece = _edges(pieces, surfaces[0].noise)
    _, label, count = distinct_rows(edges)
    two = np.nonzero(count[label] == 2)[0]
    pairs = piece[two[np.argsort(label[two], kind="stable")]].reshape(-1, 2)
    size = int(piece.max()) + 1
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(size, size))
    number, patch = connected_components(graph, directed=False)
    boundary = [0] * number  # one bit per edge of more than two pieces
    for e, p in zip(label[count[label] != 2], piece[count[label] != 2], strict=True):
        boundary[patch[p]] ^= 1 << int(e)
    return 1 + number - _rank(boundary)


def _lines_of_others(surfaces: Sequence[ClosedSurface], own: int) -> dict[int, list[Float]]:
    """Returns triangle of one surface -> the lines along which the other surfaces touch it."""
    lines: dict[int, list[Float]] = {}
    for other in (s for k, s in enumerate(surfaces) if k != own):
        for triangle, found in contact_lines(surfaces[own], other).items():
            lines.setdefault(triangle, []).extend(found)
    return lines


def _cut(one: ClosedSurface, lines: dict[int, list[Float]]) -> list[list[Float]]:
    """Returns the pieces of a surface, each as rings (k, 3)."""
    pieces: list[list[Float]] = []
    for t, corners in enumerate(one.corners):
        cut = cut_triangle(corners, lines[t], one.noise) if t in lines else []
        pieces += [p.rings for p in cut] or [[corners]]
    return pieces


def _edges(pieces: Sequence[list[Float]], noise: float) -> tuple[Int, Int]:
    """Returns edges (e, 2) of common vertices, split at every vertex on them, and their pieces (e,)."""
    rings = [(k, ring) for k, piece in enumerate(pieces) for ring in piece]
    xyz = np.concatenate([ring for _, ring in rings])
    pairs = cKDTree(xyz).query_pairs(_SAME_NOISES * noise, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(xyz), len(xyz)))
    number, vertex = connected_components(graph, directed=False)
    place = np.zeros((number, 3))
    place[vertex] = xyz
    edges, piece_of, start = [], [], 0
    for k, ring in rings:
        own = vertex[start : start + len(ring)]
        start += len(ring)
        for a, b in zip(own, np.roll(own, -1), strict=True):
            for p, q in _split_edge(int(a), int(b), place, _SAME_NOISES * noise):
                edges.append((min(p, q), max(p, q)))
                piece_of.append(k)
    return np.array(edges, np.int64), np.array(piece_of, np.int64)


def _split_edge(a: int, b: int, place: Float, near: float) -> list[tuple[int, int]]:
    """Splits an edge at all vertices, of places (v, 3) m, that lie within `near` (m) of it."""
    if a == b:
        return []
    ends = np.broadcast_to(place[a], place.shape), np.broadcast_to(place[b], place.shape)
    on = np.nonzero(to_segments(place, *ends) <= near)[0]
    on = np.union1d(on, [a, b])
    order = on[np.argsort((place[on] - place[a]) @ (place[b] - place[a]))].tolist()
    return list(itertools.pairwise(order))


def _rank(rows: list[int]) -> int:
    """Returns the rank over two elements of a matrix whose rows are the bits of integers."""
    pivots: dict[int, int] = {}
    for row in rows:
        while row:
            top = row.bit_length()
            if top not in pivots:
                pivots[top] = row
                break
            row ^= pivots[top]
    return len(pivots)
