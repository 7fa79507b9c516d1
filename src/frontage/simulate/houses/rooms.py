"""The inside of a house: hollow storeys one above the other, with partitions and furniture."""

import numpy as np
import shapely

from frontage.geometry.ring import rectangle
from frontage.simulate.houses.draft import HouseDraft, Storey
from frontage.simulate.houses.elevation import Elevation
from frontage.simulate.houses.shell import house_from_side
from frontage.simulate.houses.windows import inner_ring
from frontage.simulate.meshing import Pen
from frontage.simulate.scene import Part

_MARGIN_M = 0.12  # least distance of a partition from a window


def draw_rooms(
    pen: Pen, draft: HouseDraft, elevations: tuple[Elevation, ...], rng: np.random.Generator
) -> None:
    """Draw all storeys; the inner face of every outer wall has a hole behind each glazed opening."""
    storeys = list(draft.storeys)
    if any(o.kind == "basement" for e in elevations for o in e.openings):
        storeys.insert(0, Storey(-1, draft.entrance - 2.2, draft.entrance - 0.12))
    holes = {e.side: _holes(e) for e in elevations}
    for storey in storeys:
        own = pen.with_prefix(f"{pen.prefix}/storey{storey.number}")
        _draw_storey(own, draft, storey, holes)
        _draw_partitions(own, draft, storey, elevations, rng)
        _draw_furniture(own, draft, storey, rng)


def _holes(elevation: Elevation) -> shapely.Geometry:
    pairs = zip(elevation.openings, elevation.dressings, strict=True)
    return shapely.union_all([shapely.Polygon(inner_ring(o, d)) for o, d in pairs if o.glazed])


def _draw_storey(pen: Pen, draft: HouseDraft, storey: Storey, holes: dict[int, shapely.Geometry]) -> None:
    t, w, d = draft.inner, draft.width, draft.depth
    floor = pen.surface("floor", Part.ROOM, draft.palette.floor, v=(0.0, 1.0, 0.0))
    plan = np.array([[t, t], [w - t, t], [w - t, d - t], [t, d - t]])
    pen.polygon(floor, np.column_stack([plan, np.full(4, storey.floor)]))
    walls = pen.surface("walls", Part.ROOM, draft.palette.room)
    pen.polygon(walls, np.column_stack([plan[::-1], np.full(4, storey.ceiling)]))
    for side in range(4):
        own = pen.in_frame(pen.local_from_frame @ house_from_side(draft, side))
        length = d if side % 2 else w
        wall = shapely.Polygon(rectangle(t, storey.floor, length - t, storey.ceiling))
        for piece in shapely.get_parts(wall.difference(holes.get(side, shapely.Polygon()))):
            _inner_wall(own, walls, piece, t)


def _inner_wall(pen: Pen, surface: int, piece: shapely.Polygon, y: float) -> None:
    ring = np.asarray(shapely.geometry.polygon.orient(piece).exterior.coords)[:-1]
    inside = [np.asarray(h.coords)[:-1] for h in piece.interiors]
    pen.plate(surface, ring, y, inside, inward=True)


def _draw_partitions(
    pen: Pen, draft: HouseDraft, storey: Storey, elevations: tuple[Elevation, ...], rng: np.random.Generator
) -> None:
    """Draws a wall along the corridor and walls between rooms, none of them in front of a window."""
    t, w, d = draft.inner, draft.width, draft.depth
    surface = pen.surface("partition", Part.ROOM, draft.palette.room)
    taken = {e.side: _spans(e, storey) for e in elevations}
    tries = rng.uniform(3.4, min(5.2, d - t - 0.5), 12).tolist()
    free = [y for y in tries if _free(taken.get(1, []), y) and _free(taken.get(3, []), d - y)]
    depth = free[0] if free else tries[0]
    if free:
        pen.plate(surface, rectangle(t, storey.floor, w - t, storey.ceiling), depth)
    last = t
    for x in np.sort(rng.uniform(t + 0.8, w - t - 0.8, 6)):
        if x - last > 2.4 and _free(taken.get(0, []), x) and _free(taken.get(2, []), w - x):
            last = float(x)
            ring = np.array([[x, t, storey.floor], [x, depth, storey.floor], [x, depth, storey.ceiling],
                             [x, t, storey.ceiling]])  # fmt: skip
            pen.polygon(surface, ring)


def _spans(elevation: Elevation, storey: Storey) -> list[tuple[float, float]]:
    rings = [
        inner_ring(o, d) for o, d in zip(elevation.openings, elevation.dressings, strict=True) if o.glazed
    ]
    return [
        (float(r[:, 0].min()), float(r[:, 0].max()))
        for r in rings
        if r[:, 1].min() < storey.ceiling and r[:, 1].max() > storey.floor
    ]


def _free(spans: list[tuple[float, float]], x: float) -> bool:
    return all(x < a - _MARGIN_M or x > b + _MARGIN_M for a, b in spans)


def _draw_furniture(pen: Pen, draft: HouseDraft, storey: Storey, rng: np.random.Generator) -> None:
    """Draws boxes near the windows, of the sizes of tables, chests and cupboards."""
    t, w = draft.inner, draft.width
    surface = pen.surface("furniture", Part.ROOM, draft.palette.furniture)
    for _ in range(max(1, int((w - 2 * t) / 1.8))):
        size = rng.uniform((0.4, 0.4, 0.4), (1.6, 0.9, 1.9))
        size[2] = min(size[2], storey.ceiling - storey.floor - 0.4)
        x = float(rng.uniform(t + 0.2, max(t + 0.3, w - t - size[0] - 0.2)))
        y = float(rng.uniform(t + 0.5, 3.3 - size[1] / 2))
        low = (x, y, storey.floor + 0.001)
        pen.box(surface, low, (x + size[0], y + size[1], storey.floor + size[2]))
