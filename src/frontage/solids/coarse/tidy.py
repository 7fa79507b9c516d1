"""Tidies footprints: no slits, fins or necks so narrow that the solid's vertices could fall together."""

from typing import cast

import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from frontage.solids.brep import GRID_PER_M

SLIT_M = 0.5  # half the width of gaps between strips that are closed, and of the narrowest block
_MITRE_LIMIT = 20.0  # how far a pointed corner may reach, in buffer distances
SHORTEST_M = 0.002  # vertices and borders closer than this are one; twice the validator's snap tolerance
_NECK_M = 0.02  # a neck this narrow is cut
_SMALLEST_M2 = 1.0  # smaller parts are left out


def tidy_footprints(body: BaseGeometry) -> list[Polygon]:
    """Returns the parts of an area without slits and fins narrower than a metre.

    They stay where nothing else would be left. No vertex is closer to a border than 2 mm.
    """
    closed = buffered(buffered(simplified(body), SLIT_M), -SLIT_M)
    wide = buffered(buffered(closed, -SLIT_M + SHORTEST_M), SLIT_M)
    if not wide.is_empty:
        closed = closed.intersection(wide)
    spikeless = simplified(buffered(buffered(closed, -SHORTEST_M), SHORTEST_M))
    parts = [p for p in shapely.get_parts(spikeless) if isinstance(p, Polygon) and p.area > _SMALLEST_M2]
    return [p if borders_are_apart(p) else _without_holes(p) for p in parts]


def buffered(body: BaseGeometry, by: float) -> BaseGeometry:
    """Grows (or shrinks, where negative) an area by some metres, its corners kept sharp."""
    return body.buffer(by, join_style="mitre", mitre_limit=_MITRE_LIMIT)


def simplified(body: BaseGeometry) -> BaseGeometry:
    """Snaps an area to the grid and removes vertices that a straight line replaces."""
    step = 1 / GRID_PER_M
    snapped = shapely.set_precision(shapely.set_precision(body, step).simplify(SHORTEST_M), step)
    return cast(BaseGeometry, shapely.set_precision(snapped, 0.0))  # later operations are not rounded


def borders_are_apart(part: Polygon) -> bool:
    """Decides whether no hole touches another border and no neck has the width of a point."""
    inner = buffered(part, -SHORTEST_M)
    return isinstance(inner, Polygon) and len(inner.interiors) == len(part.interiors)


def _without_holes(part: Polygon) -> Polygon:
    """Returns the largest part of an area that touches itself, without its holes."""
    pieces = shapely.get_parts(buffered(Polygon(part.exterior), -_NECK_M))
    largest = simplified(buffered(max(pieces, key=lambda p: float(p.area)), _NECK_M / 2))
    return Polygon(shapely.get_exterior_ring(largest))
