"""Segments of fronts between cuts, and which of them form one building."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from frontage.buildings.fronts.front import StreetFront
from frontage.buildings.fronts.profile import BIN_M, FrontProfile
from frontage.buildings.groups import grouped
from frontage.buildings.split.find import Cut, segment_of
from frontage.geometry.arrays import Float, Int
from frontage.model.masonry import MASONRY

_BESIDE_M = 1.0  # m that an interior may reach past the front it is seen through
_BEHIND_M = 0.5  # m behind a front: no longer its own wall
_NO_HIGHER_M = 0.25  # m that an interior may rise above the front it is seen through
_CORNER_M = 2.5  # m between the ends of two walls that form one corner
_NEXT_M = 1.0  # m between columns of one wall
_CORNER_COS = 0.87  # cosine between two fronts above which they form no corner: 30 degrees
_SHORTEST_M = 4.0  # m, length of a front from which it may be a house of its own
_TOUCHING_M = 8.0  # m between the middle of a shorter front and the front that it joins

Pair = tuple[int, int]  # two segments of one building


@dataclass(frozen=True, eq=False)
class SegmentedStreet:
    """All fronts with their profiles and cuts.

    Segments are numbered through all fronts, from left to right; ``first[f]`` is the first of front f.

    depth    m, how far back a building may reach behind its front
    columns  (k, 2) m, places of the wall columns that the fronts consist of
    joins    pairs of segments that lie on one footprint of a map
    """

    fronts: tuple[StreetFront, ...]
    profiles: tuple[FrontProfile, ...]
    cuts: tuple[tuple[Cut, ...], ...]
    depth: float
    columns: Float
    joins: tuple[Pair, ...] = ()

    @property
    def first(self) -> Int:
        """Number (f + 1,) of each front's first segment, and of all segments."""
        return np.cumsum([0, *(len(c) + 1 for c in self.cuts)]).astype(np.int64)

    def segment(self, front: Int, s: Float) -> Int:
        """Returns the segment (k,) of places s (k,) m along the fronts numbered `front` (k,)."""
        out = np.zeros(len(s), np.int64)
        sort, edge = grouped(front, len(self.fronts))
        for f in range(len(self.fronts)):
            own = sort[edge[f] : edge[f + 1]]
            out[own] = self.first[f] + segment_of(self.cuts[f], s[own])
        return out

    def building_of_segment(self) -> Int:
        """Returns the building of every segment, after segments of one building have been joined.

        Joined are walls that meet at a corner, fronts too short for a house, interiors with the front that
        they are seen through, and segments on one footprint.
        """
        n = int(self.first[-1])
        pairs = [*self._corners(), *self._short_fronts(), *self._interiors(), *self.joins]
        a = np.array([p[0] for p in pairs], np.int64)
        b = np.array([p[1] for p in pairs], np.int64)
        graph = coo_array((np.ones(len(a)), (a, b)), shape=(n, n))
        return connected_components(graph, directed=False)[1].astype(np.int64)

    def hidden_fronts(self) -> set[int]:
        """Returns the numbers of the fronts that are seen through the openings of others."""
        pieces = [piece for piece, _ in self._interiors()]
        return set((np.searchsorted(self.first, pieces, side="right") - 1).tolist())

    def _segment_at(self, front: int, s: float) -> int:
        """Returns the segment at the place s m along one front."""
        return int(self.segment(np.array([front]), np.array([s]))[0])

    def _ends(self, f: int) -> list[tuple[Float, int]]:
        """Returns both ends (2,) m of a front, with their segments."""
        front, profile = self.fronts[f], self.profiles[f]
        first, last = int(self.first[f]), int(self.first[f + 1]) - 1
        ends = []
        for s, segment in ((front.lo, first), (front.hi, last)):
            d = float(profile.offset_at(np.array([s]))[0])
            ends.append((front.origin + s * front.along + d * front.out, segment))
        return ends

    def _corners(self) -> list[Pair]:
        """Returns pairs of segments of one block whose walls meet at an angle."""
        pairs = []
        for i in range(len(self.fronts)):
            for j in range(i):
                a, b = self.fronts[i], self.fronts[j]
                if a.block != b.block or abs(float(a.along @ b.along)) > _CORNER_COS:
                    continue
                meet = [
                    (p, q)
                    for e, p in self._ends(i)
                    for g, q in self._ends(j)
                    if np.hypot(*(e - g)) < _CORNER_M
                ]
                abut = self._abutting(i, j) + self._abutting(j, i)
                pairs += meet or abut or self._continued(i, j) + self._continued(j, i)
        return pairs

    def _abutting(self, i: int, j: int) -> list[Pair]:
        """Returns pairs where an end of front i meets the middle of front j."""
        pairs = []
        front = self.fronts[j]
        for end, segment in self._ends(i):
            s, d = front.coordinates(end[None])
            if front.lo < s[0] < front.hi and abs(d[0]) < _CORNER_M:
                pairs.append((segment, self._segment_at(j, float(s[0]))))
        return pairs

    def _continued(self, i: int, j: int) -> list[Pair]:
        """Returns pairs where the wall of front i goes on beyond its end in columns that front j has taken.

        A front takes the columns behind it, the first metres of a side wall among them.
        """
        pairs = []
        front = self.fronts[i]
        own = self.columns[self.fronts[j].members]
        s, d = front.coordinates(own)
        on = np.flatnonzero(np.abs(d) < MASONRY.relief)
        for at, (_, segment) in zip((front.lo, front.hi), self._ends(i), strict=True):
            beside = on[np.abs(s[on] - at) < _NEXT_M]
            if len(beside):
                place = self.fronts[j].coordinates(own[beside].mean(0)[None])[0]
                pairs.append((segment, self._segment_at(j, float(place[0]))))
        return pairs

    def _short_fronts(self) -> list[Pair]:
        """Joins fronts too short for a house of their own to the nearest front of their block, if near."""
        pairs = []
        for i, a in enumerate(self.fronts):
            if a.length >= _SHORTEST_M:
                continue
            middle = (a.origin + 0.5 * (a.lo + a.hi) * a.along)[None]
            best = (np.inf, -1, 0.0)
            for j, b in enumerate(self.fronts):
                if j == i or b.block != a.block or b.length <= a.length:
                    continue
                s, d = b.coordinates(middle)
                at = float(np.clip(s[0], b.lo, b.hi))
                best = min(best, (float(np.hypot(s[0] - at, d[0])), j, at))
            if best[0] < _TOUCHING_M:
                pairs.append((int(self.first[i]), self._segment_at(best[1], best[2])))
        return pairs

    def _interiors(self) -> list[Pair]:
        """Joins pieces of wall behind a front to that front, if they rise no higher than it does there."""
        pairs = []
        middle, top, half = self._pieces()
        for f, (front, profile) in enumerate(zip(self.fronts, self.profiles, strict=True)):
            s, d = front.coordinates(middle)
            d = d - profile.offset_at(s)
            is_beside = (s - half > front.lo - _BESIDE_M) & (s + half < front.hi + _BESIDE_M)
            is_behind = (d < -_BEHIND_M) & (d > -self.depth)
            bins = np.clip(((s - profile.lo) / BIN_M).astype(np.int64), 0, len(profile) - 1)
            is_lower = top < profile.top[bins] + _NO_HIGHER_M  # False where no wall was seen
            for piece in np.flatnonzero(is_beside & is_behind & is_lower):
                if not self.first[f] <= piece < self.first[f + 1]:
                    pairs.append((int(piece), self._segment_at(f, float(s[piece]))))
        return pairs

    def _pieces(self) -> tuple[Float, Float, Float]:
        """Returns middle (n, 2), height of the top (n,) and half the length (n,) of every segment, m."""
        middle, top, half = [], [], []
        for front, profile, cuts in zip(self.fronts, self.profiles, self.cuts, strict=True):
            edge = np.array([front.lo, *(c.s for c in cuts), front.hi])
            for a, b in pairwise(edge):
                s = np.array([0.5 * (a + b)])
                d = profile.offset_at(s)
                middle.append(front.origin + s[0] * front.along + d[0] * front.out)
                first, last = (int((x - profile.lo) / BIN_M) for x in (a, b))
                part = profile.top[max(0, first) : last + 1]
                known = part[np.isfinite(part)]
                top.append(float(np.median(known)) if len(known) else np.inf)
                half.append(0.5 * (b - a))
        return np.array(middle).reshape(-1, 2), np.array(top), np.array(half)
