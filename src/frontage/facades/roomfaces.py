"""Tells walls that were measured from within only: those of rooms that were scanned as well as the street."""

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from frontage.facades.candidate import FacadeCandidate
from frontage.facades.scene import FacadeScene
from frontage.facades.street import strip_before
from frontage.geometry.arrays import Float
from frontage.model.masonry import MASONRY

_NEAR_M, _FAR_M = 0.15, 0.6  # m from a wall where the floor and the ceiling of a room that it bounds begin
_ROOM_FACE = 0.05  # share of solid wall with points close to it: a floor and a ceiling are two rows of 27
_BESIDE_M = 0.6  # m from an opening, where a street scanner sees nothing close behind the wall
_SENSORS = 50  # points of a wall whose sensors are asked
_HEAD_M, _HIGHEST_M = 0.3, 6.0  # m above a sensor, between which a ceiling lies
_AROUND_M, _CELL_M = 1.5, 0.5  # m around a sensor where it is looked for, and the side of plan cells
_MOST, _LEVEL_M = 0.8, 0.25  # share of the cells that show it, and m by which they may differ in height
_TRACE = 0.02  # share of the strip before a wall: less open ground than that is chance


def without_room_faces(
    candidates: Sequence[FacadeCandidate], scene: FacadeScene, known: Sequence[FacadeCandidate] = ()
) -> list[FacadeCandidate]:
    """Drops walls of rooms that were scanned from within, where other walls of the building were not.

    A scanner in the street sees what lies close behind a wall through openings only. A floor or a ceiling
    that begins at solid wall, away from every opening, was measured in the room, and so was the wall if
    nothing tells that it was seen from outside. Without sensor positions, a wall narrower than a room proves
    nothing about the others: it may be the end of a front that was cut out together with its ground.

    known  walls that are facades, beside which all candidates may be walls of rooms
    """
    rooms = [_bounds_rooms(c) for c in candidates]
    if not any(rooms):
        return list(candidates)
    outside = [_is_seen_from_outside(c, scene) for c in candidates]
    seen = [c for c, is_outside in zip(candidates, outside, strict=True) if is_outside]
    if not known and not any(c.side.told_by == "rays" or c.cells.size[0] > MASONRY.room_width for c in seen):
        return list(candidates)
    told = zip(candidates, rooms, outside, strict=True)
    return [c for c, is_room, is_outside in told if is_outside or not is_room]


def _is_seen_from_outside(candidate: FacadeCandidate, scene: FacadeScene) -> bool:
    """Returns whether a wall was measured from outside: its sensors tell it, or open ground before it."""
    if candidate.side.told_by == "rays":
        return not _is_seen_from_indoors(candidate, scene)
    return _has_trace_of_ground(candidate, scene)


def _is_seen_from_indoors(candidate: FacadeCandidate, scene: FacadeScene) -> bool:
    """Returns whether most of a wall was measured from below a ceiling: a level surface above the sensor.

    The crown of a tree is not level.
    """
    rows = candidate.wall.inliers
    places, number = np.unique(scene.sensors(rows[:: len(rows) // _SENSORS + 1]), axis=0, return_counts=True)
    covered = np.array([_is_below_ceiling(place, scene.around) for place in places], np.bool_)
    return bool(2 * number[covered].sum() > number.sum())


def _is_below_ceiling(place: Float, xyz: Float) -> bool:
    """Returns whether points (n, 3) m form a level surface above most of the surroundings of a place (3,)."""
    away = xyz - place
    above = (away[:, 2] > _HEAD_M) & (away[:, 2] < _HIGHEST_M) & (np.abs(away[:, :2]) < _AROUND_M).all(1)
    cell = np.floor((away[above, :2] + _AROUND_M) / _CELL_M).astype(np.int64)
    side = round(2.0 * _AROUND_M / _CELL_M)
    lowest = np.full(side**2, np.inf)
    np.minimum.at(lowest, cell[:, 0] * side + cell[:, 1], away[above, 2])
    known = np.isfinite(lowest)
    if known.mean() < _MOST:
        return False
    level = np.abs(lowest - np.median(lowest[known])) < _LEVEL_M
    return bool(level.mean() >= _MOST)


def _has_trace_of_ground(candidate: FacadeCandidate, scene: FacadeScene) -> bool:
    """Returns whether more open ground than by chance was measured before a wall."""
    before = strip_before(candidate.wall, candidate.cells, scene.around, scene.ground_z)
    return before.open_ground > _TRACE * before.area


def _bounds_rooms(candidate: FacadeCandidate) -> bool:
    """Returns whether points lie close to much of the wall that is solid and away from openings.

    The wall may face the room: where nothing was measured beyond it, its floor passes for a street.
    """
    cells, q = candidate.cells, candidate.slab.q
    wide = 2 * round(_BESIDE_M / cells.cell) + 1
    solid = ndimage.binary_closing(cells.wall, np.ones((3, 3), np.bool_))
    solid = ndimage.binary_erosion(solid, np.ones((1, wide), np.bool_))
    away = q[:, 1:2] * [-1.0, 1.0]
    close = (away > _NEAR_M) & (away < _FAR_M)
    shown = (cells.marked(q[own, 0], q[own, 2]) & solid for own in close.T)
    return any(cell.sum() > _ROOM_FACE * solid.sum() for cell in shown)
