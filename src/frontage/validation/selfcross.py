"""Code 306: faces of one shell that meet away from their common edges and vertices."""

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int
from frontage.model import Finding
from frontage.validation.geometry.common import common_lines
from frontage.validation.geometry.crossings import box_pairs, meeting
from frontage.validation.geometry.distances import pairwise
from frontage.validation.geometry.mesh import Mesh
from frontage.validation.geometry.rows import among, distinct
from frontage.validation.geometry.touching import distance
from frontage.validation.polygons import Triangles
from frontage.validation.tolerances import Tolerances


def check_crossings(mesh: Mesh, triangles: Triangles, tolerances: Tolerances) -> list[Finding]:
    """306 for every pair of faces that cross, overlap or touch, once; and 303 where an edge lies in a face.

    Faces are only flat within tolerance, so near what two of them share they may run into each other by
    rounding: what lies within the snap tolerance of their common edges and vertices does not count.
    """
    thick = _altitude(mesh.xyz[triangles.ids]) > mesh.noise
    ids, face = triangles.ids[thick], triangles.face[thick]
    pairs = box_pairs(mesh.xyz, ids, None, mesh.noise)
    pairs = pairs[face[pairs[:, 0]] != face[pairs[:, 1]]]
    hit = meeting(mesh.grid, ids[pairs[:, 0]], ids[pairs[:, 1]])
    hit |= _through_diagonal(triangles, ids, face, pairs)
    hit |= _touching(mesh, triangles, ids, face, pairs)
    pairs = pairs[hit]
    between = np.sort(face[pairs], axis=1)
    findings: list[Finding] = []
    for f, g in distinct(between)[0]:
        own = pairs[(between == (f, g)).all(1)]
        at = _real(mesh, triangles, ids, own, (int(f), int(g)), max(tolerances.snap, mesh.noise))
        if at is not None:
            where = f"{mesh.face(int(f))}&{mesh.face(int(g))}"
            findings.append(Finding(306, "two faces meet where they should not", where, "", mesh.place(at)))
            findings += _edge_inside(mesh, triangles, int(f), int(g))
    return findings


def _touching(mesh: Mesh, triangles: Triangles, ids: Int, face: Int, pairs: Int) -> Bool:
    """Pairs (n, 2) of triangles of faces with no common vertex that are closer than rounding can tell."""
    pair_faces, label, _ = distinct(face[pairs])
    members = [set(v) for v in _by_face(triangles.edges[:, 0], triangles.edge_face, len(mesh.faces) - 1)]
    strange = np.array([members[f].isdisjoint(members[g]) for f, g in pair_faces], np.bool_)
    chosen = np.nonzero(strange[label])[0] if len(pairs) else np.zeros(0, np.int64)
    hit = np.zeros(len(pairs), np.bool_)
    one, other = mesh.xyz[ids[pairs[chosen, 0]]], mesh.xyz[ids[pairs[chosen, 1]]]
    hit[chosen[[k for k, _ in common_lines(one, other, mesh.noise)]]] = True
    return hit


def _by_face(vertices: Int, face: Int, number: int) -> list[list[int]]:
    order = np.argsort(face, kind="stable")
    bounds = np.searchsorted(face[order], np.arange(1, number))
    return [part.tolist() for part in np.split(vertices[order], bounds)]


def _through_diagonal(triangles: Triangles, ids: Int, face: Int, pairs: Int) -> Bool:
    """Pairs (n, 2) of triangles with a common edge that is not a ring edge of both faces."""
    first, second = ids[pairs[:, 0]], ids[pairs[:, 1]]
    common = (first[:, :, None] == second[:, None, :]).any(2)
    two = np.nonzero(common.sum(1) == 2)[0]
    ends = np.sort(first[two][common[two]].reshape(-1, 2), axis=1)
    rims = np.column_stack([triangles.edge_face, np.sort(triangles.edges, axis=1)])
    known = [among(np.column_stack([face[pairs[two, k]], ends]), rims) for k in (0, 1)]
    through = np.zeros(len(pairs), np.bool_)
    through[two] = ~(known[0] & known[1])
    return through


def _altitude(corners: Float) -> Float:
    """Smallest altitude (t,) of triangles (t, 3, 3)."""
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(1)
    twice = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.asarray(twice / np.maximum(sides, 1e-300))


def _real(
    mesh: Mesh, triangles: Triangles, ids: Int, pairs: Int, faces: tuple[int, int], near: float
) -> Float | None:
    """A point common to the two faces, further than `near` from all that they share; None without one."""
    one, other = mesh.xyz[ids[pairs[:, 0]]], mesh.xyz[ids[pairs[:, 1]]]
    lines = common_lines(one, other, mesh.noise)
    vertices, edges = _shared(triangles, *faces)
    if not len(vertices):
        return np.asarray(lines[0][1].mean(0) if lines else one[0].mean(0))
    if not lines:
        return None
    # the ends of a line may both lie on what is shared and its middle not
    spots = np.concatenate([((line[:, None] + line[None]) / 2).reshape(-1, 3) for _, line in lines])
    away = _distance_to(spots, mesh.xyz[vertices][:, None].repeat(2, 1))
    away = np.minimum(away, _distance_to(spots, mesh.xyz[edges])) if len(edges) else away
    return np.asarray(spots[np.argmax(away)]) if away.max() > near else None


def _shared(triangles: Triangles, f: int, g: int) -> tuple[Int, Int]:
    """Vertices (n,) and edges (m, 2) that both faces have."""
    first, second = triangles.edges[triangles.edge_face == f], triangles.edges[triangles.edge_face == g]
    vertices = np.intersect1d(first, second)
    known = {tuple(sorted(e)) for e in second.tolist()}
    edges = [e for e in first.tolist() if tuple(sorted(e)) in known]
    return vertices, np.array(edges, np.int64).reshape(-1, 2)


def _distance_to(points: Float, segments: Float) -> Float:
    """Distance (n,) to the closest of segments (m, 2, 3)."""
    n, m = len(points), len(segments)
    a, b = np.tile(segments[:, 0], (n, 1)), np.tile(segments[:, 1], (n, 1))
    return np.asarray(distance(np.repeat(points, m, axis=0), a, b).reshape(n, m).min(axis=1))


def _edge_inside(mesh: Mesh, triangles: Triangles, f: int, g: int) -> list[Finding]:
    """303: an edge of one face that runs through the inside of the other between two of its vertices."""
    for one, other in ((f, g), (g, f)):
        edges = triangles.edges[triangles.edge_face == one]
        rim = triangles.edges[triangles.edge_face == other]
        edges = edges[np.isin(edges, rim).all(1)]
        if not len(edges):
            continue
        corners = mesh.xyz[triangles.ids[triangles.face == other]]
        for a, b in edges:
            middle = mesh.xyz[[a, b]].mean(0)[None]
            on = pairwise(np.repeat(middle, len(corners), axis=0), corners).min() <= mesh.noise
            if on and _distance_to(middle, mesh.xyz[rim])[0] > mesh.noise:
                text = "an edge that runs through the inside of a face: four sheets meet there"
                where = f"{mesh.face(one)}&{mesh.face(other)}"
                return [Finding(303, text, where, "", mesh.place(middle[0]), qie=304)]
    return []
