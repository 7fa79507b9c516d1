"""Draws the joinery within a frame: casements or sashes, posts, bars, cames, and a sheet for every pane."""

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.model.built import TrueBar, TrueLine
from frontage.simulate.houses.glazing import (
    LOWER_SASH_M,
    SASH_GLASS_M,
    STILE_M,
    UPPER_SASH_M,
)
from frontage.simulate.houses.palette import Palette
from frontage.simulate.meshing import Pen, inset
from frontage.simulate.scene import OpeningPlan, Part

SASHES_THICKNESS_M = 0.105  # of a frame that two sashes slide in
_SASH_M = 0.038  # thickness of a sash
_CASEMENT_M = (0.012, 0.055)  # front and back of casements, behind the front of their frame
_NARROW_THICKNESS_M = 0.024  # of glazing bars
_LEAST_PANE_M2 = 1e-4


def draw_joinery(pen: Pen, plan: OpeningPlan, palette: Palette, front: float) -> None:
    """Draw what a frame, whose front is at `front` (m, y), holds: all bars, stiles and panes of the plan."""
    light = inset(plan.ring, plan.frame_width)
    hole = shapely.Polygon(inset(plan.ring, plan.frame_width - STILE_M))
    stiles = hole.difference(shapely.Polygon(light))
    glass = shapely.Polygon(light)
    if plan.ajar:
        leaf = shapely.box(*plan.ajar[:4])
        stiles = stiles.difference(leaf.buffer(STILE_M, join_style="mitre", cap_style="square"))
        glass = glass.difference(leaf)
        _draw_open_leaf(pen, plan, palette, front)
    frame = pen.surface("casements", Part.FRAME, palette.frame)
    for part, y0, y1 in _planes(plan, hole):
        for piece in _polygons(stiles.intersection(part)):
            _block(pen, frame, piece, front + y0, front + y1)
    if plan.bars:
        bars = pen.surface("bars", Part.BAR, palette.frame)
        for k, bar in enumerate(plan.bars):
            _draw_bar(pen, bars, plan, bar, front + 0.0005 * (k % 5))
    if plan.lines:
        cames = pen.surface("lines", Part.BAR, palette.metal if plan.glazing == "leaded" else palette.frame)
        for k, line in enumerate(plan.lines):
            _draw_line(pen, cames, line, front + plan.glass_depth - plan.depth, 0.0002 * (k % 7))
    _draw_panes(pen, plan, palette, glass)


def _planes(plan: OpeningPlan, hole: shapely.Polygon) -> list[tuple[shapely.Polygon, float, float]]:
    """Returns the parts of a window with y (m) of the front and back of their stiles."""
    if plan.meeting is None:
        return [(hole, *_CASEMENT_M)]
    lower, upper = _halves(hole, plan.meeting)
    return [
        (upper, UPPER_SASH_M, UPPER_SASH_M + _SASH_M),
        (lower, LOWER_SASH_M, LOWER_SASH_M + _SASH_M),
    ]


def _halves(area: shapely.Polygon, z: float) -> tuple[shapely.Polygon, shapely.Polygon]:
    x0, z0, x1, z1 = area.bounds
    return area.intersection(shapely.box(x0, z0, x1, z)), area.intersection(shapely.box(x0, z, x1, z1))


def _draw_bar(pen: Pen, surface: int, plan: OpeningPlan, bar: TrueBar, front: float) -> None:
    """Draws a glazing bar; a post between casements with their stiles; or the two rails where sashes meet."""
    recess = 0.001 if bar.axis == "vertical" else 0.0014
    y0 = front + recess + bar.behind
    if plan.meeting is not None and bar.axis == "horizontal" and abs(bar.position - plan.meeting) < 1e-9:
        _box(pen, surface, bar, bar.width, y0, y0 + _SASH_M)
        _box(pen, surface, bar, bar.width, front + LOWER_SASH_M + recess, front + LOWER_SASH_M + _SASH_M)
    elif bar.behind > 0:
        _box(pen, surface, bar, bar.width, y0, y0 + _NARROW_THICKNESS_M)
    else:
        _box(pen, surface, bar, max(bar.width - 2 * STILE_M, 0.35 * bar.width), y0, y0 + 0.05)
        _box(pen, surface, bar, bar.width, y0 + _CASEMENT_M[0], front + _CASEMENT_M[1])


def _box(pen: Pen, surface: int, bar: TrueBar, width: float, y0: float, y1: float) -> None:
    across = (bar.position - width / 2, bar.position + width / 2)
    (x0, x1), (z0, z1) = (across, bar.extent) if bar.axis == "vertical" else (bar.extent, across)
    pen.box(surface, (x0, y0, z0), (x1, y1, z1))


def _draw_line(pen: Pen, surface: int, line: TrueLine, glass: float, lift: float) -> None:
    """Draws a straight strip on both sides of the glass, which is at y = `glass` (m)."""
    a, b = np.array(line.line)
    along = (b - a) / np.linalg.norm(b - a)
    side = np.array([-along[1], along[0]]) * line.width / 2
    thick = min(line.width, 0.02) / 2 + lift
    pen.block(surface, np.array([a - side, b - side, b + side, a + side]), glass - thick, glass + thick)


def _draw_open_leaf(pen: Pen, plan: OpeningPlan, palette: Palette, front: float) -> None:
    """Draws a casement that is turned inwards about its hinges: its stiles and its pane."""
    assert plan.ajar is not None
    x0, z0, x1, z1, turn = plan.ajar
    hinge = np.array([x0 if turn > 0 else x1, front + _CASEMENT_M[1], 0.0])
    c, s = np.cos(turn), np.sin(turn)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    frame = pen.local_from_frame
    turned = Rigid3(frame.frm, frame.frm, R, hinge - R @ hinge)
    own = pen.in_frame(frame.after(turned))
    leaf = rectangle(x0, z0, x1, z1)
    glass = inset(leaf, STILE_M)
    stiles = own.surface("open_casement", Part.FRAME, palette.frame)
    own.block(stiles, leaf, front + _CASEMENT_M[0], front + _CASEMENT_M[1], holes=[glass])
    own.plate(own.surface("open_pane", Part.PANE, palette.pane), glass, front + sum(_CASEMENT_M) / 2)


def _draw_panes(pen: Pen, plan: OpeningPlan, palette: Palette, light: shapely.Polygon) -> None:
    """Draws every pane as a sheet of its own, since each is tilted a little and mirrors something else."""
    cuts = [shapely.LineString(_axis(bar)).buffer(0.3 * bar.width, cap_style="flat") for bar in plan.bars]
    if plan.glazing == "radial":
        cuts += [shapely.LineString(line.line).buffer(0.3 * line.width) for line in plan.lines]
    glass = light.difference(shapely.union_all(cuts)) if cuts else light
    upper, lower = (plan.wall_y + plan.depth + d for d in SASH_GLASS_M)
    for k, piece in enumerate(_polygons(glass)):
        y = plan.wall_y + plan.glass_depth
        if plan.meeting is not None:
            y = lower if piece.centroid.y < plan.meeting else upper
        surface = pen.surface(f"pane{k + 1}", Part.PANE, palette.pane)
        ring, holes = _rings(piece)
        pen.plate(surface, ring, y, holes)


def _axis(bar: TrueBar) -> list[tuple[float, float]]:
    """Returns the centre line of a bar, a little longer, so that it reaches into what stops it."""
    low, high = bar.extent[0] - 0.01, bar.extent[1] + 0.01
    p = bar.position
    return [(p, low), (p, high)] if bar.axis == "vertical" else [(low, p), (high, p)]


def _block(pen: Pen, surface: int, piece: shapely.Polygon, y0: float, y1: float) -> None:
    ring, holes = _rings(piece)
    pen.block(surface, ring, y0, y1, holes=holes)


def _rings(piece: shapely.Polygon) -> tuple[Float, list[Float]]:
    """Returns the outline (k, 2) and the holes of a polygon, all of them counter-clockwise."""
    turned = shapely.geometry.polygon.orient(piece)
    holes = [np.asarray(h.coords)[:-1][::-1] for h in turned.interiors]
    return np.asarray(turned.exterior.coords)[:-1], holes


def _polygons(shape: shapely.Geometry) -> list[shapely.Polygon]:
    parts = shapely.get_parts(shape)
    return [p for p in parts if isinstance(p, shapely.Polygon) and p.area > _LEAST_PANE_M2]
