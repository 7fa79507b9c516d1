"""Level 1, what rings alone can get wrong before any geometry: codes 101, 102, 103."""

import numpy as np

from frontage.geometry.arrays import Bool
from frontage.model import Finding
from frontage.validation.geometry.mesh import Mesh


def check_rings(mesh: Mesh) -> tuple[list[Finding], Bool]:
    """Findings of too few points, repeated points, open rings, and which faces (f,) have none."""
    ring = mesh.ring_of_corner
    length = np.diff(mesh.rings)
    same = mesh.corners == mesh.following
    order = np.lexsort((mesh.corners, ring))
    fresh = np.ones(len(order), np.bool_)
    fresh[1:] = (mesh.corners[order][1:] != mesh.corners[order][:-1]) | (ring[order][1:] != ring[order][:-1])
    distinct = np.bincount(ring[order][fresh], minlength=len(length))
    few = (length < 3) | (distinct < 2)
    repeated = np.zeros(len(length), np.bool_)
    repeated[ring[same]] = True
    findings = []
    for r in np.nonzero(few | repeated | mesh.unclosed)[0]:
        findings += _of_ring(mesh, int(r), bool(few[r]), bool(repeated[r]))
    good = np.ones(len(mesh.faces) - 1, np.bool_)
    good[mesh.face_of_ring[few | repeated | mesh.unclosed]] = False
    return findings, good


def _of_ring(mesh: Mesh, ring: int, few: bool, repeated: bool) -> list[Finding]:
    """The findings of one ring; one with too few points is not looked at further."""
    where = ring_name(mesh, ring)
    corners = mesh.corners[mesh.rings[ring] : mesh.rings[ring + 1]]
    spot = mesh.place(mesh.xyz[corners[0]]) if len(corners) else None
    if few:
        count = len(np.unique(corners))
        return [Finding(101, f"a ring with {count} different points; 3 are needed", where, "", spot)]
    found = []
    if repeated:
        twice = corners[corners == np.roll(corners, -1)]
        text = "a point repeated at once" if len(twice) == 1 else f"{len(twice)} points repeated at once"
        found.append(Finding(102, text, where, "", mesh.place(mesh.xyz[twice[0]])))
    if mesh.unclosed[ring]:
        found.append(Finding(103, "the first point is not repeated at the end", where, "", spot))
    return found


def ring_name(mesh: Mesh, ring: int) -> str:
    """Face and ring as findings call them; ring 0 is the outer one."""
    face = int(mesh.face_of_ring[ring])
    return f"{mesh.face(face)}|ring={ring - int(mesh.faces[face])}"
