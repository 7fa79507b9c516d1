"""One house: its triangles, drawn from its draft, and the plan that is its truth."""

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.simulate.houses.compose import compose_elevations, unmet_requests
from frontage.simulate.houses.draft import HouseDraft
from frontage.simulate.houses.elevation import Elevation
from frontage.simulate.houses.fittings import draw_fittings, draw_steps
from frontage.simulate.houses.placements import oriel_wall
from frontage.simulate.houses.roofs import draw_roof
from frontage.simulate.houses.rooms import draw_rooms
from frontage.simulate.houses.shell import house_from_side, shell_faces, side_outline
from frontage.simulate.houses.style import draw_style
from frontage.simulate.houses.windows import draw_opening
from frontage.simulate.meshing import Pen
from frontage.simulate.scene import FacadePlan, House, Part, ProtrusionPlan

FOUNDATION_M = -3.0  # height at which walls end, below the lowest pavement


def build_house(
    pen: Pen, draft: HouseDraft, id: str, *, address: str, side: int, twin_of: str | None
) -> tuple[House, tuple[str, ...]]:
    """Draw a house with a pen in the house's frame.

    Returns its plan, and one note for everything that the specification asked for without there being room.

    Raises OptionError when openings of the specification leave the wall, overlap or do not fit.
    """
    rng = np.random.default_rng((*draft.seed, 1))
    style = draw_style(draft, rng)
    elevations = compose_elevations(draft, style, id, rng)
    for k, elevation in enumerate(elevations):
        _draw_facade(pen.with_prefix(elevation.id, facade=k), draft, elevation)
    _draw_blind_walls(pen, draft, {e.side for e in elevations})
    dormers = draw_roof(pen, draft, style, rng)
    draw_rooms(pen, draft, elevations, rng)
    frame = pen.local_from_frame
    facades = tuple(_plan(frame, draft, e, dormers if k == 0 else ()) for k, e in enumerate(elevations))
    foot = np.array(
        [[0, 0, 0], [draft.width, 0, 0], [draft.width, draft.depth, 0], [0, draft.depth, 0]], float
    )
    ground = float(frame.t[2])
    house = House(
        id=id,
        address=address,
        side=side,
        footprint=frame.apply(foot)[:, :2],
        ground_z=ground,
        eaves_z=ground + draft.eaves,
        ridge_z=ground + draft.ridge,
        facades=facades,
        shell=tuple((f.semantics, frame.apply(f.ring)) for f in shell_faces(draft)),
        twin_of=twin_of,
    )
    return house, unmet_requests(draft, elevations, len(dormers), id)


def _draw_facade(pen: Pen, draft: HouseDraft, elevation: Elevation) -> None:
    """Draws the wall with its holes, the openings in them, and what is fixed to the wall."""
    own = pen.in_frame(pen.local_from_frame @ elevation.house_from_facade)
    holes = [o.ring for o in elevation.openings if o.wall_y == 0.0] + [o.ring for o in elevation.oriels]
    _draw_wall(own, draft, elevation.side, "wall", holes)
    for k, (plan, dressing) in enumerate(zip(elevation.openings, elevation.dressings, strict=True)):
        piece = own.with_prefix(plan.id, opening=k)
        draw_opening(piece, plan, dressing, draft.palette, draft.inner)
        if plan.kind == "door" and plan.floor == 0:
            low = min(draft.ground_at(float(x)) for x in plan.ring[:, 0]) if elevation.side == 0 else 0.0
            draw_steps(piece, plan, low, draft.palette)
    draw_fittings(own, elevation, draft.palette)


def _draw_blind_walls(pen: Pen, draft: HouseDraft, drawn: set[int]) -> None:
    """Draws the walls of all sides but those that were drawn as facades."""
    for side in sorted({0, 1, 2, 3} - drawn):
        own = pen.in_frame(pen.local_from_frame @ house_from_side(draft, side))
        _draw_wall(own, draft, side, f"wall{side + 1}", [])


def _draw_wall(pen: Pen, draft: HouseDraft, side: int, name: str, holes: list[Float]) -> None:
    rough, length = draft.roughness, draft.correlation
    wall = pen.surface(name, Part.WALL, draft.palette.wall, roughness=rough, correlation=length)
    pen.plate(wall, side_outline(draft, side, FOUNDATION_M), 0.0, holes)


def _plan(
    frame: Rigid3, draft: HouseDraft, elevation: Elevation, dormers: tuple[ProtrusionPlan, ...]
) -> FacadePlan:
    return FacadePlan(
        elevation.id,
        frame @ elevation.house_from_facade,
        elevation.outline,
        elevation.openings,
        (*_protrusions(elevation), *dormers),
        draft.roughness,
    )


def _protrusions(elevation: Elevation) -> list[ProtrusionPlan]:
    found = []
    for k, b in enumerate(elevation.balconies):
        ring = rectangle(b.x0, b.z - b.thickness, b.x1, b.z + b.height)
        found.append(ProtrusionPlan(f"{elevation.id}/balcony{k + 1}", "balcony", ring, (-b.projection, 0.0)))
    for k, o in enumerate(elevation.oriels):
        found.append(
            ProtrusionPlan(
                f"{elevation.id}/oriel{k + 1}", "oriel", o.ring, (-o.projection, 0.0), oriel_wall(o)
            )
        )
    for band in elevation.bands:
        edge: Float = np.asarray(band.polygon.exterior.coords)[:-1]
        kind = band.name.split("_")[0].rstrip("0123456789")
        found.append(ProtrusionPlan(f"{elevation.id}/{band.name}", kind, edge, (band.y0, band.y1)))
    return found
