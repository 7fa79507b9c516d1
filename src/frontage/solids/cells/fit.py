"""Fits the polygon of a relief into the free part of a wall."""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from frontage.solids.brep import GRID_PER_M
from frontage.solids.cells.context import BuildContext
from frontage.solids.cells.placed import PlacedRelief
from frontage.solids.cells.placing_area import SAME
from frontage.solids.cells.project import ProjectedRelief
from frontage.solids.cells.snap import snap_border

_MIN_SHARE = 0.5  # a relief that keeps less than half of its area is refused
_HALF_GAP = 0.49  # of the gap: parts narrower than twice this vanish when the polygon is shrunk by it
_REGROW = 0.5  # of the gap: the rest is grown back by slightly more than it was shrunk
_SHORTEST_CUT = 2.5  # gaps: shorter cuts make triangles that are too flat beside a line one gap away
_CHANGE_M2, _CHANGE_PER_M = 1e-6, 1e-4  # changes of area below this (plus per metre of border) are rounding


def fit_polygon(
    projected: ProjectedRelief,
    room: BaseGeometry,
    lines: Sequence[BaseGeometry],
    near: Sequence[PlacedRelief],
    context: BuildContext,
) -> Polygon | None:
    """Returns a relief's polygon, snapped to its surroundings and clipped to the free wall; None if refused.

    `room` is the free part of the surface, `lines` are the lines on it to snap to, `near` the reliefs placed
    earlier within the gap.
    """
    relief, log = projected.relief, context.log
    whole = projected.polygon
    if not isinstance(whole, Polygon) or not whole.is_valid or whole.area == 0:
        log.refuse("S312", relief, "its outline crosses itself or has no area", "repair the outline")
        return None
    polygon = snap_border(whole, [*lines, *(p.polygon for p in near)], context.gap)
    if not room.covers(polygon):
        free = _largest_polygon(shapely.intersection(polygon, room, grid_size=1.0))
        polygon = _without_short_cuts(free, polygon, _SHORTEST_CUT * context.gap)
    clipped_by = []
    for other in near:
        if polygon.intersection(other.polygon).area > SAME * polygon.length:
            clipped_by.append(other.relief.id)
            if context.options.overlaps == "refuse":
                log.refuse("S313", relief, f"overlaps {other.relief.id}", "correct one of the outlines")
                return None
            log.note(f"{relief.id}: clipped where it overlaps {other.relief.id}")
            polygon = _largest_polygon(shapely.difference(polygon, other.polygon, grid_size=1.0))
    return _checked(projected, _without_necks(polygon, context.gap), clipped_by, context)


def _without_short_cuts(polygon: Polygon, whole: Polygon, least: float) -> Polygon:
    """Removes one end of every edge shorter than `least` (0.1 mm) that cuts a corner off the `whole` polygon.

    The triangles between such an edge and the line that cut it, which runs a gap away, would be so flat that
    rounding turns them. The corner whose removal costs least area goes; the polygon never grows.
    """
    if polygon.is_empty or polygon.interiors:
        return polygon
    ring = shapely.get_coordinates(shapely.orient_polygons(polygon).exterior)[:-1]
    border, start = whole.boundary, 0
    while len(ring) > 3 and start < len(ring):
        a, b, c, d = ring[np.arange(start - 1, start + 3) % len(ring)]
        lost = [float(np.linalg.det([q - p, r - q])) for p, q, r in ((a, b, c), (b, c, d))]
        cuts = np.hypot(*(c - b)) < least and not border.dwithin(shapely.Point((b + c) / 2.0), SAME)
        if cuts and min(lost) > 0.0:
            ring = np.delete(ring, (start + int(np.argmin(lost))) % len(ring), axis=0)
        else:
            start += 1
    return Polygon(ring)


def _without_necks(polygon: Polygon, gap: float) -> Polygon:
    """Removes parts of a polygon that a neck narrower than the gap (0.1 mm) connects to it."""
    wide = shapely.get_parts(polygon.buffer(-_HALF_GAP * gap, join_style="mitre"))
    if len(wide) < 2:
        return polygon
    body = max(wide, key=lambda p: float(p.area)).buffer(_REGROW * gap, join_style="mitre")
    return _largest_polygon(shapely.intersection(polygon, body, grid_size=1.0))


def _checked(
    projected: ProjectedRelief, polygon: Polygon, clipped_by: Sequence[str], context: BuildContext
) -> Polygon | None:
    """Returns the clipped polygon if enough of it is left, it has no hole and is wide enough."""
    relief, whole, log = projected.relief, projected.polygon, context.log
    if polygon.area < _MIN_SHARE * whole.area:
        wall = "free wall"
        if clipped_by:
            wall = f"wall that {' and '.join(clipped_by)} leave{'s' * (len(clipped_by) == 1)} free"
        hint = "check the outlines" if clipped_by else "check the host's wall there"
        log.refuse("S311", relief, f"only {100 * polygon.area / whole.area:.0f} % of it lies on {wall}", hint)
        return None
    if polygon.interiors:
        log.refuse("S313", relief, "surrounds another opening", "declare the inner one as lying inside it")
        return None
    if polygon.buffer(-_HALF_GAP * context.gap).is_empty:
        log.refuse("S314", relief, f"narrower than {context.options.gap:g} m", "leave it out")
        return None
    change = polygon.symmetric_difference(whole).area / GRID_PER_M**2
    if change > _CHANGE_M2 + _CHANGE_PER_M * whole.length / GRID_PER_M:
        log.note(f"{relief.id}: its outline was changed by {change:.4f} m2 to fit its surroundings")
    return polygon


def _largest_polygon(geometry: BaseGeometry) -> Polygon:
    """Returns the largest polygon of a geometry, or an empty one."""
    parts = [p for p in shapely.get_parts(geometry) if isinstance(p, Polygon)]
    return max(parts, key=lambda p: float(p.area), default=Polygon())
