"""Flights of steps before a wall: a door stands where they end, and not on the ground of the street."""

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.canonical import steady
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY
from frontage.model.scan import Scan
from frontage.openings.boxes import Box
from frontage.openings.wall.evidence import BEAMS_TO_DECIDE

_AT_WALL = 0.05  # m before the wall: nearer points are on it
_PITCH = (0.35, 1.0)  # rise over run of a flight: from 13 cm on 37 cm to 20 cm on 20 cm (DIN 18065 and older)
_RUN = 0.5  # m: two treads
_RISER = 0.2  # m (DIN 18065): the points of a flight lie within a riser of the line through its treads
_ROUNDS = 8  # rounds of line and points
_MOST = 0.7  # share of the points before the foot of a door that belong to the flight at least
_HALF = 0.2  # share of them on either half of the door at least: a car or a bin is not as wide
_LAST = 0.95  # quantile of their heights that tells where the flight ends


def points_before(facade: Facade, scan: Scan, deepest: float = -_AT_WALL) -> Float:
    """Returns the points (n, 3) m, in the frame of a facade, that stand before it, sorted by x.

    deepest  m, how far behind the plane of the facade they may lie
    """
    points = steady(facade.frame.inverse.apply(scan.xyz))
    y = points[:, 1]
    near = points[(y < deepest) & (y > -MASONRY.facade_reach)]
    return np.asarray(near[np.argsort(near[:, 0])])


def top_of_flight(before: Float, place: Box, ground: float) -> float | None:
    """Returns the height z m at which the steps before an opening end; None where no steps lead up to it.

    before  (n, 3) m, the `points_before` the facade
    place   m, the opening, as far as it is known
    ground  m, height z of the ground

    Only points from which a door could lead up to the head of the opening count. They belong to a flight if
    they lie along a line that rises towards the wall as stairs do, over the whole width of the opening.
    """
    x0, _, x1, z1 = place
    x, y, z = before[slice(*np.searchsorted(before[:, 0], [x0, x1]))].T
    own = (z > ground + MASONRY.threshold) & (z < z1 - MASONRY.door_height)
    x, y, z = x[own], y[own], z[own]
    if len(x) < BEAMS_TO_DECIDE:
        return None
    kept = np.ones(len(x), np.bool_)
    for _ in range(_ROUNDS):
        if kept.sum() < BEAMS_TO_DECIDE or np.ptp(y[kept]) < _RUN:
            return None
        pitch, level = np.polyfit(y[kept], z[kept], 1)
        near = np.abs(z - level - pitch * y) < _RISER
        if (near == kept).all():
            break
        kept = near
    on_the_left = (x[kept] < (x0 + x1) / 2).sum() / max(kept.sum(), 1)
    rises = _PITCH[0] <= pitch <= _PITCH[1]
    is_flight = rises and kept.mean() >= _MOST and _HALF <= on_the_left <= 1.0 - _HALF
    return float(np.quantile(z[kept], _LAST)) if is_flight else None
