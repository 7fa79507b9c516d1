"""Balconies, awnings, cornices and the like: closed solids of their own, against the wall, no part of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import ring_area
from frontage.model import Face, Failed, Protrusion, ProtrusionKind, Solid, WorldRef
from frontage.solids.relief import GRID
from frontage.solids.rims import normal
from frontage.validation.validate import validate

SLAB, PARAPET, CLOTH = 0.20, 0.10, 0.05
"""Thickness (m) of a balcony's slab and parapet and of an awning: not measured from the street, assumed."""

_STEEP = 0.5  # vertical part of the normal of a floor, a roof or a ceiling
_SHORT = 0.002  # m: vertices of an outline that close are one; twice the validator's snap tolerance
THINNEST = 0.02
"""What stands out by less (m) is no body."""


@dataclass(frozen=True, eq=False)
class Installation:
    """Something that hangs on a facade: its closed solid, and what of it was assumed."""

    id: str
    kind: ProtrusionKind
    facade: str
    solid: Solid
    assumed: str = ""


def installation(
    protrusion: Protrusion, facade: str, local_from_wall: Rigid3, ring: Float, back: float, world: WorldRef
) -> Installation | Failed:
    """A protrusion as a closed solid between the wall and its front.

    `local_from_wall` is a facade frame with y = 0 in the host's wall, `ring` (k, 2) m (x, z) the outline in
    it, `back` the y of the surface that the protrusion stands on, `THINNEST` behind its front at least. A
    balcony is a slab with a parapet on its three free sides, an awning a sloping sheet, everything else the
    outline pulled out of the wall.
    """
    front = float(protrusion.front.value)
    xyz, faces, assumed = _shape(protrusion.kind, ring, front, back)
    grid = np.rint(local_from_wall.apply(xyz) * GRID).astype(np.int64)
    solid = Solid(
        protrusion.id,
        grid,
        world.origin,
        tuple(Face(f, _kind_of(grid, f, protrusion.kind)) for f in faces),
        "3",
    )
    if findings := validate(solid):
        return Failed("S318", f"{protrusion.id}: no valid solid ({findings[0].code} {findings[0].message})")
    return Installation(protrusion.id, protrusion.kind, facade, solid, assumed)


def _shape(
    kind: ProtrusionKind, ring: Float, front: float, back: float
) -> tuple[Float, list[tuple[int, ...]], str]:
    """Vertices (n, 3) in wall axes, faces counter-clockwise from outside, what was assumed."""
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    deep, wide, high = back - front, x1 - x0, z1 - z0
    if kind is ProtrusionKind.BALCONY and high > SLAB + PARAPET and deep > 2 * PARAPET and wide > 3 * PARAPET:
        text = f"slab {SLAB:g} m, parapet {PARAPET:g} m thick"
        return (*_tray((x0, front, z0), (x1, back, z1)), text)
    if kind is ProtrusionKind.AWNING and high > 2 * CLOTH:
        section = np.array([[back, z1], [back, z1 - CLOTH], [front, z0], [front, z0 + CLOTH]])
        return (*_sheet(section, x0, x1), f"{CLOTH:g} m thick, straight from its upper to its front edge")
    return (*_block(ring, front, back), "")


def _block(ring: Float, front: float, back: float) -> tuple[Float, list[tuple[int, ...]]]:
    """An outline (x, z) between two depths."""
    ring = ring[np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1) > _SHORT]
    ring = ring if ring_area(ring) > 0 else ring[::-1]
    k = len(ring)
    xyz = np.concatenate([np.insert(ring, 1, y, axis=1) for y in (front, back)])
    sides = [((a + 1) % k, a, a + k, (a + 1) % k + k) for a in range(k)]
    return xyz, [tuple(range(k)), tuple(range(2 * k - 1, k - 1, -1)), *sides]


def _sheet(section: Float, x0: float, x1: float) -> tuple[Float, list[tuple[int, ...]]]:
    """A section (y, z) between two sides."""
    section = section if ring_area(section) > 0 else section[::-1]
    k = len(section)
    xyz = np.concatenate([np.insert(section, 0, x, axis=1) for x in (x0, x1)])
    sides = [(a, (a + 1) % k, (a + 1) % k + k, a + k) for a in range(k)]
    return xyz, [tuple(range(k))[::-1], tuple(range(k, 2 * k)), *sides]


def _tray(low: Sequence[float], high: Sequence[float]) -> tuple[Float, list[tuple[int, ...]]]:
    """A slab with a parapet along its front and its sides, open to the wall."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    a, b, c, floor = x0 + PARAPET, x1 - PARAPET, y0 + PARAPET, z0 + SLAB
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


def _kind_of(grid: Int, face: tuple[int, ...], kind: ProtrusionKind) -> str:
    up = float(normal(grid[list(face)] / GRID)[2])
    if abs(up) < _STEEP:
        return "WallSurface"
    return (
        "OuterCeilingSurface"
        if up < 0
        else "OuterFloorSurface"
        if kind is ProtrusionKind.BALCONY
        else "RoofSurface"
    )
