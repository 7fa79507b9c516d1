"""Tell the street side of a wall, and find the lines of sight that pass through it.

Where the rays are known, the street side is measured. Without rays it follows from what every street has in
common, and the sensor may have stood anywhere in front of the wall.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from frontage.facades.cells import CellMap
from frontage.facades.plane.wall import WallPlane
from frontage.geometry.arrays import Bool, Float, Int, distinct
from frontage.geometry.sightlines import SightLines
from frontage.model.masonry import MASONRY

SEEN_THROUGH = 0.5
"""A wall is an interior if more than this share of its points was measured through another wall."""

_EYE_M = 1.7  # m above the ground: a tripod; a scanner on a vehicle's roof is at 2-3 m
_SENSOR_DISTANCES_M = (4.0, 8.0, 15.0, 30.0)  # m from the wall, tried for a sensor
_STRIP_NEAR_M = 1.0  # m from the wall where the examined strip begins
_STRIP_FAR_M = 8.0  # m from the wall where it ends
_PLAN_CELL_M = 0.5  # m, twice the distance of the surroundings' points, so that none is empty by chance
_STEP_M = 0.75  # m above the ground: kerbs and slopes
_PERSON_M = 2.0  # m above the ground: higher surfaces are built
_RECESS_M = 0.6  # m: windows lie this deep at most
_OPEN_SHARE = 0.25  # share of the strip that is open ground when the wall stands outside
_OPEN_RATIO = 2.0  # open ground over built-up area there: the floor of a room has as much of both
_LOG_ODDS_CAP = 3.0  # odds of 20 to 1: neither trees nor a colonnade before the wall may decide alone
_PANE_M2 = 0.25  # m2: so little may show in a hole by chance; a pane of half a metre
_GROUND_CAP = 6.0  # the same of open ground, of which rooms show little: as much as both other clues


@dataclass(frozen=True, eq=False)
class StreetSide:
    """The street side of a wall.

    sign     +1 if the street lies on the side that the wall's present normal points to, -1 if on the other
    told_by  "rays" or "evidence"
    sensors  (k, 3) m, facade frame: where the sensor may have stood; empty when rays are known
    odds     of the other side over the chosen one: 0 is certain, 1 undecided
    """

    sign: int
    told_by: str
    sensors: Float
    odds: float


@dataclass(frozen=True)
class StripBefore:
    """Areas (m2, in plan) of the strip before an oriented wall: open ground, built-up, and all of it."""

    open_ground: float
    built: float
    area: float

    @property
    def has_open_ground(self) -> bool:
        """Whether enough of the strip is ground under the open sky."""
        return self.open_ground > _OPEN_SHARE * self.area

    @property
    def is_outdoors(self) -> bool:
        """Whether open ground prevails, as it does before a wall that stands outside."""
        return self.open_ground > max(_OPEN_RATIO * self.built, _OPEN_SHARE * self.area)

    @property
    def is_free_of_buildings(self) -> bool:
        """Whether little is built up before the wall."""
        return self.built < _OPEN_SHARE * self.area


def side_from_rays(wall: WallPlane, xyz: Float, sensors: Float) -> StreetSide | None:
    """Returns the side from which most of the inliers `xyz` (n, 3) m were measured.

    sensors (n, 3) m local are NaN where unknown. Returns None when no ray is known.
    """
    known = np.isfinite(sensors).all(1)
    if not known.any():
        return None
    height = (sensors[known] - wall.point) @ wall.normal
    front = float((height > 0).mean())
    sign = 1 if front > 0.5 else -1
    return StreetSide(sign, "rays", np.empty((0, 3)), min(front, 1 - front) / max(front, 1 - front))


def side_from_evidence(
    wall: WallPlane, cells: CellMap, xyz: Float, beside: Float, ground_z: float
) -> StreetSide:
    """Tells the street side without rays, by a sum of capped log odds from three clues.

    - The street is open ground: in front of the wall one can walk, also under trees.
    - The building is high: behind the wall, points reach up to its own height (roof, rooms, other faces).
    - Windows are recessed: in the wall's holes, points close behind outweigh points close in front. All
      points count here, because nothing else tells the side of a court that was cut out of its building.
      A surface larger than an opening tells nothing: it is a storey that stands out, or one that is set back.

    xyz       (n, 3) m local, building and surroundings, evenly thinned
    beside    (m, 3) m, wall's frame: all points of the building beside the plane
    ground_z  m local
    """
    q = wall.coordinates(xyz)
    (ground_plus, mass_plus), (ground_minus, mass_minus) = (_plan_areas(q, cells, sign) for sign in (1, -1))
    hole = cells.whole & ~cells.wall
    recess_plus, recess_minus = (_hole_area(beside, cells, hole, wall, sign) for sign in (1, -1))
    odds = _log_odds(ground_plus, ground_minus, _GROUND_CAP)
    odds += _log_odds(mass_minus, mass_plus)
    odds += _log_odds(recess_minus, recess_plus, chance=_PANE_M2)
    sign = 1 if odds > 0 else -1
    return StreetSide(
        sign,
        "evidence",
        plausible_sensors(cells, ground_z - wall.point[2] + _EYE_M, sign),
        float(np.exp(-abs(odds))),
    )


def _log_odds(favour: float, against: float, cap: float = _LOG_ODDS_CAP, chance: float = 1.0) -> float:
    """Log of the ratio of two areas in m2, at most `cap`; `chance` m2 are added to both."""
    return float(np.clip(np.log((favour + chance) / (against + chance)), -cap, cap))


def _plan_areas(q: Float, cells: CellMap, sign: int) -> tuple[float, float]:
    """Open ground and building (m2, in plan) on the side `sign` of the wall, along its length.

    A plan cell is open when its lowest point is in the lowest third of the wall's height, and no higher than
    a storey, and leaves room for a person above it. Ground beyond another wall does not count. Any other cell
    is built up when its highest point is in the upper half: what rises over open ground is a tree, and so is
    what floats where much open ground shows. These limits are relative to the wall, so slopes, areas and
    steps do not matter.
    """
    (x0, z0), (x1, z1) = cells.outline.min(0), cells.outline.max(0)
    away = sign * q[:, 1]
    beside = (away > _STRIP_NEAR_M) & (away < _STRIP_FAR_M) & (q[:, 0] > x0) & (q[:, 0] < x1)
    z = q[beside, 2]
    flat, shape = _plan_cells(q[beside, 0] - x0, away[beside], float(x1 - x0))
    size = shape[0] * shape[1]
    top, floor = np.full(size, -np.inf), np.full(size, np.inf)
    np.maximum.at(top, flat, z)
    np.minimum.at(floor, flat, z)
    above = z - floor[flat]
    filled = np.bincount(flat[(above > _STEP_M) & (above < _PERSON_M)], minlength=size) > 0
    low = floor < z0 + min((z1 - z0) / 3, MASONRY.room_height)
    is_open = low & ~filled
    is_built = (top > 0.5 * (z0 + z1)) & ~is_open
    ground = _plan_area(is_open & ~_beyond_walls(flat, z - z0, z1 - z0, shape))
    is_outside = ground > _OPEN_SHARE * (_STRIP_FAR_M - _STRIP_NEAR_M) * float(x1 - x0)
    return ground, _plan_area(is_built & low if is_outside else is_built)


def _beyond_walls(flat: Int, z: Float, height: float, shape: tuple[int, int]) -> Bool:
    """Returns the plan cells (size,) that another wall parts from the wall: points fill half of its height.

    flat, z  (n,) plan cells of the points, and m above the foot of the wall
    shape    rows and columns of the plan cells, the first row beside the wall
    """
    levels, held = int(height / _PLAN_CELL_M) + 1, (z > 0) & (z < height)
    shown = distinct(flat[held] * levels + (z[held] / _PLAN_CELL_M).astype(np.int64)) // levels
    is_wall = np.bincount(shown, minlength=shape[0] * shape[1]) > levels / 2
    return np.asarray(np.logical_or.accumulate(is_wall.reshape(shape), axis=0).ravel(), np.bool_)


def strip_before(wall: WallPlane, cells: CellMap, xyz: Float, ground_z: float) -> StripBefore:
    """Measures the strip before an oriented wall.

    A plan cell is open ground when its highest point is no more than a step above the ground, and built up
    when that point is above a person's height.

    xyz       (n, 3) m local, building and surroundings
    ground_z  m local
    """
    q = wall.coordinates(xyz)
    x0, x1 = cells.outline[:, 0].min(), cells.outline[:, 0].max()
    away = -q[:, 1]
    near = (away > _STRIP_NEAR_M) & (away < _STRIP_FAR_M) & (q[:, 0] > x0) & (q[:, 0] < x1)
    top = _plan_tops(q[near, 0] - x0, away[near], xyz[near, 2] - ground_z, float(x1 - x0))
    return StripBefore(
        _plan_area(np.isfinite(top) & (top < _STEP_M)),
        _plan_area(top > _PERSON_M),
        (_STRIP_FAR_M - _STRIP_NEAR_M) * float(x1 - x0),
    )


def _plan_tops(x: Float, away: Float, height: Float, length: float) -> Float:
    """Greatest height in every plan cell of a strip; -inf where a cell is empty.

    x, away, height  (n,) m: along the wall from its left end, away from it, and up
    length           m, of the wall
    """
    flat, shape = _plan_cells(x, away, length)
    top = np.full(shape[0] * shape[1], -np.inf)
    np.maximum.at(top, flat, height)
    return top


def _plan_cells(x: Float, away: Float, length: float) -> tuple[Int, tuple[int, int]]:
    """Returns the plan cell (n,) of points of a strip of `length` m, and how many rows and columns it has."""
    width = int(length / _PLAN_CELL_M) + 1
    flat = (away / _PLAN_CELL_M).astype(np.int64) * width + (x / _PLAN_CELL_M).astype(np.int64)
    return flat, (int(_STRIP_FAR_M / _PLAN_CELL_M) + 1, width)


def _plan_area(cells: Bool) -> float:
    """Area (m2) of the plan cells that are set."""
    return float(cells.sum()) * _PLAN_CELL_M**2


def _hole_area(q: Float, cells: CellMap, hole: Bool, wall: WallPlane, sign: int) -> float:
    """Area (m2) of the wall's holes in which points lie close to the plane, on the side `sign`."""
    away = sign * q[:, 1]
    close = (away > max(2.0 * wall.threshold, 0.04)) & (away < _RECESS_M)
    labels, _ = ndimage.label(cells.marked(q[close, 0], q[close, 2]) & hole)
    area = np.bincount(labels.ravel())[1:] * cells.cell**2
    sizes = ([(s.stop - s.start) * cells.cell for s in part] for part in ndimage.find_objects(labels))
    is_pane = [not MASONRY.exceeds_opening(width, height) for height, width in sizes]
    return float(area[is_pane].sum())


def plausible_sensors(cells: CellMap, eye: float, sign: int) -> Float:
    """Places (k, 3) m, facade frame, on the side `sign` from which a wall may have been measured.

    They lie at the height `eye` (z m of a tripod) and at half the wall's height, to its left, before its
    middle and to its right.
    """
    (x0, z0), (x1, z1) = cells.outline.min(0), cells.outline.max(0)
    return np.array(
        [
            [x, sign * d, z]
            for d in _SENSOR_DISTANCES_M
            for z in (eye, max(eye, 0.5 * (z0 + z1)))
            for x in np.linspace(x0 - 0.5 * (x1 - x0), x1 + 0.5 * (x1 - x0), 7)
        ]
    )


def share_through(
    wall: WallPlane, holds: Callable[[Float, Float], Bool], xyz: Float, sensors: Float
) -> float:
    """Returns the share of the lines of sight to points (n, 3) m local that pass through a wall.

    holds    tells which places x, z (n,) m on the plane belong to the wall with its openings
    sensors  (n, 3) m local, NaN where unknown
    """
    crosses, x, z = crossings(wall, xyz, sensors)
    return float((crosses & holds(x, z)).mean())


def crossings(
    wall: WallPlane, xyz: Float, sensors: Float, steepest: float = 0.0
) -> tuple[Bool, Float, Float]:
    """Finds the lines of sight that reach points behind an oriented wall from before its plane.

    xyz       (n, 3) m local
    sensors   (n, 3) or (1, 3) m local, NaN where unknown
    steepest  sine of the least angle to the wall at which a line counts

    Returns which lines cross the wall (n,), and where they do, x and z (n,) m in facade coordinates (0 for
    the others).
    """
    q, s = wall.coordinates(xyz), wall.coordinates(sensors)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = -s[:, 1] / (q[:, 1] - s[:, 1])
    crosses = np.isfinite(share) & (share > 0) & (share < 1) & (s[:, 1] < 0) & (q[:, 1] > wall.threshold)
    crosses &= np.abs(q[:, 1] - s[:, 1]) >= steepest * np.linalg.norm(q - s, axis=1)
    x, z = np.where(crosses, SightLines.to_points(q, s, 0.0).at(0.0), 0.0)
    return crosses, x, z
