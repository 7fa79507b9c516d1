"""Draws an opening: reveal, frame, bars, pane or leaf, shutters, and the inner reveal up to the room."""

from frontage.geometry.arrays import Float
from frontage.geometry.ring import at_depth, rectangle
from frontage.model.glazing import FRAME_THICKNESS_M
from frontage.simulate.houses.elevation import Dressing
from frontage.simulate.houses.glazing import STILE_M
from frontage.simulate.houses.interiors import draw_curtain, draw_things
from frontage.simulate.houses.joinery import SASHES_THICKNESS_M, draw_joinery
from frontage.simulate.houses.palette import Palette
from frontage.simulate.meshing import Pen, band, inset
from frontage.simulate.scene import OpeningPlan, Part

LEAF_BEHIND_M = 0.02  # from the front of a frame back to its opaque leaf


def draw_opening(pen: Pen, plan: OpeningPlan, dressing: Dressing, palette: Palette, inner_y: float) -> None:
    """Draw one opening; a glazed one is continued to the front of the room at `inner_y` (m, facade frame)."""
    front = plan.wall_y + plan.depth
    projection = dressing.surround[1] if dressing.surround else 0.0
    reveal = pen.surface("reveal", Part.REVEAL, palette.reveal, u=(0.0, 1.0, 0.0))
    pen.strip(reveal, plan.ring, plan.wall_y, front)
    if projection:
        surround = pen.surface("surround_reveal", Part.REVEAL, palette.trim, u=(0.0, 1.0, 0.0))
        pen.strip(surround, plan.ring, plan.wall_y - projection, plan.wall_y)
    if plan.shutters == "closed":
        shutter = pen.surface("shutter", Part.SHUTTER, palette.shutter)
        pen.block(shutter, plan.ring, plan.wall_y + 0.01, plan.wall_y + 0.04)
    back = front + (FRAME_THICKNESS_M if plan.meeting is None else SASHES_THICKNESS_M)
    stile = STILE_M if dressing.joinery and plan.glazed else 0.0
    light = _draw_frame(pen, plan, palette, front, back, stile)
    if not plan.glazed:
        _draw_leaf(pen, light, front + LEAF_BEHIND_M, dressing.leaf, palette)
        return
    if dressing.joinery:
        draw_joinery(pen, plan, palette, front)
    else:
        pane = pen.surface("pane", Part.PANE, palette.pane)
        pen.plate(pane, light, plan.wall_y + plan.glass_depth)
        _draw_bars(pen, plan, palette, front, back)
    inner = pen.surface("inner_reveal", Part.ROOM, palette.room, u=(0.0, 1.0, 0.0))
    far = inset(plan.ring, -dressing.flare) if dressing.flare else plan.ring
    xyz, corners = band(at_depth(plan.ring, back), at_depth(far, max(inner_y, back)))
    pen.triangles(inner, xyz, corners)
    draw_curtain(pen, plan, dressing, palette, back + 0.03)
    draw_things(pen, plan, dressing, palette, back + 0.05)


def inner_ring(plan: OpeningPlan, dressing: Dressing) -> Float:
    """Return the outline (k, 2) m of the hole that an opening needs in the room's wall."""
    return inset(plan.ring, -dressing.flare) if dressing.flare else plan.ring


def _draw_frame(
    pen: Pen, plan: OpeningPlan, palette: Palette, front: float, back: float, stile: float
) -> Float:
    """Draws the frame up to the stiles of its casements or sashes, and returns its inner outline."""
    light = inset(plan.ring, plan.frame_width - stile)
    frame = pen.surface("frame", Part.FRAME, palette.frame if plan.glazed else palette.leaf)
    pen.triangles(frame, *band(at_depth(plan.ring, front), at_depth(light, front)))
    pen.strip(frame, light, front, back)
    xyz, corners = band(at_depth(plan.ring, back), at_depth(light, back))
    pen.triangles(frame, xyz, corners[:, ::-1])
    return light


def _draw_bars(pen: Pen, plan: OpeningPlan, palette: Palette, front: float, back: float) -> None:
    if not plan.bars:
        return
    surface = pen.surface("bars", Part.BAR, palette.frame)
    for bar in plan.bars:
        across = (bar.position - bar.width / 2, bar.position + bar.width / 2)
        (x0, x1), (z0, z1) = (across, bar.extent) if bar.axis == "vertical" else (bar.extent, across)
        # uprights stand a millimetre further out, so that no two faces share a plane
        recess = 0.003 if bar.axis == "vertical" else 0.004
        pen.box(surface, (x0, front + recess, z0), (x1, back - recess, z1))


def _draw_leaf(pen: Pen, light: Float, y: float, style: str, palette: Palette) -> None:
    """Draws an opaque leaf: boards with joints, horizontal ribs, or raised panels in two columns."""
    surface = pen.surface("leaf", Part.LEAF, palette.leaf)
    pen.plate(surface, light, y)
    (x0, z0), (x1, _) = light.min(0), light.max(0)
    top = float(light[:, 1].max()) if len(light) == 4 else float(light[2, 1])
    w, h = x1 - x0, top - z0
    if style == "ribs":
        count = max(3, int(h / 0.45))
        cells = [(x0, z0 + h * k / count + 0.012, x1, z0 + h * (k + 1) / count) for k in range(count)]
    elif style == "boards":
        count = max(3, int(w / 0.16))
        cells = [(x0 + w * k / count + 0.006, z0, x0 + w * (k + 1) / count, top) for k in range(count)]
    else:
        rows, columns = ((0.06, 0.4), (0.46, 0.94)), ((0.09, 0.46), (0.54, 0.91))
        cells = [(x0 + w * a, z0 + h * c, x0 + w * b, z0 + h * d) for a, b in columns for c, d in rows]
    for cell in cells:
        pen.block(surface, rectangle(*cell), y - 0.012, y, back=False)
