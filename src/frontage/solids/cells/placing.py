"""Reliefs find their place on a wall: whole 0.1 mm, apart from each other and from the wall's border.

Two borders closer than the gap are joined, what leaves its surface is clipped, an overlap is clipped or
refused; every change is a note, every refusal a `Failed`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry

from frontage.solids.cells.joining import join
from frontage.solids.log import Log
from frontage.solids.relief import GRID, BuildOptions, Relief

_SHARE = 0.5  # a relief that loses more than half of its area by clipping is refused
_TOUCH = 2.0  # 0.1 mm: coincidence after rounding


@dataclass(frozen=True, eq=False)
class Draft:
    """A relief projected onto a wall: polygon in 0.1 mm (x, z), and what is on its own surface."""

    relief: Relief
    polygon: BaseGeometry
    inside: tuple["Draft", ...] = ()


@dataclass(frozen=True, eq=False)
class Placed:
    """A relief in its place: polygon in whole 0.1 mm (x, z), height of its surface in 0.1 mm (positive =
    behind the wall), and the number of the one that it lies on in the list of all (-1 = the wall)."""

    relief: Relief
    polygon: Polygon
    height: int
    parent: int


@dataclass(frozen=True, eq=False)
class Area:
    """Where reliefs may go: a region, the lines they may be cut down to, and lines that cross it."""

    region: BaseGeometry
    ground: BaseGeometry
    seams: tuple[LineString, ...] = ()

    def room(self, gap: float) -> BaseGeometry:
        """The region without a strip along its border, except along the ground."""
        border = self.region.boundary.difference(self.ground.buffer(_TOUCH))
        strip = border.buffer(gap, cap_style="square", join_style="mitre")
        return shapely.set_precision(self.region.difference(strip), 1.0)


def place(area: Area, drafts: Sequence[Draft], options: BuildOptions, log: Log) -> list[Placed]:
    """All reliefs that fit, each after the one that it lies on."""
    done: list[Placed] = []
    _place(area, drafts, options, log, done, -1)
    return done


def _place(
    area: Area, drafts: Sequence[Draft], options: BuildOptions, log: Log, done: list[Placed], parent: int
) -> None:
    room = area.room(options.gap * GRID)
    shapely.prepare(room)
    base = done[parent].height if parent >= 0 else 0
    fixed = list(area.seams) + ([area.ground] if not area.ground.is_empty else [])
    here: list[tuple[Placed, Draft]] = []
    for draft in drafts:
        relief = draft.relief
        close = shapely.dwithin([p.polygon for p, _ in here], draft.polygon, options.gap * GRID)
        near = [here[k][0] for k in np.flatnonzero(close).tolist()]
        polygon = _fit(draft, room, [*fixed, *(p.polygon for p in near)], near, options, log)
        if polygon is not None:
            height = _stepped(relief, base + _height(relief, options, log), polygon, near, options, log)
            here.append((Placed(relief, polygon, height, parent), draft))
    first = len(done)
    done += [p for p, _ in here]
    for k, (placed, draft) in enumerate(here):
        if draft.inside:
            foot = area.ground.intersection(placed.polygon.boundary.buffer(_TOUCH))
            _place(Area(placed.polygon, foot), draft.inside, options, log, done, first + k)


def _fit(
    draft: Draft,
    room: BaseGeometry,
    fixed: Sequence[BaseGeometry],
    near: Sequence[Placed],
    options: BuildOptions,
    log: Log,
) -> Polygon | None:
    """A relief's polygon joined to its surroundings and clipped to what is free; None: refused."""
    relief, gap = draft.relief, options.gap * GRID
    if not isinstance(draft.polygon, Polygon) or not draft.polygon.is_valid or draft.polygon.area == 0:
        log.refuse("S312", relief, "its outline crosses itself or has no area", "repair the outline")
        return None
    polygon = join(draft.polygon, fixed, gap)
    if not room.covers(polygon):
        polygon = _largest(shapely.intersection(polygon, room, grid_size=1.0))
    cut = []
    for other in near:
        if polygon.intersection(other.polygon).area > _TOUCH * polygon.length:
            cut.append(other.relief.id)
            if options.overlaps == "refuse":
                log.refuse("S313", relief, f"overlaps {other.relief.id}", "correct one of the outlines")
                return None
            log.notes.append(f"{relief.id}: clipped where it overlaps {other.relief.id}")
            polygon = _largest(shapely.difference(polygon, other.polygon, grid_size=1.0))
    return _checked(draft, _without_necks(polygon, gap), cut, gap, log)


def _without_necks(polygon: Polygon, gap: float) -> Polygon:
    """A polygon without parts that hang on it by less than the gap."""
    wide = shapely.get_parts(polygon.buffer(-0.49 * gap, join_style="mitre"))
    if len(wide) < 2:
        return polygon
    body = max(wide, key=lambda p: float(p.area)).buffer(0.5 * gap, join_style="mitre")
    return _largest(shapely.intersection(polygon, body, grid_size=1.0))


def _checked(draft: Draft, polygon: Polygon, cut: Sequence[str], gap: float, log: Log) -> Polygon | None:
    """The clipped polygon if enough of it is left."""
    relief, whole = draft.relief, draft.polygon.area
    if polygon.area < _SHARE * whole:
        by = f", beside {' and '.join(cut)}" if cut else ""
        left = f"only {100 * polygon.area / whole:.0f} % of it lies on free wall{by}"
        log.refuse("S311", relief, left, "check the outlines" if cut else "check the host's wall there")
        return None
    if polygon.interiors:
        log.refuse("S313", relief, "surrounds another opening", "give the inner one as lying inside it")
        return None
    if polygon.buffer(-0.49 * gap).is_empty:
        log.refuse("S314", relief, f"narrower than {gap / GRID:g} m", "leave it out")
        return None
    change = polygon.symmetric_difference(draft.polygon).area / GRID**2
    if change > 1e-6 + 1e-4 * draft.polygon.length / GRID:
        log.notes.append(f"{relief.id}: its outline was changed by {change:.4f} m2 to fit its surroundings")
    return polygon


def _largest(geometry: BaseGeometry) -> Polygon:
    """The largest polygon of a geometry, an empty one if it has none."""
    parts = [p for p in shapely.get_parts(geometry) if isinstance(p, Polygon)]
    return max(parts, key=lambda p: float(p.area), default=Polygon())


def _height(relief: Relief, options: BuildOptions, log: Log) -> int:
    """Height over the surface around it in 0.1 mm."""
    if relief.depth is None or not options.depth:
        return 0
    if abs(relief.depth) < options.gap:
        log.notes.append(f"{relief.id}: {relief.depth:.3f} m deep, less than the gap: made flush")
        return 0
    return int(np.rint(relief.depth * GRID))


def _stepped(
    relief: Relief, height: int, polygon: Polygon, near: Sequence[Placed], options: BuildOptions, log: Log
) -> int:
    """The height, or that of a touching relief where the step between the two would be a sliver."""
    for other in near:
        if 0 < abs(height - other.height) < options.gap * GRID and other.polygon.dwithin(polygon, _TOUCH):
            log.notes.append(f"{relief.id}: as deep as {other.relief.id}, which it touches")
            return other.height
    return height


def raised(placed: Sequence[Placed], index: int, height: int) -> list[Placed]:
    """The list with one relief, and all that lies on it, moved to another height."""
    moved, by = list(placed), {index: height - placed[index].height}
    for k, one in enumerate(placed):
        if k == index or one.parent in by:
            by[k] = by[index] if k == index else by[one.parent]
            moved[k] = replace(one, height=one.height + by[k])
    return moved


def removed(placed: Sequence[Placed], index: int) -> list[Placed]:
    """The list without one relief and all that lies on it."""
    gone = {index}
    for k, one in enumerate(placed):
        if one.parent in gone:
            gone.add(k)
    left = [k for k in range(len(placed)) if k not in gone]
    new = {k: n for n, k in enumerate(left)} | {-1: -1}
    return [replace(placed[k], parent=new[placed[k].parent]) for k in left]
