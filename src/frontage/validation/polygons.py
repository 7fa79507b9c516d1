"""Level 2: faces must be flat and their rings simple. Codes 104 and 201 to 208."""

from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float, Int
from frontage.model import Finding
from frontage.validation.geometry.drawing import closed, ring_polygons
from frontage.validation.geometry.mesh import Mesh
from frontage.validation.geometry.planes import Flat, flatten
from frontage.validation.geometry.touching import corners_on_edges
from frontage.validation.geometry.triangulate import triangulate
from frontage.validation.holes import check_holes
from frontage.validation.rings import ring_name
from frontage.validation.tolerances import Tolerances


@dataclass(frozen=True, eq=False)
class Triangles:
    """A mesh's valid faces as triangles: vertex ids (t, 3) and the face of each (t,).

    `edges` (e, 2) vertex ids of all ring edges, noded where rings of one face touch; `edge_face` (e,).
    """

    ids: Int
    face: Int
    edges: Int
    edge_face: Int


def check_polygons(mesh: Mesh, faces: Bool, tolerances: Tolerances) -> tuple[list[Finding], Triangles]:
    """Findings on faces (f,) whose rings passed level 1, and the triangles of the faces that are valid."""
    flat = flatten(mesh)
    findings = _uneven(mesh, flat, faces, tolerances.planarity_distance)
    even = faces & ~_faces_beyond(mesh, flat, tolerances.planarity_distance)
    crossing = _not_simple(mesh, flat, even)
    for ring, corner in crossing:
        findings += _crossing(mesh, flat, ring, corner, tolerances)
    simple = even.copy()
    simple[mesh.face_of_ring[[ring for ring, _ in crossing]]] = False
    in_holes, index, rings = check_holes(mesh, flat, simple, tolerances.snap)
    findings += in_holes
    whole = simple.copy()
    whole[[_face_number(f) for f in in_holes]] = False
    ids, face = triangulate(mesh, flat.xy, whole, index, rings)
    triangles = Triangles(ids, face, *_ring_edges(mesh, index, rings))
    return findings + _folds(mesh, triangles, tolerances), triangles


def _ring_edges(mesh: Mesh, index: Int, rings: Int) -> tuple[Int, Int]:
    """Vertex ids (e, 2) of all edges of noded rings, and the face of each (e,)."""
    follows, _ = closed(index, rings, np.ones(len(rings) - 1, np.bool_))
    ring = np.repeat(np.arange(len(rings) - 1), np.diff(rings) + 1)
    step = ring[1:] == ring[:-1]
    edges = mesh.corners[np.stack([follows[:-1][step], follows[1:][step]], axis=1)]
    return edges, mesh.face_of_ring[ring[1:][step]]


def _face_number(finding: Finding) -> int:
    return int(finding.where.split("|")[0].removeprefix("face=").split("(")[0])


def _faces_beyond(mesh: Mesh, flat: Flat, limit: float) -> Bool:
    beyond = np.zeros(len(mesh.faces) - 1, np.bool_)
    beyond[mesh.face_of_corner[np.abs(flat.offset) > limit + mesh.noise]] = True
    return beyond


def _uneven(mesh: Mesh, flat: Flat, faces: Bool, limit: float) -> list[Finding]:
    """203: corners too far from the fitted plane."""
    findings = []
    for f in map(int, np.nonzero(faces & _faces_beyond(mesh, flat, limit))[0]):
        own = np.nonzero(mesh.face_of_corner == f)[0]
        worst = own[np.argmax(np.abs(flat.offset[own]))]
        text = f"a vertex is {abs(flat.offset[worst]):.4f} m off the fitted plane (tolerance {limit:g} m)"
        at = mesh.place(mesh.xyz[mesh.corners[worst]])
        findings.append(Finding(203, text, mesh.face(f), "", at))
    return findings


def _not_simple(mesh: Mesh, flat: Flat, faces: Bool) -> list[tuple[int, int]]:
    """Rings that touch or cross themselves, each with a corner of where it happens, or -1."""
    ring = mesh.ring_of_corner
    guilty: dict[int, int] = {}
    corner, edge = corners_on_edges(mesh, flat.xy, faces, mesh.noise)
    own = ring[corner] == ring[edge]
    for c in corner[own]:
        guilty.setdefault(int(ring[c]), int(c))
    order = np.lexsort((mesh.corners, ring))
    twice = (mesh.corners[order][1:] == mesh.corners[order][:-1]) & (ring[order][1:] == ring[order][:-1])
    for c in order[1:][twice]:
        if faces[mesh.face_of_corner[c]]:
            guilty.setdefault(int(ring[c]), int(c))
    chosen = faces[mesh.face_of_ring]
    for r in np.nonzero(chosen)[0][~shapely.is_valid(ring_polygons(mesh, flat.xy, chosen))]:
        guilty.setdefault(int(r), -1)
    return sorted(guilty.items())


def _crossing(mesh: Mesh, flat: Flat, ring: int, corner: int, tolerances: Tolerances) -> list[Finding]:
    """104, and 204 where edges of the crossing ring stand out of the plane: a fold seen edge on."""
    own = np.arange(mesh.rings[ring], mesh.rings[ring + 1])
    spot = mesh.place(mesh.xyz[mesh.corners[corner if corner >= 0 else own[0]]])
    where = ring_name(mesh, ring)
    spread = np.linalg.svd(flat.xy[own] - flat.xy[own].mean(0), compute_uv=False)
    if spread[1] <= mesh.noise * np.sqrt(len(own)):
        return [Finding(104, "the ring is collapsed to a line", where, "", spot, qie=105)]
    verb = "touches" if corner >= 0 else "crosses"
    found = [Finding(104, f"the ring {verb} itself", where, "", spot)]
    rise = np.abs(flat.offset[mesh.after[own]] - flat.offset[own])
    run = np.linalg.norm(flat.xy[mesh.after[own]] - flat.xy[own], axis=1)
    steep = np.degrees(np.arctan2(rise, run))
    worst = int(np.argmax(steep))
    if steep[worst] > tolerances.planarity_normals:
        text = f"an edge leaves the face's plane by {steep[worst]:.1f} degrees"
        at = mesh.place(mesh.xyz[mesh.corners[own[worst]]])
        found.append(Finding(204, text, where.split("|")[0], "", at))
    return found


def _folds(mesh: Mesh, triangles: Triangles, tolerances: Tolerances) -> list[Finding]:
    """204: triangles of one face whose normals differ; those thinner than the snap tolerance have none."""
    a, b, c = (mesh.xyz[triangles.ids[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    twice = np.linalg.norm(cross, axis=1)
    longest = np.max(
        [np.linalg.norm(b - a, axis=1), np.linalg.norm(c - b, axis=1), np.linalg.norm(a - c, axis=1)], 0
    )
    thick = twice > max(tolerances.snap, mesh.noise) * longest
    unit = cross[thick] / twice[thick][:, None]
    face, spot = triangles.face[thick], ((a + b + c) / 3)[thick]
    mean = np.zeros((len(mesh.faces) - 1, 3))
    np.add.at(mean, face, cross[thick])
    mean /= np.maximum(np.linalg.norm(mean, axis=1), 1e-300)[:, None]
    tilt = np.degrees(np.arccos(np.clip(np.einsum("ti,ti->t", unit, mean[face]), -1, 1)))
    findings = []
    for f in np.unique(face[tilt > tolerances.planarity_normals / 2]):
        own = np.nonzero(face == f)[0]
        angle, one = _widest(unit[own])
        if angle > tolerances.planarity_normals:
            text = f"normals inside the face differ by {angle:.1f} degrees"
            text += f" (tolerance {tolerances.planarity_normals:g})"
            findings.append(Finding(204, text, mesh.face(int(f)), "", mesh.place(spot[own[one]])))
    return findings


def _widest(unit: Float) -> tuple[float, int]:
    """The largest angle (degrees) between two of the unit vectors (n, 3), and one of the two."""
    cosine = np.clip(unit @ unit.T, -1, 1)
    worst = int(np.argmin(cosine))
    return float(np.degrees(np.arccos(cosine.flat[worst]))), worst // len(unit)
