"""Valid faces as triangles: constrained Delaunay in the face's plane, no vertex added."""

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float, Int
from frontage.validation.geometry.drawing import face_polygons
from frontage.validation.geometry.mesh import Mesh
from frontage.validation.geometry.rows import distinct

_TURNS, _ANGLE = 30, 2.399963229728653  # the golden angle: no two turns alike


def triangulate(mesh: Mesh, xy: Float, faces: Bool, index: Int, rings: Int) -> tuple[Int, Int]:
    """Triangles (t, 3) of vertex ids, turned as the face's normal, and the face of each (t,).

    `index`, `rings`: the rings as `noded` gives them.
    """
    first = rings[mesh.faces]
    size = np.diff(first)
    single = faces & (np.diff(mesh.faces) == 1)
    three, four = np.nonzero(single & (size == 3))[0], np.nonzero(single & (size == 4))[0]
    plain = index[first[three][:, None] + np.arange(3)]
    halves = _quadrangles(xy, index[first[four][:, None] + np.arange(4)])
    rest = faces.copy()
    rest[three] = rest[four] = False
    corners, face = _delaunay(mesh, xy, rest, index, rings)
    triangles = np.concatenate([plain, halves, corners])
    of_face = np.concatenate([three, np.repeat(four, 2), face])
    order = np.argsort(of_face, kind="stable")
    return mesh.corners[triangles[order]], of_face[order]


def _quadrangles(xy: Float, ring: Int) -> Int:
    """Two triangles (2 n, 3) each for rings (n, 4), by the diagonal whose smaller triangle is larger."""
    a, b, c, d = ring.T
    ways = np.stack(
        [np.stack([a, b, c, a, c, d], 1).reshape(-1, 2, 3), np.stack([b, c, d, b, d, a], 1).reshape(-1, 2, 3)]
    )
    worth = _area(xy, ways.reshape(-1, 3)).reshape(2, -1, 2).min(axis=2)
    best = np.argmax(worth, axis=0)
    chosen: Int = ways[best, np.arange(len(ring))]
    return chosen.reshape(-1, 3)


def _area(xy: Float, triangles: Int) -> Float:
    """Twice the signed area (t,)."""
    a, b, c = (xy[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def _delaunay(mesh: Mesh, xy: Float, faces: Bool, index: Int, rings: Int) -> tuple[Int, Int]:
    """Corner numbers (t, 3) and face (t,).

    GEOS joins holes in an order that depends on their position and, where many of them touch, can fail (one
    face in ten thousand); turned a little, the same face works.
    """
    if not faces.any():
        return np.zeros((0, 3), np.int64), np.zeros(0, np.int64)
    try:
        return _as_drawn(mesh, xy, faces, index, rings)
    except shapely.errors.GEOSException:
        found = [_one_turned(mesh, xy, int(f), index, rings) for f in np.nonzero(faces)[0]]
        return np.concatenate([t for t, _ in found]), np.concatenate([f for _, f in found])


def _one_turned(mesh: Mesh, xy: Float, face: int, index: Int, rings: Int) -> tuple[Int, Int]:
    """The same for one face, as drawn or turned until it works."""
    chosen = np.arange(len(mesh.faces) - 1) == face
    for k in range(_TURNS):
        s, c = np.sin(k * _ANGLE), np.cos(k * _ANGLE)
        try:
            return _as_drawn(mesh, xy @ np.array([[c, s], [-s, c]]), chosen, index, rings)
        except shapely.errors.GEOSException as problem:
            last = problem
    raise last


def _as_drawn(mesh: Mesh, xy: Float, faces: Bool, index: Int, rings: Int) -> tuple[Int, Int]:
    """GEOS's triangles; the corners are found again by their coordinates.

    Raises GEOSException where it fails, or the triangles do not cover a face.
    """
    drawn = face_polygons(mesh, xy, faces, index, rings)
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
    _, group, _ = distinct(keys)
    corner = np.full(group.max() + 1, -1)
    corner[group[: len(known)]] = known
    triangles = corner[group[len(known) :]].reshape(-1, 3)
    turned = _area(xy, triangles) < 0
    triangles[turned] = triangles[turned][:, [0, 2, 1]]
    return triangles, face
