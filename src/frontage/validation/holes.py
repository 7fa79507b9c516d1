"""Level 2, faces with holes. Codes 201, 202, 205, 206, 207 and 208."""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float, Int
from frontage.model import Finding
from frontage.validation.geometry.corner_contacts import corners_on_edges
from frontage.validation.geometry.faces_2d import NodedRings, face_polygons, split_at_contacts
from frontage.validation.geometry.mesh import Mesh
from frontage.validation.geometry.planes import PlaneFit, ring_areas


@dataclass(frozen=True, eq=False)
class HoleCheck:
    """The findings on holes, which faces (f,) have any, and all rings, split where they touch each other."""

    findings: list[Finding]
    invalid: Bool
    noded: NodedRings


def check_holes(mesh: Mesh, planes: PlaneFit, faces: Bool, snap: float) -> HoleCheck:
    """Checks how the rings of each face (f,) lie to each other; all of them must be simple.

    A corner that rounding could have put on either side of an edge is taken to lie on it. Where a face is not
    valid as it is drawn, corners within the snap tolerance (m) of another ring's edge are taken to touch it.
    """
    holed = faces & (np.diff(mesh.faces) > 1)
    corner, edge = _ring_contacts(mesh, planes.xy, holed, mesh.noise)
    noded = split_at_contacts(mesh, planes.xy, corner, edge)
    bad = _invalid_polygons(mesh, planes.xy, holed, noded)
    if bad.any():
        again = _ring_contacts(mesh, planes.xy, bad, snap)
        fine = ~bad[mesh.face_of_corner[corner]]
        corner, edge = np.concatenate([corner[fine], again[0]]), np.concatenate([edge[fine], again[1]])
        noded = split_at_contacts(mesh, planes.xy, corner, edge)
        bad = _invalid_polygons(mesh, planes.xy, holed, noded)
    findings = []
    for f in np.nonzero(bad)[0]:
        findings += _ring_relations(mesh, planes.xy, int(f), noded)
    wrong_way = _rings_same_orientation(mesh, planes, holed & ~bad)
    text = "the hole runs in the same sense as the outer ring"
    findings += [
        Finding(208, text, mesh.ring_name(int(r)), "", _first_corner(mesh, int(r))) for r in wrong_way
    ]
    bad[mesh.face_of_ring[wrong_way]] = True
    return HoleCheck(findings, bad, noded)


def _ring_contacts(mesh: Mesh, xy: Float, faces: Bool, near: float) -> tuple[Int, Int]:
    """Returns the corners within `near` (m) of edges of other rings, and these edges."""
    corner, edge = corners_on_edges(mesh, xy, faces, near)
    other = mesh.ring_of_corner[corner] != mesh.ring_of_corner[edge]
    return corner[other], edge[other]


def _invalid_polygons(mesh: Mesh, xy: Float, holed: Bool, noded: NodedRings) -> Bool:
    """Returns the faces (f,) with holes that are not valid polygons."""
    bad = np.zeros(len(holed), np.bool_)
    bad[holed] = ~shapely.is_valid(face_polygons(mesh, xy, holed, noded))
    return bad


def _ring_relations(mesh: Mesh, xy: Float, face: int, noded: NodedRings) -> list[Finding]:
    """Returns what is wrong between the rings of a face; 205 if no pair of them is at fault."""
    first, last = int(mesh.faces[face]), int(mesh.faces[face + 1])
    corners = [noded.corners[noded.rings[r] : noded.rings[r + 1]] for r in range(first, last)]
    drawn = [shapely.Polygon(xy[c]) for c in corners]
    findings = []
    for i, j in itertools.combinations(range(len(drawn)), 2):
        verdict = _ring_pair(drawn[i], drawn[j], i == 0)
        if verdict is not None:
            code, text = verdict
            at = _first_corner(mesh, first + j)
            findings.append(Finding(code, f"ring {j} {text} ring {i}", mesh.ring_name(first + j), "", at))
    if not findings:
        text = "the holes cut the interior of the face into separate pieces"
        findings.append(Finding(205, text, mesh.face_name(face), "", _first_corner(mesh, first + 1)))
    return findings


def _ring_pair(outer: Any, inner: Any, is_outer: bool) -> tuple[int, str] | None:
    """Returns the code and the verb for two rings as filled polygons; None if both may be in one face."""
    pattern = shapely.relate(inner, outer)
    if shapely.equals(inner, outer):
        return 202, "is the same as"
    shared = pattern[4] == "1"  # the two boundaries run together
    overlap, leaves, enters = pattern[0] == "2", pattern[2] == "2", pattern[6] == "2"
    if is_outer:
        if not overlap:
            return 206, "lies outside of"
        return (201, "crosses or runs along") if leaves or shared else None
    if not overlap:
        return (201, "runs along") if shared else None
    return (201, "crosses") if leaves and enters else (207, "is nested with")


def _first_corner(mesh: Mesh, ring: int) -> tuple[float, float, float]:
    """Returns the first corner of a ring in the world."""
    return mesh.location(mesh.xyz[mesh.corners[mesh.rings[ring]]])


def _rings_same_orientation(mesh: Mesh, planes: PlaneFit, faces: Bool) -> Int:
    """Returns the holes that run in the same sense as the outer ring of their face."""
    area = ring_areas(mesh, planes.xy)
    face = mesh.face_of_ring
    outer = mesh.faces[:-1][face]
    return np.nonzero(faces[face] & (outer != np.arange(len(area))) & (area * area[outer] > 0))[0]
