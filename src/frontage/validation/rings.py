"""Level 1: rings by their points alone, before any geometry. Codes 101, 102 and 103."""

import numpy as np

from frontage.geometry.arrays import Bool
from frontage.model import Finding
from frontage.validation.geometry.mesh import Mesh


def check_rings(mesh: Mesh) -> tuple[list[Finding], Bool]:
    """Finds rings with too few, repeated or no closing points; also returns the faces (f,) without such."""
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
    findings = [
        Finding(101, "the face has no ring", mesh.face_name(int(f)))
        for f in np.nonzero(np.diff(mesh.faces) == 0)[0]
    ]
    for r in np.nonzero(few | repeated | mesh.unclosed)[0]:
        findings += _of_ring(mesh, int(r), bool(few[r]), bool(repeated[r]))
    sound = np.ones(len(mesh.faces) - 1, np.bool_)
    sound[mesh.face_of_ring[few | repeated | mesh.unclosed]] = False
    return findings, sound


def _of_ring(mesh: Mesh, ring: int, few: bool, repeated: bool) -> list[Finding]:
    """Returns the findings of one ring; one with too few points is not checked further."""
    where = mesh.ring_name(ring)
    corners = mesh.corners[mesh.rings[ring] : mesh.rings[ring + 1]]
    spot = mesh.location(mesh.xyz[corners[0]]) if len(corners) else None
    if few:
        count = len(np.unique(corners))
        return [Finding(101, f"the ring has {count} different points; it needs 3", where, "", spot)]
    found = []
    if repeated:
        twice = corners[corners == np.roll(corners, -1)]
        points = "a point is" if len(twice) == 1 else f"{len(twice)} points are"
        text = f"{points} followed by the same point again"
        found.append(Finding(102, text, where, "", mesh.location(mesh.xyz[twice[0]])))
    if mesh.unclosed[ring]:
        found.append(Finding(103, "the first point is not repeated at the end", where, "", spot))
    return found
