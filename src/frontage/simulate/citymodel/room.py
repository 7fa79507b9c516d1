"""Draws the room behind a window of a city model, as models end at their walls."""

from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.geometry.ring import rectangle
from frontage.simulate.houses.palette import Palette
from frontage.simulate.meshing import Pen
from frontage.simulate.scene import Part

REACH_M = 8.0
"""Distance behind a wall beyond which no room reaches."""

_SIDE_M, _BELOW_M, _ABOVE_M = 1.2, 0.95, 0.45  # by which a room is larger than its window
_LEAST_M = 0.03  # by which it is larger at least, on every side
_DEPTHS_M = (4.5, 3.6, 2.8, 2.0, 1.4, 0.9, 0.5, 0.2, 0.08)  # the deepest that stays in the house is taken


@dataclass(frozen=True, eq=False)
class RoomPlace:
    """The place of a room, in the frame of its facade.

    ring     outline (k, 2) m of the opening that it lies behind
    others   outlines of the other openings of the facade; the room ends half-way to them
    house    the building's footprint in (x, y)
    air      points (n, 3) m outdoors and within walls, which no room may contain: this keeps loggias, light
             wells and the windows of other walls free
    y        m, of the room's front
    """

    ring: Float
    others: tuple[Float, ...]
    house: shapely.Geometry
    air: Float
    y: float


def draw_room(pen: Pen, place: RoomPlace, palette: Palette, rng: np.random.Generator) -> None:
    """Draw a box from `place.y` inwards, open to its window, with a piece of furniture if it is deep."""
    ring, y = place.ring, place.y
    x0, x1, z0, z1, deep = _extent(place)
    walls = pen.surface("room", Part.ROOM, palette.room)
    floor = pen.surface("floor", Part.ROOM, palette.floor, v=(0.0, 1.0, 0.0))
    back = y + deep
    pen.plate(walls, rectangle(x0, z0, x1, z1), y, [ring], inward=True)
    pen.plate(walls, rectangle(x0, z0, x1, z1), back)
    pen.polygon(floor, np.array([[x0, y, z0], [x1, y, z0], [x1, back, z0], [x0, back, z0]]))
    pen.polygon(walls, np.array([[x0, y, z1], [x0, back, z1], [x1, back, z1], [x1, y, z1]]))
    pen.polygon(walls, np.array([[x0, y, z0], [x0, back, z0], [x0, back, z1], [x0, y, z1]]))
    pen.polygon(walls, np.array([[x1, y, z0], [x1, y, z1], [x1, back, z1], [x1, back, z0]]))
    width, height = x1 - x0, z1 - z0
    if deep > 1.0 and width > 0.6:
        size = rng.uniform((0.3, 0.3, 0.3), (0.7, 0.5, 0.8)) * [width, 0.9, height]
        start = x0 + float(rng.uniform(0.02, 0.98 - size[0] / width)) * width
        low = (start, back - size[1] - 0.02, z0 + 0.001)
        piece = pen.surface("furniture", Part.ROOM, palette.furniture)
        pen.box(piece, low, (low[0] + size[0], low[1] + size[1], z0 + size[2]))


def _extent(place: RoomPlace) -> tuple[float, float, float, float, float]:
    """Returns x0, x1, z0, z1 and the depth (m) of the largest room that stays in the house."""
    ring, air, y = place.ring, place.air, place.y
    x0, z0, x1, z1 = _bounds(ring, place.others)
    spans = [(x0, x1), (float(ring[:, 0].min()) - _LEAST_M, float(ring[:, 0].max()) + _LEAST_M)]
    near = (air[:, 2] > z0) & (air[:, 2] < z1) & (air[:, 0] > x0) & (air[:, 0] < x1)
    inside = air[near][:, :2]
    fits = (
        (a, b, d)
        for d in _DEPTHS_M
        for a, b in spans
        if _is_inside_house(place.house, inside, (a, y, b, y + d))
    )
    x0, x1, deep = next(fits, (*spans[1], _DEPTHS_M[-1]))
    return x0, x1, z0, z1, deep


def _bounds(ring: Float, others: tuple[Float, ...]) -> tuple[float, float, float, float]:
    """Returns x0, z0, x1, z1 (m) of the room: larger than its window, but at most half-way to the others."""
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    left = right = 2 * _SIDE_M
    below, above = 2 * _BELOW_M, 2 * _ABOVE_M
    for other in others:
        (a0, c0), (a1, c1) = other.min(0), other.max(0)
        if c0 < z1 + _ABOVE_M and c1 > z0 - _BELOW_M:
            left = min(left, x0 - a1) if a1 <= x0 else left
            right = min(right, a0 - x1) if a0 >= x1 else right
        if a0 < x1 and a1 > x0:
            below = min(below, z0 - c1) if c1 <= z0 else below
            above = min(above, c0 - z1) if c0 >= z1 else above
    half = [max(v / 2 - 0.005, _LEAST_M) for v in (left, below, right, above)]
    return float(x0 - half[0]), float(z0 - half[1]), float(x1 + half[2]), float(z1 + half[3])


def _is_inside_house(house: shapely.Geometry, air: Float, bounds: tuple[float, float, float, float]) -> bool:
    """Checks that a room with bounds x0, y0, x1, y1 lies in the house and contains none of `air` (n, 2)."""
    box = shapely.box(*bounds)
    if ((air > bounds[:2]) & (air < bounds[2:])).all(1).any():
        return False
    return bool(house.intersection(box).area > 0.99 * box.area)
