"""From fronts and cuts to one number per cell: which building it belongs to."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from frontage.buildings.profile import Profile
from frontage.buildings.split import Cut, bins_of
from frontage.buildings.voxels import grouped
from frontage.buildings.walls import Front
from frontage.geometry.arrays import Float, Int

_CORNER = 2.5  # m between the ends of two walls that make one corner


@dataclass(frozen=True, eq=False)
class Street:
    """All fronts, their profiles and cuts; segments are numbered through, `first[f]` is the first
    of front f."""

    fronts: list[Front]
    profiles: list[Profile]
    cuts: list[tuple[Cut, ...]]

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
        pairs = [*self._corners(), *self._slivers()]
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
