"""Footprints of a map or city model: party walls and addresses."""

from collections.abc import Sequence

import numpy as np
import shapely

from frontage.buildings.profile import BIN, Profile
from frontage.buildings.walls import Front
from frontage.geometry.arrays import Float, Int
from frontage.model import Footprint

_BEHIND = 1.5  # m behind the wall: inside the footprint even when the map is half a metre off


def party_walls(front: Front, profile: Profile, footprints: Sequence[Footprint]) -> Float:
    """Places s (k,) m along a front where the footprint behind the wall changes from one building
    to another."""
    s: Float = profile.lo + (np.arange(len(profile), dtype=np.float64) + 0.5) * BIN
    d = profile.offset_at(s) - _BEHIND
    number = _inside(front.origin + s[:, None] * front.along + d[:, None] * front.out, footprints)
    known = np.flatnonzero(number >= 0)
    change = np.flatnonzero(np.diff(number[known]) != 0)
    return 0.5 * (s[known[change]] + s[known[change + 1]])


def footprint_of(xy: Float, footprints: Sequence[Footprint]) -> Footprint | None:
    """The footprint that holds most of the places (k, 2) m of a building, if it holds any fifth of them."""
    if not footprints or not len(xy):
        return None
    number = _inside(xy[:: max(1, len(xy) // 5000)], footprints)
    votes = np.bincount(number[number >= 0], minlength=len(footprints))
    best = int(votes.argmax())
    return footprints[best] if votes[best] > 0.2 * len(number) else None


def _inside(xy: Float, footprints: Sequence[Footprint]) -> Int:
    """Number (k,) of the first footprint that contains each place, -1 = none."""
    number = np.full(len(xy), -1, np.int64)
    for i, footprint in enumerate(footprints):
        inside = shapely.contains_xy(shapely.Polygon(footprint.ring).buffer(0), xy[:, 0], xy[:, 1])
        number[inside & (number < 0)] = i
    return number
