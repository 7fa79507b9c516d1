"""Composes the elevations of a house: outline, layout, names of the openings, bands."""

import numpy as np
import shapely

from frontage.errors import OptionError
from frontage.geometry.arrays import Float
from frontage.geometry.ring import rectangle
from frontage.model import DOORS
from frontage.simulate.houses.draft import HouseDraft
from frontage.simulate.houses.elevation import Band, Dressing, Elevation, check_placements
from frontage.simulate.houses.housespec import OpeningSpec
from frontage.simulate.houses.layout import Layout, lay_out_front, lay_out_side
from frontage.simulate.houses.placements import PlacedOpening, name_openings, without_collisions
from frontage.simulate.houses.shapes import BarLayout
from frontage.simulate.houses.shell import front_outline, house_from_side
from frontage.simulate.houses.style import Style, WindowType
from frontage.simulate.houses.varied import vary
from frontage.simulate.scene import Part


def compose_elevations(
    draft: HouseDraft, style: Style, id: str, rng: np.random.Generator
) -> tuple[Elevation, ...]:
    """Return the front of a house and, for a detached house, those other sides that have openings.

    Raises OptionError when openings of the specification leave the wall, overlap or do not fit.
    """
    outline = front_outline(draft, 0)
    if draft.spec.opening:
        layout = _specified_layout(draft, outline, id)
    else:
        layout = lay_out_front(draft, style, outline, id, rng)
    sides = [_elevation(draft, 0, f"{id}/F1", outline=outline, layout=layout, rng=rng)]
    for side in range(1, 4) if draft.detached else ():
        outline = front_outline(draft, side)
        layout = lay_out_side(draft, style, outline, id, rng)
        if layout.placements:
            name = f"{id}/F{side + 1}"
            sides.append(_elevation(draft, side, name, outline=outline, layout=layout, rng=rng))
    return tuple(sides)


def _specified_layout(draft: HouseDraft, outline: Float, id: str) -> Layout:
    """Returns the openings that the specification places; raises OptionError where they do not fit."""
    placements = [_specified(o) for o in draft.spec.opening]
    check_placements([s.ring for s in placements], outline, f"house {id}")
    kept = without_collisions(placements)
    for k, (asked, free) in enumerate(zip(placements, kept, strict=True)):
        if asked.shutters != free.shutters:
            raise OptionError(
                f"house {id}: the open shutters of opening {k + 1} cover a neighbour; close them"
            )
    return Layout(tuple(kept))


def _specified(spec: OpeningSpec) -> PlacedOpening:
    bars = BarLayout(spec.bars, spec.vertical, spec.horizontal)
    kind = WindowType(
        spec.kind, spec.shape, spec.width, spec.height, spec.depth, spec.frame, bars, None,
        Dressing(leaf="ribs" if spec.kind == "garage" else "panels"), spec.kind not in DOORS,
    )  # fmt: skip
    floor = -1 if spec.kind == "basement" else 0
    return PlacedOpening(kind, spec.x, spec.z, floor, 0.0, spec.shutters)


def _elevation(
    draft: HouseDraft, side: int, id: str, *, outline: Float, layout: Layout, rng: np.random.Generator
) -> Elevation:
    placements = (
        tuple(_on_storey(s, draft) for s in layout.placements) if draft.spec.opening else layout.placements
    )
    if draft.spec.windows == "varied":
        placements = vary(placements, draft, id)
    openings, dressings = name_openings(id, placements)
    cut = [shapely.Polygon(o.ring) for o in openings] + [shapely.Polygon(o.ring) for o in layout.oriels]
    bands = _bands(draft, side, outline, shapely.union_all(cut), rng)
    return Elevation(
        id, house_from_side(draft, side), outline, openings, dressings, bands, layout.balconies, layout.oriels
    )


def _on_storey(placement: PlacedOpening, draft: HouseDraft) -> PlacedOpening:
    """Numbers the storey of an opening that the specification placed."""
    if placement.floor < 0:
        return placement
    middle = placement.z + placement.type.height / 2
    floor = sum(middle >= draft.level(k) - 0.3 for k in range(1, draft.floors))
    return PlacedOpening(
        placement.type,
        placement.x,
        placement.z,
        floor + int(middle > draft.eaves),
        placement.wall_y,
        placement.shutters,
    )


def _bands(
    draft: HouseDraft, side: int, outline: Float, cut: shapely.Geometry, rng: np.random.Generator
) -> tuple[Band, ...]:
    """Draws plinth, string courses, cornice and corner pilasters, cut out where openings are.

    `cut` is the union of the openings' outlines.
    """
    width = float(np.ptp(outline[:, 0]))
    wall = shapely.Polygon(outline)
    found: list[tuple[str, Part, Float, float]] = []
    if draft.palette.ground_floor is not draft.palette.wall and draft.floors > 1:
        top = draft.level(1) - 0.35  # a ground floor of cut stone stands out a little
        found.append(("base", Part.PLINTH, rectangle(0, -3.0, width, top), -float(rng.uniform(0.015, 0.05))))
    elif rng.random() < 0.75:
        top = draft.entrance - float(rng.uniform(0.02, 0.12))
        found.append(("plinth", Part.PLINTH, rectangle(0, -3.0, width, top), -float(rng.uniform(0.02, 0.08))))
    if draft.floors > 1 and rng.random() < 0.55:
        floors = range(1, draft.floors) if rng.random() < 0.4 else [1]
        thick, out = float(rng.uniform(0.1, 0.28)), -float(rng.uniform(0.03, 0.12))
        for k in floors:
            z = draft.level(k) - 0.05
            found.append((f"string{k}", Part.CORNICE, rectangle(0, z - thick, width, z), out))
    if draft.roof != "street_gable" and rng.random() < 0.7:
        high, out = float(rng.uniform(0.12, 0.34)), float(rng.uniform(0.12, 0.45))
        for k, share in enumerate((1.0, 0.6, 0.3)):  # a stepped profile
            z = draft.eaves - high * k / 3
            found.append((f"cornice{k}", Part.CORNICE, rectangle(0, z - high / 3, width, z), -out * share))
    if side == 0 and not draft.detached and rng.random() < 0.2:
        out = -float(rng.uniform(0.02, 0.06))
        for name, x in (("left", 0.0), ("right", width - 0.38)):
            ring = rectangle(x, -3.0, x + 0.38, draft.eaves - 0.4)
            found.append((f"pilaster_{name}", Part.CORNICE, ring, out))
    clear = cut.buffer(0.03, join_style="mitre")
    below = wall.union(shapely.Polygon(rectangle(0, -3.0, width, max(draft.ground) + 0.05)))
    bands = []
    for name, part, ring, y0 in found:
        rest = shapely.Polygon(ring).intersection(below).difference(cut if part == Part.PLINTH else clear)
        pieces = [p for p in shapely.get_parts(rest) if isinstance(p, shapely.Polygon) and p.area > 0.005]
        bands += [Band(name, part, piece, y0) for piece in pieces]
    return tuple(bands)


def unmet_requests(
    draft: HouseDraft, elevations: tuple[Elevation, ...], dormers: int, id: str
) -> tuple[str, ...]:
    """Return one sentence for everything that the specification asked for and the house has no room for."""
    spec, front = draft.spec, elevations[0]
    has = {
        "oriel": bool(front.oriels),
        "balconies": bool(front.balconies),
        "shop": any(o.kind == "shopfront" for o in front.openings),
        "shutters": any(o.shutters != "none" for o in front.openings),
        "dormers": dormers > 0,
    }
    return tuple(
        f"{id}: no room for what `{key}` asks for"
        for key, found in has.items()
        if getattr(spec, key) and not found
    )
