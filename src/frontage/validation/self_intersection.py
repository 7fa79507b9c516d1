"""Level 3: faces of one shell must not meet beyond their common edges and vertices. Code 306."""

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int
from frontage.model import Finding
from frontage.validation.geometry.boxes import box_pairs
from frontage.validation.geometry.distances import TINY, double_areas, to_segments, to_triangles
from frontage.validation.geometry.intersection_lines import intersection_lines
from frontage.validation.geometry.mesh import Mesh
from frontage.validation.geometry.rows import distinct_rows, rows_among
from frontage.validation.geometry.triangle_pairs import triangles_meet
from frontage.validation.geometry.triangulate import Triangles
from frontage.validation.tolerances import Tolerances


def check_self_intersection(mesh: Mesh, triangles: Triangles, tolerances: Tolerances) -> list[Finding]:
    """Finds 306 once for every pair of faces that cross, overlap or touch, and 303 for an edge inside a face.

    Faces are flat within tolerance only, so near what two of them share they may run into each other by
    rounding: what lies within the snap tolerance of their common edges and vertices does not count.
    """
    thick = _smallest_altitudes(mesh.xyz[triangles.ids]) > mesh.noise
    ids, face = triangles.ids[thick], triangles.face[thick]
    pairs = box_pairs(mesh.xyz, ids, None, mesh.noise)
    pairs = pairs[face[pairs[:, 0]] != face[pairs[:, 1]]]
    hit = triangles_meet(mesh.grid, ids[pairs[:, 0]], ids[pairs[:, 1]])
    hit |= _share_a_diagonal(triangles, ids, face, pairs)
    hit |= _unconnected_but_touching(mesh, triangles, ids, face, pairs)
    pairs = pairs[hit]
    between = np.sort(face[pairs], axis=1)
    near = max(tolerances.snap, mesh.noise)
    findings: list[Finding] = []
    for f, g in distinct_rows(between)[0].tolist():
        own = ids[pairs[(between == (f, g)).all(1)]]
        at = _point_away_from_shared(mesh, triangles, own, (f, g), near)
        if at is not None:
            where = f"{mesh.face_name(f)}&{mesh.face_name(g)}"
            text = "two faces meet beyond their common edges and vertices"
            findings.append(Finding(306, text, where, "", mesh.location(at)))
            findings += _edge_inside_face(mesh, triangles, f, g)
    return findings


def _unconnected_but_touching(mesh: Mesh, triangles: Triangles, ids: Int, face: Int, pairs: Int) -> Bool:
    """Returns the pairs (n,) of triangles that touch within noise although their faces share no vertex."""
    pair_faces, label, _ = distinct_rows(face[pairs])
    members = [set(v) for v in _by_face(triangles.edges[:, 0], triangles.edge_face, len(mesh.faces) - 1)]
    unconnected = np.array([members[f].isdisjoint(members[g]) for f, g in pair_faces], np.bool_)
    chosen = np.nonzero(unconnected[label])[0] if len(pairs) else np.zeros(0, np.int64)
    hit = np.zeros(len(pairs), np.bool_)
    one, other = mesh.xyz[ids[pairs[chosen, 0]]], mesh.xyz[ids[pairs[chosen, 1]]]
    hit[chosen[[k for k, _ in intersection_lines(one, other, mesh.noise)]]] = True
    return hit


def _by_face(vertices: Int, face: Int, number: int) -> list[list[int]]:
    """Groups vertices (e,) by their face (e,)."""
    order = np.argsort(face, kind="stable")
    bounds = np.searchsorted(face[order], np.arange(1, number))
    return [part.tolist() for part in np.split(vertices[order], bounds)]


def _share_a_diagonal(triangles: Triangles, ids: Int, face: Int, pairs: Int) -> Bool:
    """Returns the pairs (n,) of triangles whose common edge is not a ring edge of both faces."""
    first, second = ids[pairs[:, 0]], ids[pairs[:, 1]]
    common = (first[:, :, None] == second[:, None, :]).any(2)
    two = np.nonzero(common.sum(1) == 2)[0]
    ends = np.sort(first[two][common[two]].reshape(-1, 2), axis=1)
    ring_edges = np.column_stack([triangles.edge_face, np.sort(triangles.edges, axis=1)])
    known = [rows_among(np.column_stack([face[pairs[two, k]], ends]), ring_edges) for k in (0, 1)]
    through = np.zeros(len(pairs), np.bool_)
    through[two] = ~(known[0] & known[1])
    return through


def _smallest_altitudes(corners: Float) -> Float:
    """Returns the smallest altitudes (t,) m of triangles (t, 3, 3) m."""
    longest = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(1)
    return np.asarray(double_areas(corners) / np.maximum(longest, TINY))


def _point_away_from_shared(
    mesh: Mesh, triangles: Triangles, pairs: Int, faces: tuple[int, int], near: float
) -> Float | None:
    """Returns a common point (3,) of two faces further than `near` (m) from all that they share.

    `pairs` (n, 2, 3) are the vertex ids of their triangles that meet. Returns None if there is no such point.
    """
    one, other = mesh.xyz[pairs[:, 0]], mesh.xyz[pairs[:, 1]]
    lines = intersection_lines(one, other, mesh.noise)
    vertices, edges = _shared(triangles, *faces)
    if not len(vertices):
        return np.asarray(lines[0][1].mean(0) if lines else one[0].mean(0))
    if not lines:
        return None
    # both ends of a line may lie on what is shared while its middle does not
    spots = np.concatenate([((line[:, None] + line[None]) / 2).reshape(-1, 3) for _, line in lines])
    away = _to_closest_segment(spots, mesh.xyz[vertices][:, None].repeat(2, 1))
    away = np.minimum(away, _to_closest_segment(spots, mesh.xyz[edges])) if len(edges) else away
    return np.asarray(spots[np.argmax(away)]) if away.max() > near else None


def _shared(triangles: Triangles, f: int, g: int) -> tuple[Int, Int]:
    """Returns the vertices (n,) and the edges (m, 2) that two faces have in common."""
    first, second = triangles.edges[triangles.edge_face == f], triangles.edges[triangles.edge_face == g]
    vertices = np.intersect1d(first, second)
    known = {tuple(sorted(e)) for e in second.tolist()}
    edges = [e for e in first.tolist() if tuple(sorted(e)) in known]
    return vertices, np.array(edges, np.int64).reshape(-1, 2)


def _to_closest_segment(points: Float, segments: Float) -> Float:
    """Returns the distance (n,) of points (n, 3) to the closest of segments (m, 2, 3)."""
    n, m = len(points), len(segments)
    a, b = np.tile(segments[:, 0], (n, 1)), np.tile(segments[:, 1], (n, 1))
    return np.asarray(to_segments(np.repeat(points, m, axis=0), a, b).reshape(n, m).min(axis=1))


def _edge_inside_face(mesh: Mesh, triangles: Triangles, f: int, g: int) -> list[Finding]:
    """303: an edge of one face runs through the interior of the other between two of its vertices."""
    for one, other in ((f, g), (g, f)):
        edges = triangles.edges[triangles.edge_face == one]
        border = triangles.edges[triangles.edge_face == other]
        edges = edges[np.isin(edges, border).all(1)]
        if not len(edges):
            continue
        corners = mesh.xyz[triangles.ids[triangles.face == other]]
        for a, b in edges:
            middle = mesh.xyz[[a, b]].mean(0)[None]
            on = to_triangles(np.repeat(middle, len(corners), axis=0), corners).min() <= mesh.noise
            if on and _to_closest_segment(middle, mesh.xyz[border])[0] > mesh.noise:
                text = "an edge runs through the interior of a face, so that four sheets meet there"
                where = f"{mesh.face_name(one)}&{mesh.face_name(other)}"
                return [Finding(303, text, where, "", mesh.location(middle[0]), qie=304)]
    return []
