"""Roofs over the shell: slopes, eaves, dormers, chimneys."""

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.simulate.houses.draft import HouseDraft
from frontage.simulate.houses.elevation import Dressing, placement_problems
from frontage.simulate.houses.shell import MANSARD_M, shell_faces
from frontage.simulate.houses.style import Style, WindowType
from frontage.simulate.houses.windows import draw_opening
from frontage.simulate.meshing import Pen
from frontage.simulate.scene import Part, ProtrusionPlan


def draw_roof(
    pen: Pen, draft: HouseDraft, style: Style, rng: np.random.Generator
) -> tuple[ProtrusionPlan, ...]:
    """Draw the roof in the house's frame, and return its dormers as protrusions of the front."""
    roof = pen.surface("roof", Part.ROOF, draft.palette.roof, v=(0.0, 0.7, 0.7))
    dormers = _place_dormers(draft, style, rng) if style.dormers else []
    for k, face in enumerate(f for f in shell_faces(draft) if f.semantics == "RoofSurface"):
        if dormers and k == _front_slope(draft):
            _draw_slope(pen, roof, draft, face.ring, dormers)
        else:
            pen.polygon(roof, face.ring)
    if draft.roof in ("gable", "mansard", "hip"):
        _draw_eaves(pen, draft, float(rng.uniform(0.12, 0.42)))
    plans = [
        _draw_dormer(pen.with_prefix(f"{pen.prefix}/dormer{k + 1}"), draft, d, style)
        for k, d in enumerate(dormers)
    ]
    if draft.roof != "flat" and rng.random() < 0.7:
        _draw_chimney(pen, draft, rng)
    return tuple(plans)


def _slope(draft: HouseDraft) -> tuple[float, float]:
    """Returns run and rise (m) of the slope above the front's eaves."""
    return MANSARD_M if draft.roof == "mansard" else (draft.depth / 2, draft.rise)


def _front_slope(draft: HouseDraft) -> int:
    return 3 if draft.roof == "mansard" else 1


def _place_dormers(
    draft: HouseDraft, style: Style, rng: np.random.Generator
) -> list[tuple[float, float, float]]:
    """Draws the dormers: left edge, right edge and distance behind the front's plane of each, m."""
    if draft.roof not in ("gable", "mansard"):
        return []
    width = float(rng.uniform(1.3, 1.8))
    count = int(rng.integers(1, max(2, int(draft.width // (width + 1.2)) + 1)))
    pitch = draft.width / count
    if pitch < width + 0.6:
        return []
    back = 0.25 if draft.roof == "mansard" else float(rng.uniform(0.5, 1.2))
    return [(pitch * (k + 0.5) - width / 2, pitch * (k + 0.5) + width / 2, back) for k in range(count)]


def _dormer_levels(draft: HouseDraft, back: float) -> tuple[float, float, float]:
    """Returns foot and top of a dormer's front, and how far back its flat top meets the slope; m."""
    run, rise = _slope(draft)
    foot = draft.eaves + rise * back / run
    top = min(foot + 1.65, draft.eaves + rise * 0.92)
    return foot, top, (top - draft.eaves) * run / rise


def _draw_slope(
    pen: Pen, surface: int, draft: HouseDraft, ring: Float, dormers: list[tuple[float, float, float]]
) -> None:
    """Draws the front slope with holes where dormers stand."""
    run, rise = _slope(draft)
    length = float(np.hypot(run, rise))
    up = np.array([0.0, run, rise]) / length
    frame = Rigid3("house", "slope", np.column_stack([[1.0, 0, 0], np.cross(up, [1.0, 0, 0]), up]), ring[1])
    shift = frame.inverse.apply(ring)
    holes = []
    for x0, x1, back in dormers:
        far = _dormer_levels(draft, back)[2]
        holes.append(
            rectangle(x0 + 0.02, (back + 0.02) * length / run, x1 - 0.02, (far - 0.05) * length / run)
        )
    xz = shift[:, [0, 2]]
    pen.in_frame(pen.local_from_frame @ frame).plate(surface, xz[::-1] if _clockwise(xz) else xz, 0.0, holes)


def _clockwise(ring: Float) -> bool:
    x, z = ring.T
    return float(x @ np.roll(z, -1) - z @ np.roll(x, -1)) < 0


def _draw_dormer(
    pen: Pen, draft: HouseDraft, dormer: tuple[float, float, float], style: Style
) -> ProtrusionPlan:
    x0, x1, y = dormer
    foot, top, far = _dormer_levels(draft, y)
    kind = WindowType(
        "window", "rectangle", x1 - x0 - 0.4, min(top - foot - 0.5, 1.3), 0.08, 0.06, style.upper.bars
    )
    window = kind.place(f"{pen.prefix}/window", x0 + 0.2, foot + 0.3, floor=draft.floors, bay=1, wall_y=y)
    front = rectangle(x0, foot, x1, top)
    wall = pen.surface("wall", Part.DORMER, draft.palette.wall)
    fits = not placement_problems([window.ring], [front])[0]
    pen.plate(wall, front, y, [window.ring] if fits else [])
    if fits:
        draw_opening(pen.with_prefix(window.id), window, Dressing(), draft.palette, y + 0.3)
    for x, flip in ((x0, False), (x1, True)):
        cheek = np.array([[x, y, foot], [x, y, top], [x, far, top]])
        pen.polygon(wall, cheek[::-1] if flip else cheek)
    cover = pen.surface("roof", Part.DORMER, draft.palette.metal)
    pen.box(cover, (x0 - 0.1, y - 0.15, top), (x1 + 0.1, far + 0.1, top + 0.08))
    return ProtrusionPlan(pen.prefix, "dormer", front, (y - 0.15, far))


def _draw_eaves(pen: Pen, draft: HouseDraft, overhang: float) -> None:
    """Draws the overhang of the slope in front of the wall, with a gutter."""
    run, rise = _slope(draft)
    drop = min(overhang * rise / run, 0.2)  # steep roofs flatten there, so that the top windows stay free
    e = draft.eaves
    profile = np.array([[0.0, e], [-overhang, e - drop], [-overhang, e - drop - 0.1], [0.0, e - 0.12]])
    _beam(pen, pen.surface("eaves", Part.ROOF, draft.palette.roof), profile, 0.0, draft.width)
    low = e - drop - 0.13
    pen.box(
        pen.surface("gutter", Part.ROOF, draft.palette.metal),
        (0.0, -overhang - 0.12, low),
        (draft.width, -overhang, low + 0.12),
    )


def _beam(pen: Pen, surface: int, profile: Float, x0: float, x1: float) -> None:
    """Draws a profile (k, 2) m (y, z), clockwise as seen from the right, extruded along x."""
    near = np.column_stack([np.full(len(profile), x0), profile])
    far = near + np.array([x1 - x0, 0.0, 0.0])
    for k in range(len(profile)):
        j = (k + 1) % len(profile)
        pen.polygon(surface, np.array([near[k], far[k], far[j], near[j]])[::-1])
    pen.polygon(surface, near[::-1])
    pen.polygon(surface, far)


def _draw_chimney(pen: Pen, draft: HouseDraft, rng: np.random.Generator) -> None:
    x = float(rng.uniform(0.15, 0.85)) * draft.width
    x = draft.width / 2 if draft.roof == "street_gable" else min(max(x, 0.5), draft.width - 0.5)
    y = draft.depth / 2
    surface = pen.surface("chimney", Part.CHIMNEY, draft.palette.wall)
    pen.box(surface, (x - 0.4, y - 0.3, draft.ridge - 1.2), (x + 0.4, y + 0.3, draft.ridge + 1.0))
