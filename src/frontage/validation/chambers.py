"""Into how many chambers do touching closed surfaces divide space? (code 404)

By Alexander duality the complement of a surface S in space has 1 + b2(S) parts, b2 the number of independent
closed surfaces in S (second Betti number, here over two elements). S is made a proper complex first: its
triangles are cut wherever another shell touches.
"""

import itertools
from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Float, Int
from frontage.validation.cells import Skin, contacts, cut_triangle
from frontage.validation.geometry.rows import distinct
from frontage.validation.geometry.touching import distance

_SAME = 8  # in noise


def chambers(skins: Sequence[Skin]) -> int:
    """Number of parts of space between shells that touch in points and lines only; n + 1 for n apart."""
    lines = [_touched(skins, k) for k in range(len(skins))]
    if not any(lines):
        return len(skins) + 1
    rings = [ring for one, own in zip(skins, lines, strict=True) for ring in _cut(one, own)]
    edges, cell = _edges(rings, skins[0].noise)
    _, label, count = distinct(edges)
    two = np.nonzero(count[label] == 2)[0]
    pairs = cell[two[np.argsort(label[two], kind="stable")]].reshape(-1, 2)
    size = int(cell.max()) + 1
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(size, size))
    number, patch = connected_components(graph, directed=False)
    rows = [0] * number
    for e, c in zip(label[count[label] != 2], cell[count[label] != 2], strict=True):
        rows[patch[c]] ^= 1 << int(e)
    return 1 + number - _rank(rows)


def _touched(skins: Sequence[Skin], own: int) -> dict[int, list[Float]]:
    """Per triangle of one shell, where the others touch it."""
    lines: dict[int, list[Float]] = {}
    for other in (s for k, s in enumerate(skins) if k != own):
        for triangle, found in contacts(skins[own], other).items():
            lines.setdefault(triangle, []).extend(found)
    return lines


def _cut(one: Skin, lines: dict[int, list[Float]]) -> list[list[Float]]:
    """The pieces of a shell, each as rings (k, 3)."""
    pieces: list[list[Float]] = []
    for t, corners in enumerate(one.corners):
        cut = cut_triangle(corners, lines[t], one.noise) if t in lines else []
        pieces += [rings for rings, _, _ in cut] or [[corners]]
    return pieces


def _edges(pieces: Sequence[list[Float]], noise: float) -> tuple[Int, Int]:
    """Edges (e, 2) over common vertices, split at every vertex on them, and the piece of each (e,)."""
    rings = [(k, ring) for k, piece in enumerate(pieces) for ring in piece]
    xyz = np.concatenate([ring for _, ring in rings])
    pairs = cKDTree(xyz).query_pairs(_SAME * noise, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(xyz), len(xyz)))
    number, vertex = connected_components(graph, directed=False)
    place = np.zeros((number, 3))
    place[vertex] = xyz
    edges, cell, start = [], [], 0
    for k, ring in rings:
        own = vertex[start : start + len(ring)]
        start += len(ring)
        for a, b in zip(own, np.roll(own, -1), strict=True):
            for p, q in _split(int(a), int(b), place, _SAME * noise):
                edges.append((min(p, q), max(p, q)))
                cell.append(k)
    return np.array(edges, np.int64), np.array(cell, np.int64)


def _split(a: int, b: int, place: Float, near: float) -> list[tuple[int, int]]:
    """An edge in parts between all vertices that lie on it."""
    if a == b:
        return []
    far = np.broadcast_to(place[a], place.shape), np.broadcast_to(place[b], place.shape)
    on = np.nonzero(distance(place, *far) <= near)[0]
    on = np.union1d(on, [a, b])
    order = on[np.argsort((place[on] - place[a]) @ (place[b] - place[a]))].tolist()
    return list(itertools.pairwise(order))


def _rank(rows: list[int]) -> int:
    """Rank over two elements of a matrix whose rows are bits."""
    pivots: dict[int, int] = {}
    for row in rows:
        while row:
            top = row.bit_length()
            if top not in pivots:
                pivots[top] = row
                break
            row ^= pivots[top]
    return len(pivots)
