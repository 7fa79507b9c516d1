"""Which head an opening has: flat, segmental, round, pointed or triangular; rings of all shapes."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.geometry.ring import ring_contains
from frontage.openings.borders.locate import side_scores
from frontage.openings.boxes import Box
from frontage.openings.wall.crossings import CrossingBeams

_GAIN = 10.0  # nats that a curve must gain over a straight head: "very strong" (Kass and Raftery 1995)
_FREE = 5.0  # nats more for a shape whose rise is free
_RISES = np.linspace(0.06, 0.4, 18)  # of segmental heads, as a share of the width
_SLOPES = np.linspace(0.1, 1.0, 19)  # rises of triangular heads, as a share of the width
_EDGE = 0.01  # m beside the sides where beams tell of them, not of the head
_MARGIN = 0.3  # m above the head that is looked at
_ARC = 24  # pieces of a head: chord error 3 mm on a half circle of 2 m
_MOST = 6000  # beams of a head: more tell nothing new
_SQRT3 = float(np.sqrt(3.0))


@dataclass(frozen=True, eq=False)
class Fan:
    """Beams (n,) about an opening: x, z m where each is told to be solid or open; `missing` per m2."""

    x: Float
    z: Float
    solid: Bool
    missing: float

    def part(self, keep: Bool) -> "Fan":
        """Those that `keep` (n,), thinned to what a head needs."""
        k = np.flatnonzero(keep)
        k = k[:: max(len(k) // _MOST, 1)]
        return Fan(self.x[k], self.z[k], self.solid[k], self.missing * len(k) / max(int(keep.sum()), 1))


@dataclass(frozen=True)
class Head:
    """A shape, the height of its top m, its rise m (top less springing), and the nats it gains over flat.

    covariance  (top, rise): their variances and covariance, m2
    """

    shape: str
    top: float
    rise: float
    gain: float
    covariance: tuple[float, float, float] = (0.0, 0.0, 0.0)


def fan_of(
    near: CrossingBeams,
    place: Box,
    *,
    face: float,
    frame: float | None,
    density: float,
    head: tuple[str, float] = ("rectangle", 0.0),
) -> Fan:
    """The beams about an opening as its curved borders see them.

    place, face, frame  x0, z0, x1, z1 m; depth of the solid face beside the head; depth of the frame or None
    density             beams per m2 that a wall sends back there
    head                shape and rise m, as far as known

    As at straight borders (`borders.locate`): a beam that slants outwards ends on the reveal and counts on a
    plane within the wall, the others on the face.
    """
    x0, z0, x1, z1 = place
    seen = (outward(*head, place, near.place) * near.slope).sum(0) > 0
    begin = max(face, 0.0) + near.wall
    back = max(frame - face, 2.0 * near.wall) if frame is not None else 2.0 * near.wall
    x, z = near.shifted(np.where(seen, begin, face))
    free = near.depth >= min(face, 0.0) - near.wall  # what stands before it hides the border
    solid = near.depth <= np.where(seen, begin, face + back / 2)
    box = (x > x0) & (x < x1) & (z > z0) & (z < z1 - 0.3 * (z1 - z0))
    through = float((box & ~solid).sum()) / max(0.7 * (x1 - x0) * (z1 - z0), 1e-6)
    return Fan(x[free], z[free], solid[free], max(density - through, 0.0))


def outward(shape: str, rise: float, place: Box, xz: Float) -> Float:
    """Directions (2, n), of any length, in which the border nearest to xz (2, n) m looks into the wall."""
    x0, z0, x1, z1 = place
    half, middle = (x1 - x0) / 2, (x0 + x1) / 2
    side = np.where(xz[0] < middle, -1.0, 1.0)
    if shape == "triangular":
        found = np.stack([side * rise, np.full(len(side), half)])
    elif shape == "pointed":
        found = xz - np.stack([middle - side * half, np.full(len(side), z1 - _SQRT3 * half)])
    else:
        radius = (half**2 + rise**2) / (2.0 * rise) if shape == "segmental" else half
        low = z1 - radius if shape in ("segmental", "round") else max((z0 + z1) / 2, z1 - radius)
        found = xz - np.array([middle, low])[:, None]
    if rise > 0.0:
        found = np.where(xz[1] < z1 - rise, np.stack([side, np.zeros(len(side))]), found)
    return found


def below(shape: str, rise: float, half: float, u: Float) -> Float:
    """Height (n,) m below the top (negative) at u (n,) m from the middle of a head of that half width.

    Segmental and round heads are arcs of one circle, pointed ones of two whose centres are the springings.
    """
    if shape == "rectangle":
        return np.zeros(len(u))
    v = np.minimum(np.abs(u), half)
    if shape == "triangular":
        return np.asarray(-rise * v / half)
    if shape == "pointed":
        full = 2.0 * half
        return np.asarray(np.sqrt(np.maximum(full**2 - (half + v) ** 2, 0.0)) - np.sqrt(full**2 - half**2))
    radius = (half**2 + rise**2) / (2.0 * rise)
    return np.asarray(np.sqrt(np.maximum(radius**2 - v**2, 0.0)) - radius)


def find_head(fan: Fan, place: Box, blur: float, known: Head | None = None) -> Head:
    """The likeliest head of an opening that was measured as a rectangle `place` x0, z0, x1, z1 m; of one
    whose shape is `known` its top and rise.

    Every beam of its region is on its side of the head, blurred, but for strays; every curve is a shift of
    the beams, so that all tops of one curve are one convolution.
    """
    x0, z0, x1, z1 = place
    half, middle = (x1 - x0) / 2, (x0 + x1) / 2
    low, high = max(z0 + 0.1 * (z1 - z0), z1 - 1.2 * half - _MARGIN), z1 + 0.8 * half + _MARGIN
    near = fan.part((np.abs(fan.x - middle) < half - _EDGE) & (fan.z > low) & (fan.z < high))
    if not near.solid.any() or (near.solid.all() and near.missing <= 0.0):
        return Head("rectangle", z1, 0.0, 0.0)
    tops = np.arange(low + 0.2 * (z1 - low), high - 0.2, 0.002)
    search = _Search(near, middle=middle, half=half, low=low, tops=tops, blur=blur)
    if known is not None:
        rise = max(_rises(known, half, high - z0), key=lambda r: search.best(known.shape, r)[0])
        return search.refined(replace(known, rise=rise, top=search.best(known.shape, rise)[1]))
    flat, top = search.best("rectangle", 0.0)
    found = Head("rectangle", top, 0.0, 0.0)
    trials = [("round", half, 0.0), ("pointed", _SQRT3 * half, 0.0)]
    trials += [("segmental", float(r) * 2 * half, _FREE) for r in _RISES]
    trials += [("triangular", float(r) * 2 * half, _FREE) for r in _SLOPES]
    for shape, rise, price in trials:
        if rise > 0.95 * (high - z0):
            continue
        score, top = search.best(shape, rise)
        # a free rise must beat a fixed one as clearly as a curve beats none
        least = found.gain + (_GAIN if price > 0.0 and found.shape in ("round", "pointed") else 0.0)
        if top - rise > z0 and score - flat - price > max(_GAIN, least):
            found = Head(shape, top, rise, score - flat - price)
    return found if found.shape == "rectangle" else search.refined(found)


def _rises(known: Head, half: float, height: float) -> list[float]:
    """Rises m that a head of known shape may have over an opening of that half width and height m."""
    if known.shape in ("round", "pointed"):
        return [half if known.shape == "round" else _SQRT3 * half]
    free = 2.0 * half * (_RISES if known.shape == "segmental" else _SLOPES)
    return [known.rise, *(float(r) for r in free if r < 0.95 * height)]


class _Search:
    """Scores of heads over the same beams."""

    def __init__(self, fan: Fan, *, middle: float, half: float, low: float, tops: Float, blur: float) -> None:
        solid, opened = np.flatnonzero(fan.solid), np.flatnonzero(~fan.solid)
        order = np.concatenate([solid, opened])
        self._x, self._z, self._solid = fan.x[order] - middle, fan.z[order], len(solid)
        self._missing, self._half, self._blur = fan.missing, half, blur
        self._low, self._tops = low, tops
        self._u = ((np.arange(100) + 0.5) / 50 - 1.0) * half

    def curve(self, shape: str, rise: float, tops: Float) -> Float:
        """Log-likelihood (k,) of heads whose tops are at `tops` (k,) m."""
        middle = float(tops[len(tops) // 2])
        v = middle - self._z + below(shape, rise, self._half, self._x)
        score = side_scores(v[: self._solid], v[self._solid :], middle - tops[::-1], self._blur)
        return np.asarray(score[::-1] + self._missing * self._area(shape, rise, tops))

    def _area(self, shape: str, rise: float, tops: Float) -> Float:
        """Area (k,) m2 within the heads whose tops are at `tops` (k,) m."""
        drop = np.sort(below(shape, rise, self._half, self._u))
        first = np.searchsorted(drop, self._low - tops)
        rest = np.append(np.cumsum(drop[::-1])[::-1], 0.0)[first]
        return np.asarray(rest + (len(drop) - first) * (tops - self._low)) * 2 * self._half / len(drop)

    def best(self, shape: str, rise: float) -> tuple[float, float]:
        """Score and top m of the likeliest head of that shape and rise."""
        score = self.curve(shape, rise, self._tops)
        k = int(score.argmax())
        return float(score[k]), float(self._tops[k])

    def _fine(self, shape: str, rise: float, top: float) -> tuple[float, float, float]:
        """Score, posterior mean m and variance m2 of tops near one."""
        tops: Float = top + np.arange(-24, 25, dtype=np.float64) * 0.0005
        score = self.curve(shape, rise, tops)
        p = np.exp(score - score.max())
        p /= p.sum()
        mean = float(p @ tops)
        return float(score.max()), mean, float(p @ (tops - mean) ** 2)

    def refined(self, head: Head) -> Head:
        """The posterior mean and covariance of top and rise."""
        if head.shape in ("round", "pointed"):
            _, top, variance = self._fine(head.shape, head.rise, head.top)
            return Head(head.shape, top, head.rise, head.gain, (variance, 0.0, 0.0))
        limit = self._half if head.shape == "segmental" else 4.0 * self._half
        rises = np.clip(head.rise + np.linspace(-0.03, 0.03, 19) * 2 * self._half, 0.01, limit)
        found = [self._fine(head.shape, float(r), head.top) for r in rises]
        score, tops, variances = (np.array(c) for c in zip(*found, strict=True))
        p = np.exp(score - score.max())
        p /= p.sum()
        t, r = float(p @ tops), float(p @ rises)
        spread = (float(p @ (variances + (tops - t) ** 2)), float(p @ ((tops - t) * (rises - r))))
        return Head(head.shape, t, r, head.gain, (*spread, float(p @ (rises - r) ** 2)))


def ring_of(shape: str, place: Box, rise: float) -> tuple[Float, Float]:
    """Ring (k, 2) m, counter-clockwise, and how its coordinates (2k,) follow left, right, bottom, top and
    rise: derivatives (2k, 5). Round and pointed heads take their rise from the width.
    """
    start = np.array([place[0], place[2], place[1], place[3], rise])
    steps = 1e-4 * np.eye(5)
    ahead = [(_ring(shape, start + s) - _ring(shape, start - s)).ravel() / 2e-4 for s in steps]
    return _ring(shape, start), np.column_stack(ahead)


def _ring(shape: str, p: Float) -> Float:
    """Ring (k, 2) m of the parameters left, right, bottom, top, rise."""
    x0, x1, z0, z1, rise = (float(v) for v in p)
    half, middle = (x1 - x0) / 2, (x0 + x1) / 2
    if shape == "circle":
        angle = np.arange(2 * _ARC) * np.pi / _ARC
        return np.column_stack([middle + half * np.cos(angle), (z0 + z1) / 2 + (z1 - z0) / 2 * np.sin(angle)])
    rise = {"round": half, "pointed": _SQRT3 * half}.get(shape, rise)
    u = np.linspace(1.0, -1.0, {"rectangle": 2, "triangular": 3}.get(shape, _ARC + 1)) * half
    head = z1 + below(shape, rise, half, u)
    return np.column_stack([np.r_[x0, x1, middle + u], np.r_[z0, z0, head]])


def strays(fan: Fan, ring: Float) -> int:
    """How many beams about an opening are on the wrong side of a ring (k, 2) m."""
    inside = ring_contains(ring, np.column_stack([fan.x, fan.z]))
    return int((inside == fan.solid).sum())
