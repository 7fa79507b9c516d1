"""An opening as geometry: reveal, frame, bars, pane or leaf, and the way to the room behind."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.ring import rectangle
from frontage.simulate.meshing import Pen, band, inset
from frontage.simulate.scene import Material, OpeningPlan, Part

FRAME_THICKNESS = 0.065  # m, usual depth of a window frame


@dataclass(frozen=True)
class OpeningMaterials:
    """What the parts of an opening are made of."""

    reveal: Material
    frame: Material
    pane: Material
    leaf: Material
    shutter: Material


def draw_opening(pen: Pen, plan: OpeningPlan, materials: OpeningMaterials, inner_y: float) -> None:
    """Draw one opening; glazed ones are continued to the room's front at `inner_y` (m, facade frame)."""
    depth = plan.wall_y + plan.depth
    reveal = pen.surface("reveal", Part.REVEAL, materials.reveal, u=(0.0, 1.0, 0.0))
    pen.strip(reveal, plan.ring, plan.wall_y, depth)
    if not plan.glazed:
        leaf = pen.surface("leaf", Part.LEAF, materials.leaf)
        pen.plate(leaf, plan.ring, depth)
        return
    back = depth + FRAME_THICKNESS
    _draw_frame(pen, plan, materials, depth, back)
    inner = pen.surface("inner_reveal", Part.ROOM, materials.reveal, u=(0.0, 1.0, 0.0))
    pen.strip(inner, plan.ring, back, max(inner_y, back))


def _draw_frame(pen: Pen, plan: OpeningPlan, materials: OpeningMaterials, depth: float, back: float) -> None:
    light = inset(plan.ring, plan.frame_width)
    frame = pen.surface("frame", Part.FRAME, materials.frame)
    _rim(pen, frame, plan.ring, light, depth)
    pen.strip(frame, light, depth, back)
    _rim(pen, frame, plan.ring, light, back, inward=True)
    pane = pen.surface("pane", Part.PANE, materials.pane)
    pen.plate(pane, light, plan.wall_y + plan.glass_depth)
    if plan.bars:
        surface = pen.surface("bars", Part.BAR, materials.frame)
        for bar in plan.bars:
            half, (low, high) = bar.width / 2, bar.extent
            across = (bar.position - half, bar.position + half)
            (x0, x1), (z0, z1) = (across, (low, high)) if bar.axis == "vertical" else ((low, high), across)
            pen.block(surface, rectangle(x0, z0, x1, z1), depth + 0.004, back - 0.004)


def _rim(pen: Pen, surface: int, outer: Float, inner: Float, y: float, inward: bool = False) -> None:
    rings = [np.column_stack([r[:, 0], np.full(len(r), y), r[:, 1]]) for r in (outer, inner)]
    xyz, corners = band(*rings)
    pen.triangles(surface, xyz, corners[:, ::-1] if inward else corners)
