"""Faces drawn as shapely polygons in their planes, edges noded where corners of other rings touch them."""

from typing import Any

import numpy as np
import shapely

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.validation.geometry.mesh import Mesh


def noded(mesh: Mesh, xy: Float, corner: Int, edge: Int) -> tuple[Int, Int]:
    """All rings as corner numbers with each `corner` put into its `edge`: numbers (c',), offsets (r + 1,).

    Two rings that touch share a vertex afterwards, so that rounding cannot make them cross.
    """
    a, b = xy[edge], xy[mesh.after[edge]]
    t = np.einsum("ni,ni->n", xy[corner] - a, b - a)
    order = np.lexsort((t, edge))
    corner, edge = corner[order], edge[order]
    index = np.insert(np.arange(len(mesh.corners)), edge + 1, corner)
    added = np.bincount(mesh.ring_of_corner[edge], minlength=len(mesh.rings) - 1)
    return index, mesh.rings + np.concatenate([[0], np.cumsum(added)])


def closed(index: Int, rings: Int, chosen: Bool) -> tuple[Int, Int]:
    """Corner numbers of the chosen rings (r,), each with its first again at the end, and their offsets."""
    start, length = rings[:-1][chosen], np.diff(rings)[chosen]
    offsets = np.concatenate([[0], np.cumsum(length + 1)])
    step = np.arange(offsets[-1]) - np.repeat(offsets[:-1], length + 1)
    return index[np.repeat(start, length + 1) + step % np.repeat(length, length + 1)], offsets


def ring_polygons(mesh: Mesh, xy: Float, chosen: Bool) -> Array:
    """Every chosen ring (r,) as a polygon of its own."""
    index, offsets = closed(np.arange(len(mesh.corners)), mesh.rings, chosen)
    return _ragged(xy[index], offsets, np.arange(len(offsets)))


def face_polygons(mesh: Mesh, xy: Float, chosen: Bool, index: Int, rings: Int) -> Array:
    """Every chosen face (f,) with its holes, from noded rings."""
    corners, offsets = closed(index, rings, chosen[mesh.face_of_ring])
    count = np.diff(mesh.faces)[chosen]
    return _ragged(xy[corners], offsets, np.concatenate([[0], np.cumsum(count)]))


def _ragged(xy: Float, rings: Int, faces: Int) -> Array:
    if len(faces) < 2:
        return np.zeros(0, object)
    kind: Any = shapely.GeometryType.POLYGON
    return np.asarray(shapely.from_ragged_array(kind, np.ascontiguousarray(xy), (rings, faces)))
