"""Level 2: faces must be flat and their rings simple. Codes 104 and 201 to 208."""

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float
from frontage.model import Finding
from frontage.validation.geometry.corner_contacts import corners_on_edges
from frontage.validation.geometry.distances import TINY
from frontage.validation.geometry.faces_2d import ring_polygons
from frontage.validation.geometry.mesh import Mesh
from frontage.validation.geometry.planes import PlaneFit, fit_planes
from frontage.validation.geometry.triangulate import Triangles
from frontage.validation.holes import check_holes
from frontage.validation.tolerances import Tolerances


def check_polygons(mesh: Mesh, sound: Bool, tolerances: Tolerances) -> tuple[list[Finding], Triangles]:
    """Checks the faces (f,) whose rings passed level 1; also returns the triangles of the valid ones."""
    planes = fit_planes(mesh)
    findings = _not_flat(mesh, planes, sound, tolerances.planarity_distance)
    flat = sound & ~_faces_off_plane(mesh, planes, tolerances.planarity_distance)
    not_simple = _rings_not_simple(mesh, planes, flat)
    for ring, corner in not_simple:
        findings += _self_intersection(mesh, planes, ring, corner, tolerances)
    simple = flat.copy()
    simple[mesh.face_of_ring[[ring for ring, _ in not_simple]]] = False
    holes = check_holes(mesh, planes, simple, tolerances.snap)
    triangles = Triangles.of(mesh, planes.xy, simple & ~holes.invalid, holes.noded)
    return findings + holes.findings + _folds(mesh, triangles, tolerances), triangles


def _faces_off_plane(mesh: Mesh, planes: PlaneFit, limit: float) -> Bool:
    """Returns the faces (f,) with a corner further than `limit` (m) off their plane."""
    off = np.zeros(len(mesh.faces) - 1, np.bool_)
    off[mesh.face_of_corner[np.abs(planes.offset) > limit + mesh.noise]] = True
    return off


def _not_flat(mesh: Mesh, planes: PlaneFit, faces: Bool, limit: float) -> list[Finding]:
    """203: a corner is too far from the fitted plane."""
    findings = []
    for f in map(int, np.nonzero(faces & _faces_off_plane(mesh, planes, limit))[0]):
        own = np.nonzero(mesh.face_of_corner == f)[0]
        worst = own[np.argmax(np.abs(planes.offset[own]))]
        text = f"a vertex is {abs(planes.offset[worst]):.4f} m off the fitted plane (tolerance {limit:g} m)"
        at = mesh.location(mesh.xyz[mesh.corners[worst]])
        findings.append(Finding(203, text, mesh.face_name(f), "", at))
    return findings


def _rings_not_simple(mesh: Mesh, planes: PlaneFit, faces: Bool) -> list[tuple[int, int]]:
    """Returns the rings that touch or cross themselves, each with a corner where it touches itself, or -1."""
    ring = mesh.ring_of_corner
    found: dict[int, int] = {}
    corner, edge = corners_on_edges(mesh, planes.xy, faces, mesh.noise)
    own = ring[corner] == ring[edge]
    for c in corner[own]:
        found.setdefault(int(ring[c]), int(c))
    order = np.lexsort((mesh.corners, ring))
    twice = (mesh.corners[order][1:] == mesh.corners[order][:-1]) & (ring[order][1:] == ring[order][:-1])
    for c in order[1:][twice]:
        if faces[mesh.face_of_corner[c]]:
            found.setdefault(int(ring[c]), int(c))
    chosen = faces[mesh.face_of_ring]
    for r in np.nonzero(chosen)[0][~shapely.is_valid(ring_polygons(mesh, planes.xy, chosen))]:
        found.setdefault(int(r), -1)
    return sorted(found.items())


def _self_intersection(
    mesh: Mesh, planes: PlaneFit, ring: int, corner: int, tolerances: Tolerances
) -> list[Finding]:
    """104; also 204 if an edge of the ring stands out of the plane, which is a fold seen edge on."""
    own = np.arange(mesh.rings[ring], mesh.rings[ring + 1])
    spot = mesh.location(mesh.xyz[mesh.corners[corner if corner >= 0 else own[0]]])
    where = mesh.ring_name(ring)
    spread = np.linalg.svd(planes.xy[own] - planes.xy[own].mean(0), compute_uv=False)
    if spread[1] <= mesh.noise * np.sqrt(len(own)):
        return [Finding(104, "the ring is collapsed to a line", where, "", spot, qie=105)]
    verb = "touches" if corner >= 0 else "crosses"
    found = [Finding(104, f"the ring {verb} itself", where, "", spot)]
    rise = np.abs(planes.offset[mesh.after[own]] - planes.offset[own])
    run = np.linalg.norm(planes.xy[mesh.after[own]] - planes.xy[own], axis=1)
    steep = np.degrees(np.arctan2(rise, run))
    worst = int(np.argmax(steep))
    if steep[worst] > tolerances.planarity_normals:
        text = f"an edge leaves the face's plane by {steep[worst]:.1f} degrees"
        at = mesh.location(mesh.xyz[mesh.corners[own[worst]]])
        found.append(Finding(204, text, where.split("|")[0], "", at))
    return found


def _folds(mesh: Mesh, triangles: Triangles, tolerances: Tolerances) -> list[Finding]:
    """204: the normals of a face's triangles differ; triangles thinner than the snap tolerance have none."""
    a, b, c = (mesh.xyz[triangles.ids[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    twice = np.linalg.norm(cross, axis=1)
    longest = np.max(
        [np.linalg.norm(b - a, axis=1), np.linalg.norm(c - b, axis=1), np.linalg.norm(a - c, axis=1)], 0
    )
    thick = twice > mesh.noise * longest
    unit = cross[thick] / twice[thick][:, None]
    face, spot = triangles.face[thick], ((a + b + c) / 3)[thick]
    mean = np.zeros((len(mesh.faces) - 1, 3))
    np.add.at(mean, face, cross[thick])
    mean /= np.maximum(np.linalg.norm(mean, axis=1), TINY)[:, None]
    tilt = np.degrees(np.arccos(np.clip(np.einsum("ti,ti->t", unit, mean[face]), -1, 1)))
    findings = []
    for f in np.unique(face[tilt > tolerances.planarity_normals / 2]):
        own = np.nonzero(face == f)[0]
        angle, one = _widest_angle(unit[own])
        if angle > tolerances.planarity_normals:
            text = f"normals inside the face differ by {angle:.1f} degrees"
            text += f" (tolerance {tolerances.planarity_normals:g})"
            at = mesh.location(spot[own[one]])
            findings.append(Finding(204, text, mesh.face_name(int(f)), "", at))
    return findings


def _widest_angle(unit: Float) -> tuple[float, int]:
    """Returns the largest angle (degrees) between two unit vectors (n, 3), and the index of one of them."""
    cosine = np.clip(unit @ unit.T, -1, 1)
    worst = int(np.argmin(cosine))
    return float(np.degrees(np.arccos(cosine.flat[worst]))), worst // len(unit)
