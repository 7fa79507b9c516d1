"""Footprints of a map: party walls, buildings and addresses. Where a map covers the street, it decides."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.buildings.fronts.front import StreetFront
from frontage.buildings.fronts.profile import BIN_M, FrontProfile
from frontage.geometry.arrays import Bool, Float, Int
from frontage.model import Footprint

_BEHIND_M = 1.5  # m behind the wall: inside the footprint even when the map is half a metre off
_AGREE_M = 0.3  # m; the shifts of both ends of a row differ by less when it is the map that is off
_PLACES_PER_BIN = 5  # places looked up per bin (every 5 cm)
_MARGIN_M = 0.75  # m beside a footprint: its walls, on a map that is half a metre off
_TOUCHING_M = 1e-6  # m
_MOST_VOTES = 2000  # places of a building that are looked up
_SAME_SHARE = 0.5  # share of them in one footprint from which two pieces on it are one building
_ADDRESS_SHARE = 0.2  # share of them from which a building takes the address


@dataclass(frozen=True, eq=False)
class MappedRow:
    """What a map says along a front.

    walls   (k,) m along it, party walls
    ends    (2,) m of the mapped row, NaN where far from the front's
    number  (n,) footprint behind each bin of the profile, -1 = none
    """

    walls: Float
    ends: Float
    number: Int

    def inside(self, s: float, lo: float, snap: float) -> bool:
        """Decides whether a place s lies within one footprint and away from its party walls.

        s, lo  m along the front, of the place and of the beginning of bin 0
        snap   m, how far a party wall may be off
        """
        i = int(np.clip((s - lo) / BIN_M, 0, len(self.number) - 1))
        far = not len(self.walls) or float(np.abs(self.walls - s).min()) > snap
        return far and bool(self.number[i] >= 0)


def mapped_row(
    front: StreetFront, profile: FrontProfile, footprints: Sequence[Footprint], snap: float
) -> MappedRow:
    """Looks up the map along a front, a little way behind its wall; the map may be off by `snap` m."""
    over, n = int(np.ceil(snap / BIN_M)) + 1, len(profile)
    fine = np.arange(-over * _PLACES_PER_BIN, (n + over) * _PLACES_PER_BIN, dtype=np.float64)
    s: Float = profile.lo + (fine + 0.5) * BIN_M / _PLACES_PER_BIN
    d = profile.offset_at(s) - _BEHIND_M
    number = inside(front.origin + s[:, None] * front.along + d[:, None] * front.out, footprints)
    known = np.flatnonzero(number >= 0)
    change = np.flatnonzero(np.diff(number[known]) != 0)
    walls = 0.5 * (s[known[change]] + s[known[change + 1]])
    ends = np.full(2, np.nan)
    margin = 2 * over * _PLACES_PER_BIN
    if len(known) and 0 < known[0] <= margin:
        ends[0] = s[known[0]]
    if len(known) and len(s) - 1 > known[-1] >= len(s) - 1 - margin:
        ends[1] = s[known[-1]]
    bins = number[
        over * _PLACES_PER_BIN + _PLACES_PER_BIN // 2 : (over + n) * _PLACES_PER_BIN : _PLACES_PER_BIN
    ]
    return MappedRow(walls[(walls > profile.lo) & (walls < front.hi)], ends, bins)


def map_shift(row: MappedRow, measured: Float, lo: float, hi: float, snap: float) -> float:
    """Returns by how much (m) the map is off along the front; 0 when that cannot be told.

    measured  (c,) m, cuts that were measured; those beside party walls of the map decide
    lo, hi    m, ends of the front, which decide otherwise
    """
    if len(measured) and len(row.walls):
        nearest = measured[np.abs(row.walls[:, None] - measured).argmin(1)] - row.walls
        nearest = nearest[np.abs(nearest) <= snap]
        if len(nearest):
            return float(np.median(nearest))
    at_ends = np.array([lo, hi]) - row.ends
    is_known = bool(np.isfinite(at_ends).all())
    agree = is_known and abs(at_ends[0] - at_ends[1]) < _AGREE_M and np.abs(at_ends).max() <= snap
    return float(at_ends.mean()) if agree else 0.0


def footprint_of(xy: Float, footprints: Sequence[Footprint]) -> Footprint | None:
    """Returns the footprint that holds most places (k, 2) m of a building, if it holds a fifth of them."""
    number, share = _vote(xy, footprints)
    return footprints[number] if share > _ADDRESS_SHARE else None


def same_footprint(
    label: Int, keep: Bool, xy: Float, footprints: Sequence[Footprint]
) -> list[tuple[int, int]]:
    """Returns pairs of labels that lie on one footprint for the most part.

    label  (m,) of places `xy` (m, 2) m; `keep` (m,) those that count
    """
    own = np.flatnonzero(keep & (label >= 0))
    own = own[np.argsort(label[own], kind="stable")]
    first: dict[int, int] = {}
    pairs = []
    for part in np.split(own, np.flatnonzero(np.diff(label[own])) + 1) if len(own) else []:
        number, share = _vote(xy[part], footprints)
        if share > _SAME_SHARE:
            pairs.append((first.setdefault(number, int(label[part[0]])), int(label[part[0]])))
    return [(a, b) for a, b in pairs if a != b]


def _vote(xy: Float, footprints: Sequence[Footprint]) -> tuple[int, float]:
    """Returns the footprint that holds most of the places (k, 2) m, and the share that it holds."""
    if not footprints or not len(xy):
        return -1, 0.0
    number = inside(xy[:: max(1, len(xy) // _MOST_VOTES)], footprints, _MARGIN_M)
    votes = np.bincount(number[number >= 0], minlength=len(footprints))
    best = int(votes.argmax())
    return best, float(votes[best] / len(number))


def inside(xy: Float, footprints: Sequence[Footprint], margin: float = 0.0) -> Int:
    """Returns the footprint (k,) that each place (k, 2) m lies in, or beside by up to `margin` m.

    -1 = none.
    """
    tree = shapely.STRtree([shapely.Polygon(f.ring).buffer(0) for f in footprints])
    place, found = tree.query_nearest(
        shapely.points(xy), max_distance=margin or _TOUCHING_M, all_matches=False
    )
    number = np.full(len(xy), -1, np.int64)
    number[place] = found
    return number
