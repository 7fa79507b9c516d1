"""Tells walls that were measured from within only: those of rooms that were scanned as well as the street."""

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from frontage.facades.candidate import FacadeCandidate
from frontage.facades.scene import FacadeScene
from frontage.facades.street import strip_before

_NEAR_M, _FAR_M = 0.15, 0.6  # m from a wall where the floor and the ceiling of a room that it bounds begin
_ROOM_FACE = 0.05  # share of solid wall with points close to it: a floor and a ceiling are two rows of 27
_BESIDE_M = 0.6  # m from an opening, where a street scanner sees nothing close behind the wall
_TRACE = 0.02  # share of the strip before a wall: less open ground than that is chance


def without_room_faces(candidates: Sequence[FacadeCandidate], scene: FacadeScene) -> list[FacadeCandidate]:
    """Drops walls of rooms that were scanned from within, where other walls have ground before them.

    A scanner in the street sees what lies close behind a wall through openings only. Floors and ceilings that
    begin behind solid wall, away from every opening, were measured in the room, and so was the wall, unless
    open ground was measured on its other side. With known sensor positions lines of sight tell it.
    """
    if len(candidates) < 2 or any(c.side.told_by == "rays" for c in candidates):
        return list(candidates)
    ground = [_has_trace_of_ground(c, scene) for c in candidates]
    if all(ground) or not any(ground):
        return list(candidates)
    pairs = zip(candidates, ground, strict=True)
    return [c for c, has_ground in pairs if has_ground or not _bounds_rooms(c)]


def _has_trace_of_ground(candidate: FacadeCandidate, scene: FacadeScene) -> bool:
    """Returns whether any open ground to speak of was measured before a wall."""
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
