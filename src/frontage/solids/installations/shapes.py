"""Shapes of installations: a tray for a balcony, a sloping sheet for an awning, a prism for all others."""

from collections.abc import Sequence

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.ring import ring_area
from frontage.model import ProtrusionKind

SLAB_M, PARAPET_M, CLOTH_M = 0.20, 0.10, 0.05
"""Assumed thickness of a balcony's slab and parapet and of an awning; a street scan cannot measure it."""

_SHORTEST_EDGE_M = (
    0.002  # vertices of an outline closer than this are one; twice the validator's snap tolerance
)

Polyhedron = tuple[Float, list[tuple[int, ...]]]
"""Vertices (n, 3) m, and faces as vertex ids, counter-clockwise as seen from outside."""


def installation_shape(
    kind: ProtrusionKind, ring: Float, front: float, back: float
) -> tuple[Polyhedron, str]:
    """Returns the shape of an installation in the wall frame, and what of it was assumed.

    `ring` (k, 2) m (x, z) is its outline, `front` and `back` the y (m) between which it extends.
    """
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    deep, wide, high = back - front, x1 - x0, z1 - z0
    if (
        kind is ProtrusionKind.BALCONY
        and high > SLAB_M + PARAPET_M
        and deep > 2 * PARAPET_M
        and wide > 3 * PARAPET_M
    ):
        assumed = f"slab {SLAB_M:g} m, parapet {PARAPET_M:g} m thick"
        return _tray((x0, front, z0), (x1, back, z1)), assumed
    if kind is ProtrusionKind.AWNING and high > 2 * CLOTH_M:
        section = np.array([[back, z1], [back, z1 - CLOTH_M], [front, z0], [front, z0 + CLOTH_M]])
        return _sheet(section, x0, x1), f"{CLOTH_M:g} m thick, straight from its upper to its front edge"
    return _prism(ring, front, back), ""


def _prism(ring: Float, front: float, back: float) -> Polyhedron:
    """Extrudes an outline (x, z) between two depths."""
    ring = ring[np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1) > _SHORTEST_EDGE_M]
    ring = ring if ring_area(ring) > 0 else ring[::-1]
    k = len(ring)
    xyz = np.concatenate([np.insert(ring, 1, y, axis=1) for y in (front, back)])
    sides = [((a + 1) % k, a, a + k, (a + 1) % k + k) for a in range(k)]
    return xyz, [tuple(range(k)), tuple(range(2 * k - 1, k - 1, -1)), *sides]


def _sheet(section: Float, x0: float, x1: float) -> Polyhedron:
    """Extrudes a section (y, z) between two sides."""
    section = section if ring_area(section) > 0 else section[::-1]
    k = len(section)
    xyz = np.concatenate([np.insert(section, 0, x, axis=1) for x in (x0, x1)])
    sides = [(a, (a + 1) % k, (a + 1) % k + k, a + k) for a in range(k)]
    return xyz, [tuple(range(k))[::-1], tuple(range(k, 2 * k)), *sides]


def _tray(low: Sequence[float], high: Sequence[float]) -> Polyhedron:
    """Returns a slab with a parapet along its front and both sides, open towards the wall."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    a, b, c, floor = x0 + PARAPET_M, x1 - PARAPET_M, y0 + PARAPET_M, z0 + SLAB_M
    plan = [(x0, y0), (x1, y0), (x1, y1), (b, y1), (b, c), (a, c), (a, y1), (x0, y1)]
    top = [(x, y, z1) for x, y in plan]  # 0-7
    inner = [(x, y, floor) for x, y in plan[3:7]]  # 8-11: right back, right front, left front, left back
    foot = [(x, y, z0) for x, y in (plan[0], plan[1], plan[2], plan[7])]  # 12-15
    faces = [
        (0, 1, 2, 3, 4, 5, 6, 7),
        (15, 14, 13, 12),
        (12, 13, 1, 0),
        (13, 14, 2, 1),
        (15, 12, 0, 7),
        (14, 15, 7, 6, 11, 8, 3, 2),
        (9, 8, 11, 10),
        (3, 8, 9, 4),
        (4, 9, 10, 5),
        (5, 10, 11, 6),
    ]
    return np.array(top + inner + foot), faces
