"""From fronts and cuts to one number per cell: which building it belongs to."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from frontage.buildings.profile import BIN, Profile
from frontage.buildings.split import Cut, bins_of
from frontage.buildings.voxels import grouped
from frontage.buildings.walls import Front
from frontage.geometry.arrays import Float, Int

_BESIDE = 1.0  # m that an interior may reach past the front it is seen through
_BEHIND = 0.5  # m behind a front: no longer its own wall
_NO_HIGHER = 0.25  # m
_CORNER = 2.5  # m between the ends of two walls that make one corner


@dataclass(frozen=True, eq=False)
class Street:
    """All fronts, their profiles and cuts; segments are numbered through, `first[f]` is the first of front f.
    A front may reach `depth` m back; `joins`: pairs of segments on one footprint of a map."""

    fronts: list[Front]
    profiles: list[Profile]
    cuts: list[tuple[Cut, ...]]
    depth: float
    joins: tuple[tuple[int, int], ...] = ()

    @property
    def first(self) -> Int:
        """Number (f + 1,) of each front's first segment."""
        return np.cumsum([0, *(len(c) + 1 for c in self.cuts)]).astype(np.int64)

    def segment(self, front: Int, s: Float) -> Int:
        """Segment (k,) of places s (k,) m along the fronts numbered `front` (k,)."""
        out = np.zeros(len(s), np.int64)
        sort, edge = grouped(front, len(self.fronts))
        for f in range(len(self.fronts)):
            own = sort[edge[f] : edge[f + 1]]
            out[own] = self.first[f] + bins_of(self.cuts[f], s[own])
        return out

    def building_of_segment(self) -> Int:
        """Building (segments,) after walls that meet at a corner have been joined."""
        n = int(self.first[-1])
        pairs = [*self._corners(), *self._slivers(), *self._interiors(), *self.joins]
        a = np.array([p[0] for p in pairs], np.int64)
        b = np.array([p[1] for p in pairs], np.int64)
        graph = coo_array((np.ones(len(a)), (a, b)), shape=(n, n))
        return connected_components(graph, directed=False)[1].astype(np.int64)

    def _ends(self, f: int) -> list[tuple[Float, int]]:
        """Both ends (2,) m of a front, with their segments."""
        front, profile = self.fronts[f], self.profiles[f]
        first, last = int(self.first[f]), int(self.first[f + 1]) - 1
        ends = []
        for s, segment in ((front.lo, first), (front.hi, last)):
            d = float(profile.offset_at(np.array([s]))[0])
            ends.append((front.origin + s * front.along + d * front.out, segment))
        return ends

    def _corners(self) -> list[tuple[int, int]]:
        """Pairs of segments of one block whose walls meet at an angle."""
        pairs = []
        for i in range(len(self.fronts)):
            for j in range(i):
                a, b = self.fronts[i], self.fronts[j]
                if a.block != b.block or abs(float(a.along @ b.along)) > 0.87:
                    continue
                meet = [
                    (p, q) for e, p in self._ends(i) for g, q in self._ends(j) if np.hypot(*(e - g)) < _CORNER
                ]
                pairs += meet
                pairs += [] if meet else self._abutting(i, j) + self._abutting(j, i)
        return pairs

    def _abutting(self, i: int, j: int) -> list[tuple[int, int]]:
        """Pairs where an end of front i runs into the middle of front j."""
        pairs = []
        front = self.fronts[j]
        for end, segment in self._ends(i):
            s, d = front.coordinates(end[None])
            if front.lo < s[0] < front.hi and abs(d[0]) < _CORNER:
                pairs.append((segment, int(self.segment(np.array([j]), s)[0])))
        return pairs

    def _slivers(self) -> list[tuple[int, int]]:
        """Fronts too short to be a house of their own join the nearest front of their block, if it
        touches them."""
        pairs = []
        for i, a in enumerate(self.fronts):
            if a.hi - a.lo >= 4.0:
                continue
            middle = (a.origin + 0.5 * (a.lo + a.hi) * a.along)[None]
            best = (np.inf, -1, 0.0)
            for j, b in enumerate(self.fronts):
                if j == i or b.block != a.block or b.hi - b.lo <= a.hi - a.lo:
                    continue
                s, d = b.coordinates(middle)
                at = float(np.clip(s[0], b.lo, b.hi))
                best = min(best, (float(np.hypot(s[0] - at, d[0])), j, at))
            if best[0] < 8.0:
                pairs.append(
                    (int(self.first[i]), int(self.segment(np.array([best[1]]), np.array([best[2]]))[0]))
                )
        return pairs

    def hidden_fronts(self) -> set[int]:
        """Numbers of the fronts seen through the openings of others."""
        pieces = [piece for piece, _ in self._interiors()]
        return set((np.searchsorted(self.first, pieces, side="right") - 1).tolist())

    def _interiors(self) -> list[tuple[int, int]]:
        """Pieces of wall seen through the openings of a front: behind it, and no higher than it is there."""
        pairs = []
        middle, top, half = self._pieces()
        for f, (front, profile) in enumerate(zip(self.fronts, self.profiles, strict=True)):
            s, d = front.coordinates(middle)
            d = d - profile.offset_at(s)
            within = (s - half > front.lo - _BESIDE) & (s + half < front.hi + _BESIDE)
            bins = np.clip(((s - profile.lo) / BIN).astype(np.int64), 0, len(profile) - 1)
            lower = top < profile.top[bins] + _NO_HIGHER  # False where no wall was seen
            for piece in np.flatnonzero(within & (d < -_BEHIND) & (d > -self.depth) & lower):
                if not self.first[f] <= piece < self.first[f + 1]:
                    pairs.append((int(piece), int(self.segment(np.array([f]), s[[piece]])[0])))
        return pairs

    def _pieces(self) -> tuple[Float, Float, Float]:
        """Middle (n, 2), height of the top (n,) and half the length (n,) of every segment, m."""
        middle, top, half = [], [], []
        for front, profile, cuts in zip(self.fronts, self.profiles, self.cuts, strict=True):
            edge = np.array([front.lo, *(c.s for c in cuts), front.hi])
            for a, b in pairwise(edge):
                s = np.array([0.5 * (a + b)])
                d = profile.offset_at(s)
                middle.append(front.origin + s[0] * front.along + d[0] * front.out)
                part = profile.top[max(0, int((a - profile.lo) / BIN)) : int((b - profile.lo) / BIN) + 1]
                known = part[np.isfinite(part)]
                top.append(float(np.median(known)) if len(known) else np.inf)
                half.append(0.5 * (b - a))
        return np.array(middle).reshape(-1, 2), np.array(top), np.array(half)
