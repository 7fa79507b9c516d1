"""How one closed surface lies to another: its triangles cut along the other, and every piece told apart.

Floating point with a noise threshold, not exact signs: surfaces of two solids touch on purpose, and a
touch that was rotated or rounded is a gap or an overlap of 1e-9 m.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.validation.geometry.common import common_lines
from frontage.validation.geometry.crossings import box_pairs
from frontage.validation.geometry.distances import to_triangles, winding
from frontage.validation.geometry.rows import distinct

OUTSIDE, OPPOSITE, INSIDE, SAME = -1, 0, 1, 2
_GRID = 4  # in noise: pieces are noded on such a grid
_ON = 8  # in noise: a piece this close to the other surface lies on it


Piece = tuple[list[Float], Float, float]  # rings (k, 3), middle (3,), width


@dataclass(frozen=True, eq=False)
class Skin:
    """The closed triangles (t, 3) of one or several shells over vertices `xyz` (v, 3), local metres."""

    xyz: Float
    ids: Int
    noise: float

    @property
    def corners(self) -> Float:
        """Triangles as coordinates (t, 3, 3)."""
        return self.xyz[self.ids]


@dataclass(frozen=True, eq=False)
class Pieces:
    """Parts of a skin, each wholly inside, outside or on another one.

    `middle` (n, 3) m; `width` (n,) m of the largest circle in it; `state` (n,) OUTSIDE, INSIDE, or on the
    other with SAME or OPPOSITE normal; `depth` (n,) m to the other skin.
    """

    middle: Float
    width: Float
    state: Int
    depth: Float

    def has(self, *states: int) -> bool:
        """Whether any piece is in one of the states."""
        return bool(np.isin(self.state, states).any())

    def place(self, *states: int) -> Float:
        """Middle of the widest piece in one of the states."""
        own = np.nonzero(np.isin(self.state, states))[0]
        return np.asarray(self.middle[own[np.argmax(self.width[own])]])


def compare(one: Skin, other: Skin) -> Pieces:
    """The pieces of `one` as they lie to `other`."""
    cuts = contacts(one, other)
    pieces = [cut_triangle(one.corners[t], lines, one.noise) for t, lines in cuts.items()]
    counts = [len(p) for p in pieces]
    normals = np.repeat(_normals(one.corners[list(cuts)]), counts, axis=0)
    spots = [np.array([m for _, m, _ in p]).reshape(-1, 3) for p in pieces]
    widths = [np.array([w for _, _, w in p]) for p in pieces]
    rest = _untouched(one, np.array(sorted(cuts), np.int64))
    corners = one.corners[rest]
    middle = np.concatenate([*spots, corners.mean(1)])
    width = np.concatenate([*widths, _inscribed(corners)])
    normal = np.concatenate([normals, _normals(corners)])
    depth, nearest = to_triangles(middle, other.corners)
    state = np.where(np.abs(winding(middle, other.corners)) > 0.5, INSIDE, OUTSIDE)
    on = depth <= _ON * one.noise
    along = np.einsum("ni,ni->n", normal, _normals(other.corners)[nearest]) > 0
    state[on] = np.where(along[on], SAME, OPPOSITE)
    return Pieces(middle, width, state, depth)


def contacts(one: Skin, other: Skin) -> dict[int, list[Float]]:
    """Per triangle of `one` that `other` touches: where, as lines (k, 3)."""
    joined = np.concatenate([one.xyz, other.xyz])
    pairs = box_pairs(joined, one.ids, other.ids + len(one.xyz), 2 * one.noise)
    found: dict[int, list[Float]] = {}
    for pair, line in common_lines(one.corners[pairs[:, 0]], other.corners[pairs[:, 1]], one.noise):
        found.setdefault(int(pairs[pair, 0]), []).append(line)
    return found


def cut_triangle(corners: Float, lines: Sequence[Float], noise: float) -> list[Piece]:
    """Pieces of a triangle (3, 3) cut along lines: their rings (k, 3), middle (3,) and width (m)."""
    origin = corners[0]
    u = (corners[1] - origin) / np.linalg.norm(corners[1] - origin)
    v = np.cross(np.cross(u, corners[2] - origin), u)
    frame = np.stack([u, v / np.linalg.norm(v)])
    drawn = [shapely.linestrings((np.vstack([corners, corners[:1]]) - origin) @ frame.T)]
    drawn += [shapely.linestrings((line - origin) @ frame.T) for line in lines if len(line) > 1]
    network = shapely.union_all(drawn, grid_size=_GRID * noise)
    pieces = []
    for cell in shapely.get_parts(shapely.polygonize([network])):
        radius = shapely.maximum_inscribed_circle(cell)
        if radius.length > noise:
            rings = [shapely.get_coordinates(r)[:-1] for r in (cell.exterior, *cell.interiors)]
            middle = shapely.get_coordinates(radius)[0]
            pieces.append(([r @ frame + origin for r in rings], middle @ frame + origin, 2 * radius.length))
    return pieces


def _normals(corners: Float) -> Float:
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None])


def _inscribed(corners: Float) -> Float:
    """Diameter (t,) of the inscribed circles of triangles (t, 3, 3)."""
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).sum(1)
    twice = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.asarray(2 * twice / np.maximum(sides, 1e-300))


def _untouched(one: Skin, touched: Int) -> Int:
    """Of all triangles joined by edges and not touched, the widest one speaks for all."""
    free = np.setdiff1d(np.arange(len(one.ids)), touched)
    if not len(free):
        return free
    half = np.stack([one.ids[free], np.roll(one.ids[free], -1, axis=1)], axis=2).reshape(-1, 2)
    _, label, _ = distinct(np.sort(half, axis=1))
    triangle = np.repeat(np.arange(len(free)), 3)
    size = len(free) + int(label.max()) + 1
    graph = coo_array((np.ones(len(triangle)), (triangle, len(free) + label)), shape=(size, size))
    group: Array = connected_components(graph, directed=False)[1][: len(free)]
    order = np.lexsort((-_inscribed(one.corners[free]), group))
    first: Bool = np.ones(len(order), np.bool_)
    first[1:] = group[order][1:] != group[order][:-1]
    return np.asarray(free[order[first]])
