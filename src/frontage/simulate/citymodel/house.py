"""Draws a building of a city model: its faces, its openings with what models lack, and its plan."""

from dataclasses import replace

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.geometry.ring import polygon_ring
from frontage.model import Surface
from frontage.model.glazing import FRAME_THICKNESS_M
from frontage.simulate.citymodel.draft import ModelDraft, ModelFacade
from frontage.simulate.citymodel.openings import KINDS, ModelOpening, frame_fits
from frontage.simulate.citymodel.room import REACH_M, RoomPlace, draw_room
from frontage.simulate.citymodel.walls import area_vector, flat_polygon, in_plan, plane_frame, polygons
from frontage.simulate.houses.elevation import Dressing
from frontage.simulate.houses.palette import Palette, draw_palette
from frontage.simulate.houses.shapes import SHAPES, BarLayout, opening_ring, plan_bars
from frontage.simulate.houses.style import GLASS_BEHIND_M, draw_bars
from frontage.simulate.houses.windows import draw_opening
from frontage.simulate.meshing import Pen, band, triangulate
from frontage.simulate.scene import FacadePlan, House, OpeningPlan, Part, SurfaceMaterial

_STOREY_M = 3.0  # height by which openings are numbered
_GATE_M = 2.1  # wider doors are garage doors
_ROUGHNESS_M = (0.0005, 0.003)  # range of the standard deviation of walls
_WALL_M = 0.3  # least thickness of a wall


def draw_model_house(pen: Pen, draft: ModelDraft, side: int, foot: float, rng: np.random.Generator) -> House:
    """Draw a building with a pen in the local frame, and return its plan.

    Materials and window frames are drawn from `rng`. Walls are carried down to the height `foot` (m local).
    """
    palette = draw_palette(rng)
    bars, reveal = draw_bars(rng), float(0.05 + 0.25 * rng.beta(1.3, 2.4))
    frame_width, rough = float(rng.uniform(0.05, 0.08)), float(rng.uniform(*_ROUGHNESS_M))
    facades = []
    for k, facade in enumerate(draft.facades):
        name = f"{draft.id}/F{k + 1}"
        plans = [
            _plan(f"{name}/W{n + 1}", o, reveal, frame_width, bars) for n, o in enumerate(facade.openings)
        ]
        floor = draft.base - float(draft.frame(facade).t[2])
        plans = [_numbered(p, floor, facade) for p in plans]
        plan = FacadePlan(name, draft.frame(facade), facade.outline, tuple(plans), facade.protrusions, rough)
        _draw_facade(pen.with_prefix(name, facade=k), draft, facade, plan, palette=palette, rng=rng)
        facades.append(plan)
    _draw_rest(pen, draft, palette, rough, foot)
    return _house(draft, side, tuple(facades))


def _plan(id: str, found: ModelOpening, reveal: float, frame: float, layout: BarLayout) -> OpeningPlan:
    """Plans an opening; whatever the model leaves out is as in the rest of the house."""
    width, height = np.ptp(found.ring, axis=0)
    depth = reveal if found.depth is None else found.depth
    kind = "window" if found.kind == "Window" else "garage" if width > _GATE_M else "door"
    frame = min(frame, 0.15 * float(min(width, height)))
    while not frame_fits(found.ring, frame):
        frame *= 0.8
    if found.bars is not None:
        layout = BarLayout("grid", *found.bars, min(layout.main, 0.06), layout.thin)
    elif min(width, height) < 0.5:
        layout = BarLayout()
    glazed = kind == "window"
    bars = plan_bars(found.ring, frame, layout) if glazed else ()
    glass = depth + GLASS_BEHIND_M if found.glass is None else found.glass
    return OpeningPlan(
        id, kind, _shape(found.ring), found.ring, 0.0, depth, bars, "none", glazed, glass, frame
    )  # fmt: skip


def _shape(ring: Float) -> str:
    """Returns the known shape whose area differs least from that of a ring."""
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    spring = max(float(ring[np.abs(ring[:, 0] - x) < 0.02, 1].max()) for x in (x0, x1))
    polygon = shapely.Polygon(ring)
    off: dict[str, float] = {}
    for shape in SHAPES:
        if shape == "circle" and abs(x1 - x0 - z1 + z0) > 0.02:
            continue
        if shape == "segmental" and not 0.02 < z1 - spring < 0.49 * (x1 - x0):
            continue
        if shape == "triangular" and z1 - spring < 0.02:
            continue
        try:
            ideal = opening_ring(shape, x0, z0, x1 - x0, z1 - z0, rise=z1 - spring)
        except ValueError:
            continue
        off[shape] = polygon.symmetric_difference(shapely.Polygon(ideal)).area
    return min(off, key=lambda s: off[s])


def _numbered(plan: OpeningPlan, floor: float, facade: ModelFacade) -> OpeningPlan:
    """Numbers an opening: its storey above `floor` (m, facade frame), and its place in it from the left."""

    def storey(ring: Float) -> int:
        return max(0, int((float(ring[:, 1].mean()) - floor) / _STOREY_M))

    level = storey(plan.ring)
    left = [o for o in facade.openings if storey(o.ring) == level and o.ring[0, 0] < plan.ring[0, 0]]
    return replace(plan, floor=level, bay=len(left))


def _draw_facade(
    pen: Pen,
    draft: ModelDraft,
    facade: ModelFacade,
    plan: FacadePlan,
    *,
    palette: Palette,
    rng: np.random.Generator,
) -> None:
    """Draws the wall of a facade with its openings, each glazed one with a room behind it."""
    own = pen.in_frame(draft.frame(facade))
    holes = [shapely.Polygon(p.ring) for p in plan.openings]
    area = draft.walls[facade.wall].area(draft.gone).difference(shapely.union_all(holes))
    _draw_area(own, own.surface("wall", Part.WALL, palette.wall, roughness=plan.roughness), area)
    house = in_plan(draft.footprint, own.local_from_frame)
    air = own.local_from_frame.inverse.apply(draft.outdoors)
    air = air[(air[:, 1] > 0.0) & (air[:, 1] < REACH_M)]
    for k, opening in enumerate(plan.openings):
        curtain = str(rng.choice(["none", "sides", "net", "blind"], p=[0.4, 0.3, 0.2, 0.1]))
        leaf = "ribs" if opening.kind == "garage" else "panels"
        dressing = Dressing(curtain=curtain, share=float(rng.uniform(0.1, 0.5)), leaf=leaf)
        inner = max(_WALL_M, opening.depth + FRAME_THICKNESS_M + 0.1)
        piece = own.with_prefix(opening.id, opening=k)
        draw_opening(piece, opening, dressing, palette, inner)
        if opening.glazed:
            others = tuple(p.ring for p in plan.openings if p is not opening)
            draw_room(piece, RoomPlace(opening.ring, others, house, air, inner), palette, rng)


def _draw_area(pen: Pen, surface: int, area: shapely.Geometry) -> None:
    """Draws polygons with holes in the plane y = 0."""
    for part in polygons(area):
        pen.plate(surface, polygon_ring(part), 0.0, [np.asarray(h.coords)[:-1] for h in part.interiors])


def _draw_rest(pen: Pen, draft: ModelDraft, palette: Palette, rough: float, foot: float) -> None:
    """Draws walls that are no facades, roofs, installations, and skirts that reach down to the ground."""
    fronts = {f.wall for f in draft.facades}
    used = set(draft.gone) | {k for wall in draft.walls for k in wall.pieces}
    for number, wall in enumerate(draft.walls):
        area = wall.area(draft.gone)
        if number not in fronts and not area.is_empty:
            own = pen.in_frame(wall.local_from_wall)
            _draw_area(own, own.surface(f"wall{number + 1}", Part.WALL, palette.wall, roughness=rough), area)
    known: dict[tuple[object, ...], int] = {}
    for k, face in enumerate(draft.faces):
        if k not in used:
            _draw_face(pen, face, *_part_and_material(face, palette), known)
    fixed = {"RoofSurface": palette.roof}
    for fixture in draft.fixtures:
        for face in fixture:
            part, material = _part_and_material(face, palette)
            if face.semantics not in KINDS:
                part, material = Part.BALCONY, fixed.get(face.semantics, palette.trim)
            _draw_face(pen, face, part, material, known)
    skirt = pen.surface("skirt", Part.PLINTH, palette.plinth)
    for face in draft.faces:
        if face.semantics == "GroundSurface":
            low = face.ring * [1, 1, 0] + [0, 0, min(foot, float(face.ring[:, 2].min()))]
            pen.triangles(skirt, *band(face.ring, low))


def _part_and_material(face: Surface, palette: Palette) -> tuple[Part, SurfaceMaterial]:
    return {
        "RoofSurface": (Part.ROOF, palette.roof),
        "Window": (Part.PANE, palette.pane),
        "Door": (Part.LEAF, palette.leaf),
        "GroundSurface": (Part.PLINTH, palette.plinth),
    }.get(face.semantics, (Part.WALL, palette.wall))


def _draw_face(
    pen: Pen, face: Surface, part: Part, material: SurfaceMaterial, known: dict[tuple[object, ...], int]
) -> None:
    """Draws a face as it is in the model; faces of one part that face the same way share a surface."""
    normal = area_vector(face.ring)
    if np.linalg.norm(normal) < 1e-6:
        return
    frame = plane_frame(normal, face.ring[0])
    own = pen.in_frame(frame)
    key = (part, material, *np.round(normal / np.linalg.norm(normal), 1).tolist())
    if key not in known:
        known[key] = own.surface(f"{part.name.lower()}{len(known) + 1}", part, material)
    rings = [frame.inverse.apply(r) for r in (face.ring, *face.holes)]
    try:
        _, corners = triangulate(rings[0][:, [0, 2]], [r[:, [0, 2]] for r in rings[1:]])
    except (ValueError, KeyError):  # crossing rings are repaired in their plane
        _draw_area(own, known[key], flat_polygon(face, frame))
        return
    own.triangles(known[key], np.concatenate(rings), corners)


def _house(draft: ModelDraft, side: int, facades: tuple[FacadePlan, ...]) -> House:
    """Returns the plan; its shell holds the facades in their order, then the other faces of the body."""
    shell: list[tuple[str, Float]] = []
    for facade in draft.facades:
        whole = max(polygons(draft.walls[facade.wall].area(draft.gone)), key=lambda p: float(p.area))
        xz = polygon_ring(whole)
        shell.append(("WallSurface", draft.frame(facade).apply(np.insert(xz, 1, 0.0, axis=1))))
    drawn = {k for f in draft.facades for k in draft.walls[f.wall].pieces} | set(draft.gone)
    shell += [
        (f.semantics if f.semantics in ("RoofSurface", "GroundSurface") else "WallSurface", f.ring)
        for k, f in enumerate(draft.faces)
        if k not in drawn and f.semantics not in KINDS
    ]
    foot = polygon_ring(max(polygons(draft.footprint), key=lambda p: float(p.area)))
    if all(semantics != "GroundSurface" for semantics, _ in shell):
        shell.append(("GroundSurface", np.column_stack([foot, np.full(len(foot), draft.base)])[::-1]))
    top = max(float(f.ring[:, 2].max()) for f in draft.faces)
    roofs = [f.ring[:, 2].min() for f in draft.faces if f.semantics == "RoofSurface" and _size(f) > 2.0]
    eaves = max(min(map(float, roofs), default=top), draft.base + 1.0)
    return House(draft.id, draft.address, side, foot, draft.base, eaves, top, facades, tuple(shell))


def _size(face: Surface) -> float:
    return float(np.linalg.norm(area_vector(face.ring)))
