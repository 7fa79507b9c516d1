"""Corners of a face that lie on an edge of the same face, in its plane."""

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float, Int
from frontage.validation.geometry.mesh import Mesh

_SMALL = 24  # corners: up to here all pairs of a face are tried at once, beyond it a search tree


def corners_on_edges(mesh: Mesh, xy: Float, faces: Bool, near: float) -> tuple[Int, Int]:
    """Pairs (corner, edge) of the chosen faces with the corner closer than `near` (m) to the edge.

    An edge is named by its first corner. Edges that end in the corner's own vertex do not count.
    """
    corner, edge = _pairs(mesh, xy, faces, near)
    vertex = mesh.corners[corner]
    other = (vertex != mesh.corners[edge]) & (vertex != mesh.following[edge])
    corner, edge = corner[other], edge[other]
    close = distance(xy[corner], xy[edge], xy[mesh.after[edge]]) <= near
    return corner[close], edge[close]


def distance(p: Float, a: Float, b: Float) -> Float:
    """Distance (n,) of points (n, d) to segments (n, d) - (n, d)."""
    along = b - a
    length = np.maximum(np.einsum("ni,ni->n", along, along), 1e-300)
    t = np.clip(np.einsum("ni,ni->n", p - a, along) / length, 0, 1)
    return np.asarray(np.linalg.norm(p - a - t[:, None] * along, axis=1))


def _pairs(mesh: Mesh, xy: Float, faces: Bool, near: float) -> tuple[Int, Int]:
    """Candidates: all pairs in small faces, pairs of close boxes in large ones."""
    first = mesh.rings[mesh.faces]
    size = np.diff(first)
    small = np.nonzero(faces & (size <= _SMALL))[0]
    corners, edges = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    for k in np.unique(size[small]):
        start = first[small[size[small] == k]]
        i, j = np.divmod(np.arange(k * k), k)
        corners.append((start[:, None] + i).ravel())
        edges.append((start[:, None] + j).ravel())
    for f in np.nonzero(faces & (size > _SMALL))[0]:
        own = np.arange(first[f], first[f + 1])
        segments = shapely.linestrings(np.stack([xy[own], xy[mesh.after[own]]], axis=1))
        found = shapely.STRtree(segments).query(shapely.points(xy[own]), predicate="dwithin", distance=near)
        corners.append(own[found[0]])
        edges.append(own[found[1]])
    return np.concatenate(corners), np.concatenate(edges)
