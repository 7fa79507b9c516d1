"""Cuts one closed surface along another one and classifies its pieces as inside, outside or on it.

This is done in floating point with a noise threshold, not with exact signs: the surfaces of two solids often
touch on purpose, and rotation or rounding turns such a touch into a gap or an overlap of 1e-9 m.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.validation.closed_surface import ClosedSurface
from frontage.validation.geometry.boxes import box_pairs
from frontage.validation.geometry.distances import (
    TINY,
    double_areas,
    to_closest_triangle,
    unit_normals,
    winding_numbers,
)
from frontage.validation.geometry.intersection_lines import intersection_lines
from frontage.validation.geometry.rows import distinct_rows

OUTSIDE, OPPOSITE, INSIDE, SAME = -1, 0, 1, 2
"""States of a piece: outside or inside the other surface, or on it with the opposite or the same normal."""

ON_NOISES = 8  # a point this many noises from a surface lies on it
_GRID_NOISES = 4  # grid on which the pieces are noded, in noises


@dataclass(frozen=True, eq=False)
class TrianglePiece:
    """A piece of a triangle: its rings (k, 3), a point in the middle (3,) and its width, all in m."""

    rings: list[Float]
    middle: Float
    width: float


@dataclass(frozen=True, eq=False)
class ClassifiedPieces:
    """Pieces of a closed surface, each wholly inside, outside or on another one.

    middle  (n, 3) m
    width   (n,) m: diameter of the largest circle in each piece
    state   (n,) OUTSIDE, INSIDE, SAME or OPPOSITE
    depth   (n,) m: distance to the other surface
    """

    middle: Float
    width: Float
    state: Int
    depth: Float

    def has(self, *states: int) -> bool:
        """Decides whether any piece is in one of the states."""
        return bool(np.isin(self.state, states).any())

    def widest(self, *states: int) -> Float:
        """Returns the middle (3,) m of the widest piece in one of the states."""
        own = np.nonzero(np.isin(self.state, states))[0]
        return np.asarray(self.middle[own[np.argmax(self.width[own])]])


def classify_pieces(one: ClosedSurface, other: ClosedSurface) -> ClassifiedPieces:
    """Cuts `one` along `other` and classifies its pieces.

    Of connected triangles that `other` does not touch, only the widest one is returned.
    """
    lines = contact_lines(one, other)
    pieces = [cut_triangle(one.corners[t], own, one.noise) for t, own in lines.items()]
    counts = [len(p) for p in pieces]
    normals = np.repeat(unit_normals(one.corners[list(lines)]), counts, axis=0)
    middles = [np.array([p.middle for p in own]).reshape(-1, 3) for own in pieces]
    widths = [np.array([p.width for p in own]) for own in pieces]
    rest = one.corners[_untouched(one, np.array(sorted(lines), np.int64))]
    middle = np.concatenate([*middles, rest.mean(1)])
    width = np.concatenate([*widths, _incircle_diameters(rest)])
    normal = np.concatenate([normals, unit_normals(rest)])
    depth, nearest = to_closest_triangle(middle, other.corners)
    state = np.where(np.abs(winding_numbers(middle, other.corners)) > 0.5, INSIDE, OUTSIDE)
    on = depth <= ON_NOISES * one.noise
    along = np.einsum("ni,ni->n", normal, unit_normals(other.corners)[nearest]) > 0
    state[on] = np.where(along[on], SAME, OPPOSITE)
    return ClassifiedPieces(middle, width, state, depth)


def contact_lines(one: ClosedSurface, other: ClosedSurface) -> dict[int, list[Float]]:
    """Returns triangle of `one` -> the lines (k, 3) m along which `other` touches it."""
    joined = np.concatenate([one.xyz, other.xyz])
    pairs = box_pairs(joined, one.ids, other.ids + len(one.xyz), 2 * one.noise)
    found: dict[int, list[Float]] = {}
    corners = one.corners[pairs[:, 0]], other.corners[pairs[:, 1]]
    for pair, line in intersection_lines(*corners, one.noise):
        found.setdefault(int(pairs[pair, 0]), []).append(line)
    return found


def cut_triangle(corners: Float, lines: Sequence[Float], noise: float) -> list[TrianglePiece]:
    """Cuts a triangle (3, 3) m along lines (k, 3) m in its plane."""
    origin = corners[0]
    u = (corners[1] - origin) / np.linalg.norm(corners[1] - origin)
    v = np.cross(np.cross(u, corners[2] - origin), u)
    frame = np.stack([u, v / np.linalg.norm(v)])
    drawn = [shapely.linestrings((np.vstack([corners, corners[:1]]) - origin) @ frame.T)]
    drawn += [shapely.linestrings((line - origin) @ frame.T) for line in lines if len(line) > 1]
    network = shapely.union_all(drawn, grid_size=_GRID_NOISES * noise)
    pieces = []
    for polygon in shapely.get_parts(shapely.polygonize([network])):
        radius = shapely.maximum_inscribed_circle(polygon)
        if radius.length > noise:
            rings = [shapely.get_coordinates(r)[:-1] for r in (polygon.exterior, *polygon.interiors)]
            middle = shapely.get_coordinates(radius)[0] @ frame + origin
            pieces.append(TrianglePiece([r @ frame + origin for r in rings], middle, 2 * radius.length))
    return pieces


def _incircle_diameters(corners: Float) -> Float:
    """Returns the diameters (t,) of the incircles of triangles (t, 3, 3)."""
    perimeter = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).sum(1)
    return np.asarray(2 * double_areas(corners) / np.maximum(perimeter, TINY))


def _untouched(one: ClosedSurface, touched: Int) -> Int:
    """Returns the widest triangle of every edge-connected component of the triangles that are not touched."""
    free = np.setdiff1d(np.arange(len(one.ids)), touched)
    if not len(free):
        return free
    half_edges = np.stack([one.ids[free], np.roll(one.ids[free], -1, axis=1)], axis=2).reshape(-1, 2)
    _, label, _ = distinct_rows(np.sort(half_edges, axis=1))
    triangle = np.repeat(np.arange(len(free)), 3)
    size = len(free) + int(label.max()) + 1
    graph = coo_array((np.ones(len(triangle)), (triangle, len(free) + label)), shape=(size, size))
    group: Array = connected_components(graph, directed=False)[1][: len(free)]
    order = np.lexsort((-_incircle_diameters(one.corners[free]), group))
    first: Bool = np.ones(len(order), np.bool_)
    first[1:] = group[order][1:] != group[order][:-1]
    return np.asarray(free[order[first]])
