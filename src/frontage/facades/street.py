"""Which side is the street, and what was seen through a wall: both are questions of lines of sight.

With rays the answer is measured. Without them a sensor is assumed at plausible places on either side
of the wall, and the place that contradicts the data least is kept: a point whose line of sight meets
seen, unbroken wall cannot have been seen from there (behind the wall it would be hidden, in front of
the wall it would hide).
"""

from dataclasses import dataclass

import numpy as np

from frontage.facades.cells import CellMap
from frontage.facades.refine import Wall
from frontage.geometry.arrays import Bool, Float

_EYE = 1.7  # m above the ground: a tripod; a roof-mounted scanner is at 2-3 m
_AWAY = (4.0, 8.0, 15.0, 30.0)  # m, distances tried from the wall
_REACH = 15.0  # m, points further from the wall say nothing


@dataclass(frozen=True, eq=False)
class Side:
    """The street side of a wall: sign (+1: along the wall's present normal), how it was told, sensor (3,) m facade frame.

    `odds`  contradictions of the kept side over those of the other one, 0 sure .. 1 undecided
    """

    sign: int
    told_by: str
    sensor: Float
    odds: float


def side_from_rays(wall: Wall, xyz: Float, sensors: Float) -> Side | None:
    """The side from which most inliers (n, 3) were measured; sensors (n, 3), NaN where unknown. None: no rays."""
    known = np.isfinite(sensors).all(1)
    if not known.any():
        return None
    height = (sensors[known] - wall.point) @ wall.normal
    front = float((height > 0).mean())
    sign = 1 if front > 0.5 else -1
    place = wall.coordinates(np.median(sensors[known][np.sign(height) == sign], axis=0)[None])[0]
    return Side(sign, "rays", place, min(front, 1 - front) / max(front, 1 - front))


def solid_cells(cells: CellMap) -> Bool:
    """Cells of the wall all of whose neighbours are wall too: nothing is seen through them."""
    padded = np.pad(cells.wall, 1)
    h, w = cells.wall.shape
    around = sum(
        padded[1 + i : 1 + i + h, 1 + j : 1 + j + w].astype(np.int8) for i in (-1, 0, 1) for j in (-1, 0, 1)
    )
    return np.asarray(around >= 8, np.bool_) & cells.wall


def crossing(sensor: Float, q: Float) -> tuple[Float, Float, Bool]:
    """Where lines from `sensor` (3,) through q (n, 3) meet the plane y = 0: x, z (n,) and whether they do ahead."""
    rise = q[:, 1] - sensor[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = -sensor[1] / rise
    ahead = np.isfinite(share) & (share > 0)
    share = np.where(ahead, share, 0.0)
    return sensor[0] + share * (q[:, 0] - sensor[0]), sensor[2] + share * (q[:, 2] - sensor[2]), ahead


def side_from_evidence(wall: Wall, cells: CellMap, xyz: Float, ground_z: float) -> Side:
    """The side from which the surroundings xyz (n, 3) local contradict the wall least.

    Candidate sensors stand at eye height and at half the wall's height, left, middle and right of it.
    """
    q = wall.coordinates(xyz)
    away = np.abs(q[:, 1])
    q = q[(away < _REACH) & (away > max(3 * wall.threshold, 0.1))]
    solid = solid_cells(cells)
    x0, z0 = cells.outline.min(0)
    x1, z1 = cells.outline.max(0)
    eye = float(ground_z - wall.point[2]) + _EYE if np.isfinite(ground_z) else z0 + _EYE
    places = [
        (sign, np.array([x, -sign * d, z]))
        for sign in (1, -1)
        for d in _AWAY
        for z in sorted({eye, max(eye, 0.5 * (z0 + z1))})
        for x in np.linspace(x0 - 0.5 * (x1 - x0), x1 + 0.5 * (x1 - x0), 7)
    ]
    # sign +1: the wall's normal points into the building already, the street is at negative y
    best: dict[int, tuple[float, Float]] = {}
    for sign, place in places:
        x, z, ahead = crossing(place, q)
        contradicted = float((cells.within(x, z, solid) & ahead).sum())
        if sign not in best or contradicted < best[sign][0]:
            best[sign] = (contradicted, place)
    sign = 1 if best[1][0] <= best[-1][0] else -1
    odds = (best[sign][0] + 1.0) / (best[-sign][0] + 1.0)
    return Side(-sign, "evidence", best[sign][1], odds)


def seen_through(wall: Wall, cells: CellMap, xyz: Float, sensors: Float) -> tuple[float, float]:
    """Shares of points (n, 3) behind a wall whose line of sight crosses its outline, and crosses seen wall in it.

    sensors (n, 3) or (1, 3) local m; points without a sensor count as not crossing. `wall` is oriented
    (normal into the building). A room behind a window crosses the outline but no wall; the far side of
    a tower, measured from elsewhere, "crosses" wall as often as the wall is closed.
    """
    q, s = wall.coordinates(xyz), wall.coordinates(sensors)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = -s[:, 1] / (q[:, 1] - s[:, 1])
    crosses = np.isfinite(share) & (share > 0) & (share < 1) & (s[:, 1] < 0) & (q[:, 1] > wall.threshold)
    share = np.where(crosses, share, 0.0)[:, None]
    with np.errstate(invalid="ignore"):
        at = np.where(crosses[:, None], s + share * (q - s), 0.0)
    inside = crosses & cells.within(at[:, 0], at[:, 2])
    closed = crosses & cells.within(at[:, 0], at[:, 2], cells.wall)
    return float(inside.mean()), float(closed.mean())
