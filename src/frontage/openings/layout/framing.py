"""Decides which rectangles of open cells can be openings: wall frames them, and beams tell of them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int
from frontage.model.masonry import MASONRY
from frontage.openings.layout.posts import Post, cells_held_by
from frontage.openings.wall.evidence import BARS, LARGEST, SHADED, VISIBLE, WALL, Evidence
from frontage.openings.wall.raster import summed

_RIM_M = 0.1  # width of the strip beside an opening where the wall must show
_FEWEST = 5.0  # expected beams: fewer do not tell whether a rim is wall
_DEEP = 0.3  # share of the expected beams that a small opening must send back from its depth
_DEEP_LARGE = 0.05  # the same share for a large opening, which shows its frame and reveals at least
_DEEP_FREE = 0.1  # the same share of the beams that would be expected if nothing stood before the wall
_MASONRY = 0.8  # share of the expected beams that masonry returns at least
_LARGE_M = 0.6  # least side of an opening that may send back less than a small one
_HIDDEN = 0.3  # share of the beams expected without obstacles below which a rim is hidden
_KNOWN = 0.5  # share of the cells of an opening that must tell something
_EDGE = 2  # cells at the end of an opening that show the wall round the corner
_COURSES = 3  # half bricks of masonry between two openings at least; bars and transoms of joinery are lower
_APART_M = 0.3  # least height of an opening, and so of what a band of masonry leaves above and below
_DIGITS = 6  # of sums over rectangles, which are differences of totals


@dataclass(frozen=True, eq=False)
class _Sums:
    """Sums (n,) of the evidence over rectangles of cells.

    wall      beams that ended on the wall
    expected  beams that a wall would catch; free: those that it would if nothing stood before it
    deep      beams that came back from well behind the wall
    llr       nats for open against solid
    known     cells that tell something
    inside    cells within the facade's outline
    """

    wall: Float
    expected: Float
    free: Float
    deep: Float
    llr: Float
    known: Float
    inside: Float

    @property
    def is_wall(self) -> Bool:
        """Whether the wall shows: enough beams ended on it, or enough where few were expected."""
        enough = np.maximum(self.wall, self.expected) >= _FEWEST
        return np.asarray(enough & (self.wall >= WALL * self.expected))

    @property
    def is_passed(self) -> Bool:
        """Whether more beams went through than ended here, as at dusty panes, which stop some of them."""
        most = self.wall < WALL * (self.wall + self.deep)
        return np.asarray(most & (self.wall < _MASONRY * self.expected))

    @property
    def is_hidden(self) -> Bool:
        """Whether something before the wall hides most of it."""
        return np.asarray(self.expected < _HIDDEN * self.free)

    @property
    def is_visible(self) -> Bool:
        """Whether most beams got as far as the wall."""
        return np.asarray(self.expected > VISIBLE * self.free)

    @property
    def is_not_open(self) -> Bool:
        """Whether the evidence does not speak for open cells."""
        return np.asarray(self.llr <= 0.0)

    @property
    def is_empty(self) -> Bool:
        """Whether no more beams ended on the wall than on bars; wall in the shade of leaves returns more."""
        return np.asarray(self.wall <= SHADED * self.expected)

    @property
    def is_void(self) -> Bool:
        """Whether beams were expected but hardly any came back from the wall or from behind it."""
        return np.asarray((self.expected >= _FEWEST) & (self.wall + self.deep <= BARS * self.expected))

    @property
    def has_depth(self) -> Bool:
        """Whether as many beams came back from behind the wall as a pane, a frame or a room returns."""
        return np.asarray(self.deep > np.maximum(_DEEP * self.expected, _DEEP_FREE * self.free))

    @property
    def has_some_depth(self) -> Bool:
        """Whether some beams came back from behind the wall, as from frames and reveals."""
        return np.asarray(self.deep > _DEEP_LARGE * self.expected)


class Framing:
    """Judges rectangles of cells by sums over the evidence, many of them at once."""

    def __init__(self, evidence: Evidence, ground: float, posts: Sequence[Post] = ()) -> None:
        self._shape = evidence.llr.shape
        self._cell = evidence.raster.cell
        self._rails = summed(
            cells_held_by([post for post in posts if post.level], evidence.raster).astype(float)
        )
        self._ground = int(np.ceil((ground + MASONRY.threshold - evidence.raster.corner[1]) / self._cell))
        self._rays = evidence.rays
        much = evidence.expected + 2.0 * np.sqrt(evidence.expected) + 1.0  # reveals and ledges hold more
        wall = np.minimum(evidence.solid, much)
        known = (evidence.llr != 0.0).astype(np.float64)
        free, inside = evidence.expected_free, evidence.inside.astype(np.float64)
        layers = (wall, evidence.expected, free, evidence.deep, evidence.llr, known, inside)
        totals = np.empty((self._shape[0] + 1, self._shape[1] + 1, len(layers)))
        for k, layer in enumerate(layers):
            totals[..., k] = summed(layer)
        self._totals = totals.reshape(-1, len(layers))

    def __call__(self, boxes: Int) -> Bool:
        """Returns which boxes (n, 4) r0, c0, r1, c1 can be openings (n,).

        A rectangle without wall on one side is not an opening. The wall must show on both sides and above or
        below, except below near the ground; with known sensors, one side may be hidden by something before
        the wall. One side may lie beyond the end of the facade, where a window goes round the corner or up
        to the next wall in an inner corner, and wall must show above and below. Without known sensors, the
        opening must then be empty, and no opening reaches up to the end of the facade: between pinnacles
        there is sky. The rectangle itself must be free of wall, or passed by most beams with wall above and
        below, and known in half of its cells, and beams must come back from its depth. A visible rectangle
        may do with less depth (`_is_framed_all_round`), for glass returns as little as a shadow does; but
        shadows are small, or run on past the rim. Without lines of sight, masonry from side to side makes
        two openings of it, and no band in it may be empty beyond both jambs as well.
        """
        rim = max(int(np.ceil(_RIM_M / self._cell)), 2)
        framed, at_corner = self._is_beside_wall(boxes, rim)
        boxes, at_corner = boxes[framed], at_corner[framed]
        rims = self._rims(boxes, rim)
        ends = self._ends(boxes, rims)
        ended = np.where(at_corner, ends.all(0), ends.any(0))
        if not self._rays:
            ended &= ~at_corner | self._sums(boxes).is_empty
            ended &= ends[0] | rims[1].is_hidden | ~self._is_at_top(boxes)
        boxes = boxes[ended]
        framed[framed] = ended
        rims, inside = self._rims(boxes, rim), self._sums(boxes)
        core = self._sums(boxes + np.array([1, 1, -1, -1]))
        bare = ~core.is_wall | (core.is_passed & self._ends(boxes, rims).all(0))
        known = inside.known > _KNOWN * (boxes[:, 2] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 1])
        shown = inside.has_depth | (inside.is_visible & self._is_framed_all_round(boxes, inside, rims, rim))
        whole = bare & known & shown
        whole[whole] = ~(self._is_parted(boxes[whole]) | self._holds_void(boxes[whole], rim))
        framed[framed] = whole
        return framed

    def _is_parted(self, boxes: Int) -> Bool:
        """Returns which boxes (n,) are two openings, one above the other, with level masonry between them.

        Rooms that are scanned through two openings seem to go on behind the band; known lines of sight show
        that they do not. The middle third of the band tells, for beside a curved head there is wall as well.
        """
        parted, run = np.zeros(len(boxes), np.bool_), np.zeros(len(boxes), np.int64)
        if self._rays:
            return parted
        course, apart = (max(round(size / self._cell), 1) for size in (MASONRY.half_brick, _APART_M))
        third = np.array([0, 1, 0, -1]) * ((boxes[:, 3] - boxes[:, 1]) // 3)[:, None]
        for own, band in _bands(boxes + third, course, course, apart, parted):
            run[own] = np.where(self._sums(band).is_wall, run[own] + 1, 0)
            parted[own] = run[own] >= _COURSES
        return parted

    def _is_beside_wall(self, boxes: Int, rim: int) -> tuple[Bool, Bool]:
        """Returns whether the wall shows on both sides (n,), and whether one lies beyond the facade (n,).

        On cells wider than a rim, the nearest cell counts by itself too, for the next may lie beyond a narrow
        pier. With known sensors, one side may be hidden or lie beyond the facade. Without them, it may lie
        there where the end of the opening shows the next wall, round an inner corner. A ribbon window may go
        on round a corner within the outline, where its other wall has a ribbon as well.
        """
        sums = self._beside(boxes, rim)
        sides = np.stack([side.is_wall for side in sums])
        if self._cell > _RIM_M:
            sides |= np.stack([side.is_wall for side in self._beside(boxes, 1)])
        hidden = np.stack([side.is_hidden & self._rays for side in sums])
        cells = rim * (boxes[:, 2] - boxes[:, 0])
        beyond = np.stack([side.inside < _KNOWN * cells for side in sums]) & ~sides
        if not self._rays:
            some = beyond.any(0)
            edges = self._beside(boxes[some] + np.array([0, _EDGE, 0, -_EDGE]), _EDGE)
            beyond[:, some] &= np.stack([edge.is_wall for edge in edges])
        beyond |= ~sides & ((boxes[:, 3] - boxes[:, 1]) * self._cell > LARGEST)
        framed = (sides | hidden | beyond).all(0) & sides.any(0)
        return np.asarray(framed), np.asarray(beyond.any(0))

    def _ends(self, boxes: Int, rims: tuple[_Sums, ...]) -> Bool:
        """Returns whether the wall shows above and below (2, n).

        It need not show where a rail of joinery runs along most of that border, nor below near the ground.
        """
        below, above = rims
        r0, c0, r1, c1 = boxes.T
        stands = (r0 < self._ground) | self._is_at_rail(r0, c0, c1)
        return np.stack([above.is_wall | self._is_at_rail(r1, c0, c1), below.is_wall | stands])

    def _is_at_top(self, boxes: Int) -> Bool:
        """Returns which boxes (n,) reach up to the end of the facade, or have no wall between it and them."""
        _, c0, r1, c1 = boxes.T
        high = max(int(_APART_M / self._cell), 1)
        near = self._sums(np.stack([r1, c0, r1 + high, c1], 1))
        above = self._sums(np.stack([r1 + 1, c0, np.full(len(r1), self._shape[0]), c1], 1))
        return np.asarray((near.inside < _KNOWN * high * (c1 - c0)) | (above.wall <= BARS * above.expected))

    def _holds_void(self, boxes: Int, rim: int) -> Bool:
        """Returns which boxes (n,) contain a band without returns that continues beyond both jambs.

        Sign boards that were cut out of the scan and dark panels leave such bands, and no jamb bounds them. A
        band at the foot of a box does not count, because what stands before a wall hides its foot. With known
        sensors nothing is asked.
        """
        found, shows = np.zeros(len(boxes), np.bool_), np.zeros(len(boxes), np.bool_)
        if self._rays:
            return found
        high = max(int(_APART_M / self._cell), 1)
        for own, band in _bands(boxes, high, (high + 1) // 2, 0, found):
            is_void = self._sums(band).is_void
            is_void[is_void] = np.all([side.is_void for side in self._beside(band[is_void], rim)], axis=0)
            found[own] = shows[own] & is_void
            shows[own] |= ~is_void
        return found

    def _is_at_rail(self, row: Int, c0: Int, c1: Int) -> Bool:
        """Returns whether a rail lies within two cells of a row (n,) in most of its columns [c0, c1)."""
        low, high = (np.clip(row + k, 0, self._shape[0]) for k in (-2, 2))
        c0, c1 = (np.clip(c, 0, self._shape[1]) for c in (c0, c1))
        held = self._rails[high, c1] - self._rails[low, c1] - self._rails[high, c0] + self._rails[low, c0]
        return np.asarray(held > _KNOWN * (c1 - c0))

    def _is_framed_all_round(self, boxes: Int, inside: _Sums, rims: tuple[_Sums, ...], rim: int) -> Bool:
        """Returns which boxes can be openings although little comes back from their depth.

        Large ones that show some depth and do not run on above or below; those with wall above and below that
        are large, where the sensors are known; and where they are not, those with wall above and below that
        begin sharply and are large or show some depth. Without known sensors, no wall may shine through, as
        it does in the shade of leaves.
        """
        below, above = rims
        ends, some = self._ends(boxes, rims), inside.has_some_depth
        sides = np.minimum(boxes[:, 2] - boxes[:, 0], boxes[:, 3] - boxes[:, 1])
        large = sides * self._cell > _LARGE_M
        shut = (ends | np.stack([above.is_not_open, below.is_not_open])).all(0)
        if self._rays:
            return np.asarray((large & shut & some) | (ends.all(0) & large))
        sure = self._is_sharp(boxes, rim) & (large | some)
        return np.asarray(((large & shut & some) | (ends.all(0) & sure)) & inside.is_empty)

    def _is_sharp(self, boxes: Int, rim: int) -> Bool:
        """Returns whether hardly any wall shows within `rim` cells inside of each border (n,).

        Shadows of leaves, and patches that return little, have ragged edges through which the wall shines; an
        opening whose frame is not seen is empty right from its borders.
        """
        r0, c0, r1, c1 = boxes.T + np.array([[1], [1], [-1], [-1]])
        wide = np.clip(np.minimum(r1 - r0, c1 - c0) // 2, 1, rim)
        strips = [(r0, c0, r1, c0 + wide), (r0, c1 - wide, r1, c1)]
        strips += [(r0, c0, r0 + wide, c1), (r1 - wide, c0, r1, c1)]
        sums = [self._sums(np.stack(strip, 1)) for strip in strips]
        return np.asarray(np.all([s.wall <= BARS * s.expected for s in sums], axis=0))

    def _beside(self, boxes: Int, rim: int) -> tuple[_Sums, ...]:
        """Returns the sums over the strips on the left and on the right, one cell off."""
        r0, c0, r1, c1 = boxes.T
        left, right = (r0, c0 - 1 - rim, r1, c0 - 1), (r0, c1 + 1, r1, c1 + 1 + rim)
        return tuple(self._sums(np.stack(strip, 1)) for strip in (left, right))

    def _rims(self, boxes: Int, rim: int) -> tuple[_Sums, ...]:
        """Returns the sums over the strips below and above, one cell off."""
        r0, c0, r1, c1 = boxes.T
        below, above = (r0 - 1 - rim, c0, r0 - 1, c1), (r1 + 1, c0, r1 + 1 + rim, c1)
        return tuple(self._sums(np.stack(strip, 1)) for strip in (below, above))

    def _sums(self, boxes: Int) -> _Sums:
        """Returns the sums over boxes (n, 4) r0, c0, r1, c1, as far as they lie on the raster."""
        r0, r1 = np.clip(boxes[:, 0], 0, self._shape[0]), np.clip(boxes[:, 2], 0, self._shape[0])
        c0, c1 = np.clip(boxes[:, 1], 0, self._shape[1]), np.clip(boxes[:, 3], 0, self._shape[1])
        s, wide = self._totals, self._shape[1] + 1
        sums = s[r1 * wide + c1] - s[r0 * wide + c1] - s[r1 * wide + c0] + s[r0 * wide + c0]
        return _Sums(*np.round(sums, _DIGITS).T.copy())  # sums of nothing are zero, and ties stay ties


def _bands(boxes: Int, high: int, step: int, margin: int, done: Bool) -> Iterator[tuple[Int, Int]]:
    """Yields bands of boxes (n, 4), the lowest first: the numbers (k,) of the boxes and the bands (k, 4).

    Bands are `high` cells high, and at least `margin` cells off both ends of their boxes; they begin every
    `step` cells. Boxes (n,) that are `done` by then have no more of them.
    """
    first, last = boxes[:, 0] + margin, boxes[:, 2] - margin - high
    for start in range(0, int((last - first).max(initial=-1)) + 1, step):
        own = np.flatnonzero(~done & (first + start <= last))
        band = boxes[own]
        band[:, 0] = first[own] + start
        band[:, 2] = band[:, 0] + high
        yield own, band
