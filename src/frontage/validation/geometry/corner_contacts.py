"""Finds corners of a face that lie on an edge of the same face, in its plane."""

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float, Int
from frontage.validation.geometry.distances import to_segments
from frontage.validation.geometry.mesh import Mesh

_SMALL_FACE = (
    24  # corners: up to here all pairs of a face are tested, beyond it those that a search tree finds
)


def corners_on_edges(mesh: Mesh, xy: Float, faces: Bool, near: float) -> tuple[Int, Int]:
    """Returns the corners of the chosen faces (f,) within `near` (m) of an edge, and these edges.

    An edge is named by its first corner. Edges that start or end in the corner's own vertex are left out.
    """
    corner, edge = _candidates(mesh, xy, faces, near)
    vertex = mesh.corners[corner]
    other = (vertex != mesh.corners[edge]) & (vertex != mesh.following[edge])
    corner, edge = corner[other], edge[other]
    close = to_segments(xy[corner], xy[edge], xy[mesh.after[edge]]) <= near
    return corner[close], edge[close]


def _candidates(mesh: Mesh, xy: Float, faces: Bool, near: float) -> tuple[Int, Int]:
    """Returns all pairs of small faces, and pairs that are close to each other of large ones."""
    first = mesh.rings[mesh.faces]
    size = np.diff(first)
    small = np.nonzero(faces & (size <= _SMALL_FACE))[0]
    corners, edges = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    for k in np.unique(size[small]):
        start = first[small[size[small] == k]]
        i, j = np.divmod(np.arange(k * k), k)
        corners.append((start[:, None] + i).ravel())
        edges.append((start[:, None] + j).ravel())
    for f in np.nonzero(faces & (size > _SMALL_FACE))[0]:
        own = np.arange(first[f], first[f + 1])
        segments = shapely.linestrings(np.stack([xy[own], xy[mesh.after[own]]], axis=1))
        found = shapely.STRtree(segments).query(shapely.points(xy[own]), predicate="dwithin", distance=near)
        corners.append(own[found[0]])
        edges.append(own[found[1]])
    return np.concatenate(corners), np.concatenate(edges)
