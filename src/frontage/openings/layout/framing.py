"""Which rectangles of open cells can be openings: the wall shows around them, and beams tell of them."""

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int
from frontage.model.masonry import MASONRY
from frontage.openings.wall.evidence import Evidence

_RIM = 0.1  # m beside an opening where the wall must show
_WALL = 0.4  # share of the expected beams that a rim must have on the wall
_FEWEST = 5.0  # expected beams: fewer tell nothing
_RETURN = 0.3  # share of the expected beams that a small opening must send back from its depth
_SOME = 0.05  # the same of a large one: frames and reveals
_SEEN = 0.1  # the same of the beams that are due
_LONE = 0.6  # m, least side of an opening that sends back less
_VISIBLE = 0.5  # share of the beams due that must have got as far as the wall there
_HIDDEN = 0.3  # share of the beams due, below which a rim is hidden
_BARS = 0.12  # share of the expected beams that bars and frames level with the wall return
_KNOWN = 0.5  # share of an opening's cells that tell something


class Framing:
    """Sums over rectangles of the evidence, to judge many of them at once."""

    def __init__(self, evidence: Evidence, ground: float) -> None:
        self._shape = evidence.llr.shape
        self._cell = evidence.raster.cell
        self._ground = int(np.ceil((ground + MASONRY.threshold - evidence.raster.corner[1]) / self._cell))
        self._rays = evidence.rays
        much = evidence.expected + 2.0 * np.sqrt(evidence.expected) + 1.0  # reveals and ledges hold more
        wall = np.minimum(evidence.solid, much)
        known = (evidence.llr != 0.0).astype(np.float64)
        layers = (wall, evidence.expected, evidence.due, evidence.deep, evidence.llr, known)
        self._sums = np.stack([np.pad(m.cumsum(0).cumsum(1), ((1, 0), (1, 0))) for m in layers])

    def __call__(self, boxes: Int) -> Bool:
        """Whether boxes (n, 4) r0, c0, r1, c1 are openings (n,): what is open on one side is none.

        The wall shows on both sides and above or below; near the ground the lower end is no matter. With rays
        one side may be hidden by something before the wall. The opening itself is free of wall, half of its
        cells say something, and beams find a depth; or it is large, visible, and shows something of a depth
        or the wall on all sides: shadows leave cells as empty as glass does, most are small or run on. Where
        no ray tells shadows, one with wall on all sides must begin sharply, and may be small if it shows
        something of a depth.
        """
        r0, c0, r1, c1 = boxes.T
        rim = max(int(np.ceil(_RIM / self._cell)), 2)
        left, right = self._sum(r0, c0 - 1 - rim, r1, c0 - 1), self._sum(r0, c1 + 1, r1, c1 + 1 + rim)
        below, above = self._sum(r0 - 1 - rim, c0, r0 - 1, c1), self._sum(r1 + 1, c0, r1 + 1 + rim, c1)
        sides = np.stack([self._walled(left), self._walled(right)])
        hidden = np.stack([self._hidden(left), self._hidden(right)])
        ends = np.stack([self._walled(above), self._walled(below) | (r0 < self._ground)])
        framed = (sides | hidden).all(0) & sides.any(0) & ends.any(0)
        shut = (ends | (np.stack([above[:, 4], below[:, 4]]) <= 0.0)).all(0)
        free = ~self._walled(self._sum(r0 + 1, c0 + 1, r1 - 1, c1 - 1))
        _, expected, due, deep, _, known = self._sum(r0, c0, r1, c1).T
        told = known > _KNOWN * (r1 - r0) * (c1 - c0)
        returned = deep > np.maximum(_RETURN * expected, _SEEN * due)
        visible = expected > _VISIBLE * due
        large = np.minimum(r1 - r0, c1 - c0) * self._cell > _LONE
        some = deep > _SOME * expected
        whole = ends.all(0) & (large if self._rays else self._sharp(boxes, rim) & (large | some))
        return np.asarray(framed & free & told & (returned | (visible & ((large & shut & some) | whole))))

    def _sharp(self, boxes: Int, rim: int) -> Bool:
        """Whether hardly any wall shows within `rim` cells inside of each border of boxes (n, 4) (n,).

        Shadows of leaves, and patches that return little, have ragged edges that wall shines through; an
        opening without a frame in sight is empty right from its borders.
        """
        r0, c0, r1, c1 = boxes.T + np.array([[1], [1], [-1], [-1]])
        wide = np.clip(np.minimum(r1 - r0, c1 - c0) // 2, 1, rim)
        strips = [
            self._sum(r0, c0, r1, c0 + wide),
            self._sum(r0, c1 - wide, r1, c1),
            self._sum(r0, c0, r0 + wide, c1),
            self._sum(r1 - wide, c0, r1, c1),
        ]
        return np.asarray(np.all([s[:, 0] <= _BARS * s[:, 1] for s in strips], axis=0))

    def _sum(self, r0: Int, c0: Int, r1: Int, c1: Int) -> Float:
        """Sums (n, 6) over rows [r0, r1) and columns [c0, c1), as far as they are on the raster."""
        r0, r1 = np.clip(r0, 0, self._shape[0]), np.clip(r1, 0, self._shape[0])
        c0, c1 = np.clip(c0, 0, self._shape[1]), np.clip(c1, 0, self._shape[1])
        s = self._sums
        return np.asarray(s[:, r1, c1] - s[:, r0, c1] - s[:, r1, c0] + s[:, r0, c0]).T

    def _walled(self, sums: Float) -> Bool:
        """Whether the wall shows: enough of the expected beams ended on it, or enough where none was."""
        enough = np.maximum(sums[:, 0], sums[:, 1]) >= _FEWEST
        return np.asarray(enough & (sums[:, 0] >= _WALL * sums[:, 1]))

    def _hidden(self, sums: Float) -> Bool:
        """Whether something before the wall is known to hide it."""
        return np.asarray((sums[:, 1] < _HIDDEN * sums[:, 2]) & self._rays)
