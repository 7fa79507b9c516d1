"""Draws what stands behind the panes of a window: curtains, blinds, and things on the sill."""

import numpy as np

from frontage.simulate.houses.elevation import Dressing
from frontage.simulate.houses.palette import Palette
from frontage.simulate.meshing import Pen
from frontage.simulate.scene import OpeningPlan, Part

_SLAT_M = 0.026  # width of the slats of a venetian blind
_SLAT_TURN = np.radians(35.0)


def draw_curtain(pen: Pen, plan: OpeningPlan, dressing: Dressing, palette: Palette, y: float) -> None:
    """Draw a strip of fabric on each side, a net over all or the lower part, or a blind from above."""
    if dressing.curtain == "none":
        return
    (x0, z0), (x1, z1) = plan.ring.min(0), plan.ring.max(0)
    width, height, share = x1 - x0, z1 - z0, dressing.share
    surface = pen.surface("curtain", Part.ROOM, palette.curtain)
    if dressing.curtain == "venetian":
        _draw_slats(pen, surface, (x0, z1 - height * share, x1, z1), y)
        return
    if dressing.curtain == "blind":
        cells = [(x0, z1 - height * share, x1, z1)]
    elif dressing.curtain == "net":
        cells = [(x0, z0 + 0.02, x1, z1)]
    elif dressing.curtain == "cafe":
        cells = [(x0, z0 + 0.02, x1, z0 + height * max(0.3, min(share, 0.6)))]
    else:
        part = width * min(share, 0.45)
        cells = [(x0, z0, x0 + part, z1), (x1 - part, z0, x1, z1)]
    for cell in cells:
        _draw_fabric(pen, surface, cell, y, dressing.curtain != "blind")


def draw_things(pen: Pen, plan: OpeningPlan, dressing: Dressing, palette: Palette, y: float) -> None:
    """Draw the things on the sill: pots, boxes, books, as high and wide as the dressing says."""
    (x0, z0), (x1, _) = plan.ring.min(0), plan.ring.max(0)
    for k, (share, width, height, name) in enumerate(dressing.things):
        surface = pen.surface(f"thing{k + 1}", Part.ROOM, getattr(palette, name))
        x = x0 + (x1 - x0 - width) * share
        pen.box(surface, (x, y, z0 + 0.005), (x + width, y + min(width, 0.15), z0 + height))


def _draw_slats(pen: Pen, surface: int, cell: tuple[float, float, float, float], y: float) -> None:
    """Draws the tilted slats of a venetian blind, and the rail that they hang from."""
    x0, z0, x1, z1 = cell
    z = np.arange(z0, z1 - 0.03, 0.86 * _SLAT_M)
    rise, run = _SLAT_M * np.sin(_SLAT_TURN), _SLAT_M * np.cos(_SLAT_TURN)
    quads = np.stack(
        [
            np.column_stack([np.full(len(z), x), np.full(len(z), yy), z + dz])
            for x, yy, dz in ((x0, y, 0.0), (x1, y, 0.0), (x1, y + run, rise), (x0, y + run, rise))
        ],
        axis=1,
    )
    corners = (4 * np.arange(len(z))[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)
    pen.triangles(surface, quads.reshape(-1, 3), corners)
    pen.box(surface, (x0, y, z1 - 0.03), (x1, y + run, z1))


def _draw_fabric(
    pen: Pen, surface: int, cell: tuple[float, float, float, float], y: float, wavy: bool
) -> None:
    x0, z0, x1, z1 = cell
    count = max(2, int((x1 - x0) / 0.04)) if wavy else 2
    x = np.linspace(x0, x1, count)
    depth = y + (0.012 * np.sin(np.arange(count) * 1.9) + 0.012 if wavy else np.zeros(count))
    low = np.column_stack([x, depth, np.full(count, z0)])
    high = np.column_stack([x, depth, np.full(count, z1)])
    a = np.arange(count - 1)
    corners = np.concatenate(
        [np.column_stack([a, a + 1, a + 1 + count]), np.column_stack([a, a + 1 + count, a + count])]
    )
    pen.triangles(surface, np.concatenate([low, high]), corners)
