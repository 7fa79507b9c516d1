"""Level 2, faces with holes: codes 201, 202, 205, 206, 207, 208."""

import itertools
from typing import Any

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float, Int
from frontage.model import Finding
from frontage.validation.geometry.drawing import face_polygons, noded
from frontage.validation.geometry.mesh import Mesh
from frontage.validation.geometry.planes import Flat, ring_areas
from frontage.validation.geometry.touching import corners_on_edges
from frontage.validation.rings import ring_name


def check_holes(mesh: Mesh, flat: Flat, faces: Bool, snap: float) -> tuple[list[Finding], Int, Int]:
    """Findings on faces (f,) whose rings are all simple, and their rings, noded, as `noded` gives them.

    A corner that rounding could have put on either side of an edge is taken to lie on it. Where a face is
    not valid as it is drawn, corners closer than the snap tolerance to another ring's edge touch it.
    """
    holed = faces & (np.diff(mesh.faces) > 1)
    corner, edge = _touches(mesh, flat.xy, holed, mesh.noise)
    index, rings = noded(mesh, flat.xy, corner, edge)
    bad = np.zeros(len(holed), np.bool_)
    bad[holed] = ~shapely.is_valid(face_polygons(mesh, flat.xy, holed, index, rings))
    if bad.any():
        again = _touches(mesh, flat.xy, bad, snap)
        fine = ~bad[mesh.face_of_corner[corner]]
        corner, edge = np.concatenate([corner[fine], again[0]]), np.concatenate([edge[fine], again[1]])
        index, rings = noded(mesh, flat.xy, corner, edge)
        bad[holed] = ~shapely.is_valid(face_polygons(mesh, flat.xy, holed, index, rings))
    findings = []
    for f in np.nonzero(bad)[0]:
        findings += _of_face(mesh, flat.xy, int(f), index, rings)
    return findings + _same_turn(mesh, flat, holed & ~bad), index, rings


def _touches(mesh: Mesh, xy: Float, faces: Bool, near: float) -> tuple[Int, Int]:
    """Corners on edges of other rings."""
    corner, edge = corners_on_edges(mesh, xy, faces, near)
    other = mesh.ring_of_corner[corner] != mesh.ring_of_corner[edge]
    return corner[other], edge[other]


def _of_face(mesh: Mesh, xy: Float, face: int, index: Int, rings: Int) -> list[Finding]:
    """What each pair of rings does to each other; when no pair is at fault, the interior is cut."""
    first, last = int(mesh.faces[face]), int(mesh.faces[face + 1])
    drawn = [shapely.Polygon(xy[index[rings[r] : rings[r + 1]]]) for r in range(first, last)]
    findings = []
    for i, j in itertools.combinations(range(len(drawn)), 2):
        verdict = _pair(drawn[i], drawn[j], i == 0)
        if verdict is not None:
            code, text = verdict
            at = _place(mesh, xy, first + j)
            findings.append(Finding(code, f"ring {j} {text} ring {i}", ring_name(mesh, first + j), "", at))
    if not findings:
        text = "the holes cut the inside of the face into separate pieces"
        findings.append(Finding(205, text, mesh.face(face), "", _place(mesh, xy, first + 1)))
    return findings


def _pair(outer: Any, inner: Any, is_outer: bool) -> tuple[int, str] | None:
    """Code and verb for two rings as filled polygons; None when they may be in one face."""
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


def _place(mesh: Mesh, xy: Float, ring: int) -> tuple[float, float, float]:
    """A corner of a ring in the world."""
    return mesh.place(mesh.xyz[mesh.corners[mesh.rings[ring]]])


def _same_turn(mesh: Mesh, flat: Flat, faces: Bool) -> list[Finding]:
    """Holes that run in the same sense as the outer ring."""
    area = ring_areas(mesh, flat.xy)
    face = mesh.face_of_ring
    outer = mesh.faces[:-1][face]
    wrong = faces[face] & (outer != np.arange(len(area))) & (area * area[outer] > 0)
    text = "the hole runs in the same sense as the outer ring"
    return [
        Finding(208, text, ring_name(mesh, int(r)), "", _place(mesh, flat.xy, int(r)))
        for r in np.nonzero(wrong)[0]
    ]
