"""Which side is the street, and what was seen through a wall: both are questions of lines of sight.

With rays the answer is measured. Without them the side is told by what every street has in common,
and the sensor may have stood anywhere in front.
"""

from dataclasses import dataclass

import numpy as np

from frontage.facades.cells import CellMap
from frontage.facades.refine import Wall
from frontage.geometry.arrays import Bool, Float
from frontage.geometry.sightlines import SightLines

_EYE = 1.7  # m above the ground: a tripod; a roof-mounted scanner is at 2-3 m
_AWAY = (4.0, 8.0, 15.0, 30.0)  # m, distances tried from the wall
_NEAR, _FAR, _PLAN = 1.0, 8.0, 0.25  # m: strip beside the wall that is looked at, and its cells
_STEP, _PERSON = 0.75, 2.0  # m above the ground: kerbs and slopes; what is higher is built
_RECESS = 0.6  # m: windows lie this deep at most
_CAP = 3.0  # of a log odds: 20 to 1


@dataclass(frozen=True, eq=False)
class Side:
    """The street side of a wall: sign (+1: along the wall's present normal), how it was told, sensors
    (k, 3) m facade frame.

    `odds`  of the other side over the kept one: 0 sure .. 1 undecided
    """

    sign: int
    told_by: str
    sensors: Float
    odds: float


def side_from_rays(wall: Wall, xyz: Float, sensors: Float) -> Side | None:
    """The side from which most inliers (n, 3) were measured; sensors (n, 3), NaN where unknown.
    None: no rays.
    """
    known = np.isfinite(sensors).all(1)
    if not known.any():
        return None
    height = (sensors[known] - wall.point) @ wall.normal
    front = float((height > 0).mean())
    sign = 1 if front > 0.5 else -1
    return Side(sign, "rays", np.empty((0, 3)), min(front, 1 - front) / max(front, 1 - front))


def side_from_evidence(wall: Wall, cells: CellMap, xyz: Float, ground_z: float) -> Side:
    """The street side without rays, from three things that hold whoever measured: a sum of capped log odds.

    - the street is open ground: low points with nothing above them, in front of the wall;
    - the building is high: points up to the wall's own height are behind it (roof, rooms, other faces);
    - windows are recessed: in the wall's holes, points close behind outweigh points close in front.

    xyz (n, 3) local: building and surroundings, evenly thinned; ground_z m local.
    """
    q = wall.coordinates(xyz)
    (ground_plus, mass_plus), (ground_minus, mass_minus) = (_plan_areas(q, cells, sign) for sign in (1, -1))
    hole = cells.whole & ~cells.wall
    recess_plus, recess_minus = (_hole_area(q, cells, hole, wall, sign) for sign in (1, -1))
    odds = _log_odds(ground_plus, ground_minus)
    odds += _log_odds(mass_minus, mass_plus)
    odds += _log_odds(recess_minus, recess_plus)
    sign = 1 if odds > 0 else -1
    return Side(
        sign,
        "evidence",
        plausible_sensors(cells, ground_z - wall.point[2] + _EYE, sign),
        float(np.exp(-abs(odds))),
    )


def _log_odds(favour: float, against: float) -> float:
    """Log of the ratio of two areas in m2, tamed by a square metre and capped: no clue decides alone."""
    return float(np.clip(np.log((favour + 1.0) / (against + 1.0)), -_CAP, _CAP))


def _plan_areas(q: Float, cells: CellMap, sign: int) -> tuple[float, float]:
    """m2 of open ground and of building, in plan, on the side `sign` of the wall and along its length.

    A plan cell is open when its highest point is in the lowest third of the wall's height, built up when
    it is in the upper half: relative to the wall, so that slopes, areas and steps do not matter.
    """
    (x0, z0), (x1, z1) = cells.outline.min(0), cells.outline.max(0)
    away = sign * q[:, 1]
    beside = q[(away > _NEAR) & (away < _FAR) & (q[:, 0] > x0) & (q[:, 0] < x1)]
    width = int((x1 - x0) / _PLAN) + 1
    flat = (np.abs(beside[:, 1]) / _PLAN).astype(np.int64) * width + ((beside[:, 0] - x0) / _PLAN).astype(
        np.int64
    )
    top = np.full((int(_FAR / _PLAN) + 1) * width, -np.inf)
    np.maximum.at(top, flat, beside[:, 2])
    is_open = np.isfinite(top) & (top < z0 + (z1 - z0) / 3)
    return float(is_open.sum()) * _PLAN**2, float((top > 0.5 * (z0 + z1)).sum()) * _PLAN**2


def beside(wall: Wall, cells: CellMap, xyz: Float, ground_z: float) -> tuple[float, float, float]:
    """m2, in plan, before an oriented wall: ground under the open sky, built up, and the strip looked at.

    xyz (n, 3) local: building and surroundings; ground_z m local. A plan cell is open when its highest
    point is no more than a step above the ground, built up when that is above a person's height.
    """
    q = wall.coordinates(xyz)
    x0, x1 = cells.outline[:, 0].min(), cells.outline[:, 0].max()
    away = -q[:, 1]
    near = (away > _NEAR) & (away < _FAR) & (q[:, 0] > x0) & (q[:, 0] < x1)
    width = int((x1 - x0) / _PLAN) + 1
    flat = (away[near] / _PLAN).astype(np.int64) * width + ((q[near, 0] - x0) / _PLAN).astype(np.int64)
    top = np.full((int(_FAR / _PLAN) + 1) * width, -np.inf)
    np.maximum.at(top, flat, xyz[near, 2] - ground_z)
    open_sky = np.isfinite(top) & (top < _STEP)
    strip = (_FAR - _NEAR) * float(x1 - x0)
    return float(open_sky.sum()) * _PLAN**2, float((top > _PERSON).sum()) * _PLAN**2, strip


def _hole_area(q: Float, cells: CellMap, hole: Bool, wall: Wall, sign: int) -> float:
    """m2 of the wall's holes in which points lie close to the plane, on the side `sign`."""
    away = sign * q[:, 1]
    close = (away > max(2.0 * wall.threshold, 0.04)) & (away < _RECESS)
    return float((cells.marked(q[close, 0], q[close, 2]) & hole).sum()) * cells.cell**2


def plausible_sensors(cells: CellMap, eye: float, sign: int) -> Float:
    """Places (k, 3) m, facade frame, on the side `sign` from which a wall may have been measured.

    At the height `eye` (z of a tripod) and at half the wall's height; left, middle and right of the wall.
    """
    (x0, z0), (x1, z1) = cells.outline.min(0), cells.outline.max(0)
    return np.array(
        [
            [x, sign * d, z]
            for d in _AWAY
            for z in (eye, max(eye, 0.5 * (z0 + z1)))
            for x in np.linspace(x0 - 0.5 * (x1 - x0), x1 + 0.5 * (x1 - x0), 7)
        ]
    )


def crossings(wall: Wall, xyz: Float, sensors: Float, steepest: float = 0.0) -> tuple[Bool, Float, Float]:
    """Which points (n, 3) behind an oriented wall (normal into the building) have a line of sight from before
    its plane, and where (x, z) (n,) m facade coordinates it crosses that (0 where it does not).

    sensors (n, 3) or (1, 3) local m, NaN where unknown. Lines that meet the wall at less than `steepest`
    (sine of the angle) do not count.
    """
    q, s = wall.coordinates(xyz), wall.coordinates(sensors)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = -s[:, 1] / (q[:, 1] - s[:, 1])
    crosses = np.isfinite(share) & (share > 0) & (share < 1) & (s[:, 1] < 0) & (q[:, 1] > wall.threshold)
    crosses &= np.abs(q[:, 1] - s[:, 1]) >= steepest * np.linalg.norm(q - s, axis=1)
    x, z = np.where(crosses, SightLines.to_points(q, s, 0.0).at(0.0), 0.0)
    return crosses, x, z
