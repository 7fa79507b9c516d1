"""Tells the head of an opening (flat, segmental, round, pointed, triangular), and makes rings of shapes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.ring import ring_contains
from frontage.openings.borders.fan import RISE_OF_POINTED, Fan
from frontage.openings.borders.scores import STRAY, blurred_scores
from frontage.openings.boxes import Box

_GAIN = 10.0  # nats that a curve must gain over a straight head: "very strong" (Kass and Raftery 1995)
_FREE = 5.0  # nats more for a shape whose rise is free
_RISES = np.linspace(0.06, 0.4, 18)  # rises of segmental heads, as a share of the width
_SLOPES = np.linspace(0.1, 1.0, 19)  # rises of triangular heads, as a share of the width
_EDGE = 0.01  # m beside the sides where beams determine the sides, not the head
_MARGIN = 0.3  # m above the head that is looked at
_ARC = 24  # pieces of a head: chord error 3 mm on a half circle of 2 m
_STRIPS = 24  # borders that the shadow of a post may have, over the width of a head


@dataclass(frozen=True)
class Head:
    """The head of an opening.

    shape       its name
    top         m, height z of the top
    rise        m, top less springing
    gain        nats over a flat head
    covariance  m2: variance of the top, covariance of top and rise, variance of the rise
    """

    shape: str
    top: float
    rise: float
    gain: float
    covariance: tuple[float, float, float] = (0.0, 0.0, 0.0)


def below(shape: str, rise: float, half: float, u: Float) -> Float:
    """Returns the height (n,) m relative to the top (negative) at u (n,) m from the middle of a head.

    `half` m is half its width. Segmental and round heads are arcs of one circle, pointed ones arcs of two
    circles whose centres are the springings.
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
    """Finds the likeliest head of an opening measured as a rectangle; of a `known` shape, top and rise.

    Every beam of its region is on its side of the head, blurred, except for strays. A curve is a shift of the
    beams, so all tops of one curve are scored by one convolution.
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
        rises = _rises(known, half, high - z0)
        found_at = search.best([(known.shape, r) for r in rises])
        best = max(range(len(rises)), key=lambda k: found_at[k][0])
        return search.refined(replace(known, rise=rises[best], top=found_at[best][1]))
    trials = [("round", half), ("pointed", RISE_OF_POINTED * half)]
    trials += [("segmental", float(r) * 2 * half) for r in _RISES]
    trials += [("triangular", float(r) * 2 * half) for r in _SLOPES]
    trials = [("rectangle", 0.0), *((shape, rise) for shape, rise in trials if rise <= 0.95 * (high - z0))]
    (flat, top), *curved = search.best(trials)
    found = Head("rectangle", top, 0.0, 0.0)
    for (shape, rise), (score, top) in zip(trials[1:], curved, strict=True):
        price = _FREE if shape in ("segmental", "triangular") else 0.0
        # a free rise must beat a fixed one as clearly as a curve beats none
        least = found.gain + (_GAIN if price > 0.0 and found.shape in ("round", "pointed") else 0.0)
        if top - rise > z0 and score - flat - price > max(_GAIN, least):
            found = Head(shape, top, rise, score - flat - price)
    if found.shape == "rectangle":
        return found
    score, top = search.shadowed(found.top)
    if score - flat - _GAIN > found.gain:
        return Head("rectangle", top, 0.0, 0.0)
    return search.refined(found)


def _rises(known: Head, half: float, height: float) -> list[float]:
    """Returns the rises m that a head of known shape may have; `half` width and `height` of the opening m."""
    if known.shape in ("round", "pointed"):
        return [half if known.shape == "round" else RISE_OF_POINTED * half]
    free = 2.0 * half * (_RISES if known.shape == "segmental" else _SLOPES)
    return [known.rise, *(float(r) for r in free if r < 0.95 * height)]


class _Search:
    """Scores heads over the same beams."""

    def __init__(self, fan: Fan, *, middle: float, half: float, low: float, tops: Float, blur: float) -> None:
        solid, opened = np.flatnonzero(fan.solid), np.flatnonzero(~fan.solid)
        order = np.concatenate([solid, opened])
        self._x, self._z, self._solid = fan.x[order] - middle, fan.z[order], len(solid)
        self._missing, self._half, self._blur = fan.missing, half, blur
        self._low, self._tops = low, tops
        self._u = ((np.arange(100) + 0.5) / 50 - 1.0) * half

    def curves(self, heads: Sequence[tuple[str, float]], tops: Float) -> Float:
        """Returns the log-likelihood (h, k) of heads of a shape and rise m, with tops at `tops` (k,) m."""
        middle = float(tops[len(tops) // 2])
        below_middle = middle - self._z
        beams = [below_middle + below(*head, self._half, self._x) for head in heads]
        pairs = [(v[: self._solid], v[self._solid :]) for v in beams]
        score = blurred_scores(pairs, middle - tops[::-1], (self._blur,), (STRAY, STRAY))[0, :, ::-1]
        if self._missing > 0.0:
            score = score + self._missing * self._areas(heads, tops)
        return np.asarray(score)

    def _areas(self, heads: Sequence[tuple[str, float]], tops: Float) -> Float:
        """Returns the area (h, k) m2 within heads of a shape and rise m, with tops at `tops` (k,) m."""
        drop = np.sort([below(*head, self._half, self._u) for head in heads], axis=1)
        first = np.stack([d.searchsorted(self._low - tops) for d in drop])
        rest = np.pad(drop[:, ::-1].cumsum(1)[:, ::-1], ((0, 0), (0, 1)))
        parts = drop.shape[1]
        above = np.take_along_axis(rest, first, 1) + (parts - first) * (tops - self._low)
        return np.asarray(above * 2 * self._half / parts)

    def shadowed(self, high: float) -> tuple[float, float]:
        """Returns the score and the top m of the likeliest flat head with an empty strip above it.

        The strip is the shadow of something upright before the wall, such as a post. If it is taken for a
        part of the opening, the head seems to be curved and to end at `high` m.
        """
        flat = self.curves([("rectangle", 0.0)], self._tops)[0]
        column = ((self._x[: self._solid] / self._half + 1.0) * _STRIPS / 2).astype(np.int64)
        row = np.searchsorted(self._tops, self._z[: self._solid])  # of tops below the point
        held = np.zeros((len(self._tops) + 1, _STRIPS + 1))
        np.add.at(held, (row, np.clip(column, 0, _STRIPS - 1) + 1), 1.0)
        left = held[::-1].cumsum(0)[::-1][1:].cumsum(1)  # points above each top, left of each border
        left -= left[np.searchsorted(self._tops, high, "right") - 1]  # up to the head's own top
        first, last = np.triu_indices(_STRIPS + 1, 1)
        wide = (last - first) * 2 * self._half / _STRIPS
        points = left[:, last] - left[:, first]
        gain = self._missing * wide * (high - self._tops)[:, None] + np.log(STRAY) * points
        score = np.where(self._tops <= high, flat + gain.max(1), -np.inf)
        return float(score.max()), float(self._tops[score.argmax()])

    def best(self, heads: Sequence[tuple[str, float]]) -> list[tuple[float, float]]:
        """Returns the score and the top m of the likeliest head of every shape and rise m."""
        score = self.curves(heads, self._tops)
        return [(float(s[k]), float(self._tops[k])) for s, k in zip(score, score.argmax(1), strict=True)]

    def _fine(self, shape: str, rises: Sequence[float], top: float) -> tuple[Float, Float, Float]:
        """Returns the score, and the posterior mean m and variance m2, of tops near `top` for every rise."""
        tops: Float = top + np.arange(-24, 25, dtype=np.float64) * 0.0005
        score = self.curves([(shape, rise) for rise in rises], tops)
        best = score.max(1)
        p = np.exp(score - best[:, None])
        p /= p.sum(1, keepdims=True)
        mean = p @ tops
        return best, mean, (p * (tops - mean[:, None]) ** 2).sum(1)

    def refined(self, head: Head) -> Head:
        """Returns the head with the posterior mean and covariance of top and rise."""
        if head.shape in ("round", "pointed"):
            _, (top,), (variance,) = self._fine(head.shape, [head.rise], head.top)
            return Head(head.shape, float(top), head.rise, head.gain, (float(variance), 0.0, 0.0))
        limit = self._half if head.shape == "segmental" else 4.0 * self._half
        rises = np.clip(head.rise + np.linspace(-0.03, 0.03, 19) * 2 * self._half, 0.01, limit)
        score, tops, variances = self._fine(head.shape, rises.tolist(), head.top)
        p = np.exp(score - score.max())
        p /= p.sum()
        t, r = float(p @ tops), float(p @ rises)
        spread = (float(p @ (variances + (tops - t) ** 2)), float(p @ ((tops - t) * (rises - r))))
        return Head(head.shape, t, r, head.gain, (*spread, float(p @ (rises - r) ** 2)))


def bare_ring(shape: str, place: Box, rise: float) -> Float:
    """Returns the ring (k, 2) m of a shape as `ring_of` does, without its derivatives."""
    return _ring(shape, np.array([place[0], place[2], place[1], place[3], rise]))


def ring_of(shape: str, place: Box, rise: float) -> tuple[Float, Float]:
    """Returns the ring (k, 2) m, counter-clockwise, of a shape, and its derivatives (2k, 5).

    The derivatives are of its coordinates by left, right, bottom, top and rise. Round and pointed heads take
    their rise from the width.
    """
    start = np.array([place[0], place[2], place[1], place[3], rise])
    steps = 1e-4 * np.eye(5)
    ahead = [(_ring(shape, start + s) - _ring(shape, start - s)).ravel() / 2e-4 for s in steps]
    return _ring(shape, start), np.column_stack(ahead)


def _ring(shape: str, p: Float) -> Float:
    """Returns the ring (k, 2) m of the parameters left, right, bottom, top, rise."""
    x0, x1, z0, z1, rise = (float(v) for v in p)
    half, middle = (x1 - x0) / 2, (x0 + x1) / 2
    if shape == "circle":
        angle = np.arange(2 * _ARC) * np.pi / _ARC
        return np.column_stack([middle + half * np.cos(angle), (z0 + z1) / 2 + (z1 - z0) / 2 * np.sin(angle)])
    rise = {"round": half, "pointed": RISE_OF_POINTED * half}.get(shape, rise)
    u = np.linspace(1.0, -1.0, {"rectangle": 2, "triangular": 3}.get(shape, _ARC + 1)) * half
    head = z1 + below(shape, rise, half, u)
    return np.column_stack([np.concatenate([[x0, x1], middle + u]), np.concatenate([[z0, z0], head])])


def strays(fan: Fan, ring: Float) -> int:
    """Counts the beams about an opening that are on the wrong side of a ring (k, 2) m."""
    inside = ring_contains(ring, np.column_stack([fan.x, fan.z]))
    return int((inside == fan.solid).sum())
