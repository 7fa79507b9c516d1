"""The room behind a window of a city model: models end at their walls."""

from collections.abc import Sequence

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.geometry.ring import rectangle
from frontage.simulate.houses.palette import Palette
from frontage.simulate.meshing import Pen
from frontage.simulate.scene import Part

REACH = 8.0
"""m behind a wall, beyond which no room reaches."""

_SIDE, _BELOW, _ABOVE = 1.2, 0.95, 0.45  # m, a room's reach beyond its window
_LEAST = 0.03  # m, likewise at least
_DEPTHS = (4.5, 3.6, 2.8, 2.0, 1.4, 0.9, 0.5, 0.2, 0.08)  # m: the deepest that stays in the house


def draw_room(
    pen: Pen,
    ring: Float,
    others: Sequence[Float],
    house: shapely.Geometry,
    air: Float,
    y: float,
    palette: Palette,
    rng: np.random.Generator,
) -> None:
    """A box from y m (facade frame) inwards, open to the hole `ring`; half-way to the `others` it ends.

    `house` is the footprint in the facade's (x, y), `air` (n, 3) are places outdoors and in walls, in
    the facade frame: the room leaves loggias, light wells and other walls' windows alone.
    """
    x0, z0, x1, z1 = _extent(ring, others)
    spans = [(x0, x1), (float(ring[:, 0].min()) - _LEAST, float(ring[:, 0].max()) + _LEAST)]
    near = (air[:, 2] > z0) & (air[:, 2] < z1) & (air[:, 0] > x0) & (air[:, 0] < x1)
    before = air[near][:, :2]
    fits = ((a, b, d) for d in _DEPTHS for a, b in spans if _holds(house, before, (a, y, b, y + d)))
    x0, x1, deep = next(fits, (*spans[1], _DEPTHS[-1]))
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


def _extent(ring: Float, others: Sequence[Float]) -> tuple[float, float, float, float]:
    """Bounds of the room in the wall, m: half the way to the next opening of its storey, and above, below."""
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    left = right = 2 * _SIDE
    below, above = 2 * _BELOW, 2 * _ABOVE
    for other in others:
        (a0, c0), (a1, c1) = other.min(0), other.max(0)
        if c0 < z1 + _ABOVE and c1 > z0 - _BELOW:
            left = min(left, x0 - a1) if a1 <= x0 else left
            right = min(right, a0 - x1) if a0 >= x1 else right
        if a0 < x1 and a1 > x0:
            below = min(below, z0 - c1) if c1 <= z0 else below
            above = min(above, c0 - z1) if c0 >= z1 else above
    half = [max(v / 2 - 0.005, _LEAST) for v in (left, below, right, above)]
    return float(x0 - half[0]), float(z0 - half[1]), float(x1 + half[2]), float(z1 + half[3])


def _holds(house: shapely.Geometry, air: Float, bounds: tuple[float, float, float, float]) -> bool:
    """Whether a room of some bounds (x0, y0, x1, y1) lies in the house, without any of the `air` (n, 2)."""
    box = shapely.box(*bounds)
    if ((air > bounds[:2]) & (air < bounds[2:])).all(1).any():
        return False
    return bool(house.intersection(box).area > 0.99 * box.area)
