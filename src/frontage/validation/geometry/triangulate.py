"""Triangulates valid faces: constrained Delaunay in the plane of the face, without new vertices."""

from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float, Int
from frontage.validation.geometry.faces_2d import NodedRings, face_polygons
from frontage.validation.geometry.mesh import Mesh
from frontage.validation.geometry.rows import distinct_rows

_TURNS = 30  # orientations that are tried where GEOS fails on a face as it lies
_GOLDEN_ANGLE_RAD = 2.399963229728653  # between them: no two orientations are alike


@dataclass(frozen=True, eq=False)
class Triangles:
    """The valid faces of a mesh as triangles.

    ids        (t, 3) vertex ids
    face       (t,) face of each triangle
    edges      (e, 2) vertex ids of all ring edges, split where rings of one face touch
    edge_face  (e,) face of each ring edge
    """

    ids: Int
    face: Int
    edges: Int
    edge_face: Int

    @classmethod
    def of(cls, mesh: Mesh, xy: Float, faces: Bool, noded: NodedRings) -> "Triangles":
        """Triangulates the chosen faces (f,); the ring edges are those of all faces."""
        ids, face = triangulate(mesh, xy, faces, noded)
        corners, _ = noded.closed(np.ones(len(noded.rings) - 1, np.bool_))
        ring = np.repeat(np.arange(len(noded.rings) - 1), np.diff(noded.rings) + 1)
        same = ring[1:] == ring[:-1]
        edges = mesh.corners[np.stack([corners[:-1][same], corners[1:][same]], axis=1)]
        return cls(ids, face, edges, mesh.face_of_ring[ring[1:][same]])

    @classmethod
    def none(cls) -> "Triangles":
        """Returns the triangles of a mesh without faces."""
        return cls(*(np.zeros(s, np.int64) for s in ((0, 3), 0, (0, 2), 0)))


def triangulate(mesh: Mesh, xy: Float, faces: Bool, noded: NodedRings) -> tuple[Int, Int]:
    """Returns triangles (t, 3) of vertex ids, oriented as their faces, and the face of each (t,).

    `xy` (c, 2) m are the corners in the planes of their faces, `faces` (f,) the faces to triangulate.
    """
    first = noded.rings[mesh.faces]
    size = np.diff(first)
    single = faces & (np.diff(mesh.faces) == 1)
    three, four = np.nonzero(single & (size == 3))[0], np.nonzero(single & (size == 4))[0]
    triangles = noded.corners[first[three][:, None] + np.arange(3)]
    halves = _split_quadrangles(xy, noded.corners[first[four][:, None] + np.arange(4)])
    rest = faces.copy()
    rest[three] = rest[four] = False
    corners, face = _delaunay(mesh, xy, rest, noded)
    all_corners = np.concatenate([triangles, halves, corners])
    of_face = np.concatenate([three, np.repeat(four, 2), face])
    order = np.argsort(of_face, kind="stable")
    return mesh.corners[all_corners[order]], of_face[order]


def _split_quadrangles(xy: Float, ring: Int) -> Int:
    """Splits rings (n, 4) into triangles (2 n, 3) along the diagonal whose smaller triangle is larger."""
    a, b, c, d = ring.T
    ways = np.stack(
        [np.stack([a, b, c, a, c, d], 1).reshape(-1, 2, 3), np.stack([b, c, d, b, d, a], 1).reshape(-1, 2, 3)]
    )
    smallest = _double_areas(xy, ways.reshape(-1, 3)).reshape(2, -1, 2).min(axis=2)
    best = np.argmax(smallest, axis=0)
    chosen: Int = ways[best, np.arange(len(ring))]
    return chosen.reshape(-1, 3)


def _double_areas(xy: Float, triangles: Int) -> Float:
    """Returns twice the signed area (t,) of triangles (t, 3) of corner indices."""
    a, b, c = (xy[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def _delaunay(mesh: Mesh, xy: Float, faces: Bool, noded: NodedRings) -> tuple[Int, Int]:
    """Returns corner indices (t, 3) and the face of each triangle (t,).

    GEOS joins holes in an order that depends on their position, and can fail where many of them touch (one
    face in ten thousand); the same face works when it is rotated.
    """
    if not faces.any():
        return np.zeros((0, 3), np.int64), np.zeros(0, np.int64)
    try:
        return _delaunay_as_drawn(mesh, xy, faces, noded)
    except shapely.errors.GEOSException:
        found = [_delaunay_rotated(mesh, xy, int(f), noded) for f in np.nonzero(faces)[0]]
        return np.concatenate([t for t, _ in found]), np.concatenate([f for _, f in found])


def _delaunay_rotated(mesh: Mesh, xy: Float, face: int, noded: NodedRings) -> tuple[Int, Int]:
    """Does the same for one face, as drawn or rotated until it works."""
    chosen = np.arange(len(mesh.faces) - 1) == face
    for k in range(_TURNS):
        s, c = np.sin(k * _GOLDEN_ANGLE_RAD), np.cos(k * _GOLDEN_ANGLE_RAD)
        try:
            return _delaunay_as_drawn(mesh, xy @ np.array([[c, s], [-s, c]]), chosen, noded)
        except shapely.errors.GEOSException as problem:
            last = problem
    raise last


def _delaunay_as_drawn(mesh: Mesh, xy: Float, faces: Bool, noded: NodedRings) -> tuple[Int, Int]:
    """Returns the triangles of GEOS, their corners found again by their coordinates.

    Raises GEOSException if GEOS fails, or if the triangles do not cover a face.
    """
    drawn = face_polygons(mesh, xy, faces, noded)
    parts, which = shapely.get_parts(shapely.constrained_delaunay_triangles(drawn), return_index=True)
    covered = np.bincount(which, weights=shapely.area(parts), minlength=len(drawn))
    if (np.abs(covered - shapely.area(drawn)) > mesh.noise * shapely.length(drawn)).any():
        raise shapely.errors.GEOSException("the triangles do not cover the face")
    face = np.nonzero(faces)[0][which]
    spots = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3].reshape(-1, 2)
    known = np.nonzero(faces[mesh.face_of_corner])[0]
    keys = np.concatenate(
        [
            np.column_stack([mesh.face_of_corner[known], xy[known]]),
            np.column_stack([np.repeat(face, 3), spots]),
        ]
    )
    _, group, _ = distinct_rows(keys)
    corner = np.full(group.max() + 1, -1)
    corner[group[: len(known)]] = known
    triangles = corner[group[len(known) :]].reshape(-1, 3)
    clockwise = _double_areas(xy, triangles) < 0
    triangles[clockwise] = triangles[clockwise][:, [0, 2, 1]]
    return triangles, face
