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
_LAST = 0.95  # quantile of heights that tells where a flight ends, and how high its cheek is
_CHEEK_M = 0.3  # m, width of a cheek or railing with most of the points before the foot of a door
_TREAD_M, _TREADS = 0.25, 5  # m, strips along the wall in which its upper edge is told, and how many at least


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
    they lie along a line that rises towards the wall as stairs do, over the whole width of the opening. Where
    only a cheek or a railing of the flight is seen, its upper edge rises like that, up to the wall.
    """
    x0, _, x1, z1 = place
    x, y, z = before[slice(*np.searchsorted(before[:, 0], [x0, x1]))].T
    own = (z > ground + MASONRY.threshold) & (z < z1 - MASONRY.door_height)
    x, y, z = x[own], y[own], z[own]
    if len(x) < BEAMS_TO_DECIDE:
        return None
    top = _top_of_treads(x, y, z, (x0 + x1) / 2.0)
    return _top_of_cheek(x, y, z) if top is None else top


def _top_of_treads(x: Float, y: Float, z: Float, middle: float) -> float | None:
    """Returns the height z m of the last tread; None where the points (n,) before a wall are no treads.

    Treads lie on both sides of the `middle` x m of the opening.
    """
    kept = np.ones(len(x), np.bool_)
    for _ in range(_ROUNDS):
        if kept.sum() < BEAMS_TO_DECIDE or np.ptp(y[kept]) < _RUN:
            return None
        pitch, level = np.polyfit(y[kept], z[kept], 1)
        near = np.abs(z - level - pitch * y) < _RISER
        if (near == kept).all():
            break
        kept = near
    on_the_left = (x[kept] < middle).sum() / max(kept.sum(), 1)
    rises = _PITCH[0] <= pitch <= _PITCH[1]
    is_flight = rises and kept.mean() >= _MOST and _HALF <= on_the_left <= 1.0 - _HALF
    return float(np.quantile(z[kept], _LAST)) if is_flight else None


def _top_of_cheek(x: Float, y: Float, z: Float) -> float | None:
    """Returns the height z m of a cheek or railing at the wall; None where the points (n,) are neither."""
    near = np.abs(x - np.median(x)) < _CHEEK_M / 2.0
    strip = np.floor(-y[near] / _TREAD_M).astype(np.int64)
    number = int(np.append(np.bincount(strip) > 0, False).argmin())  # strips in a row, from the wall on
    if near.mean() < _MOST or number < _TREADS:
        return None
    tops = np.array([np.quantile(z[near][strip == k], _LAST) for k in range(number)])
    away = _TREAD_M * (np.arange(number) + 0.5)
    line = np.polyfit(away, tops, 1)
    straight = np.abs(tops - np.polyval(line, away)).max() < _RISER
    return float(tops.max()) if straight and _PITCH[0] <= -line[0] <= _PITCH[1] else None
