"""Facades in plan, and the footprints of the blocks behind them.

Facades that go round close to a ring, at the corners where the planes of neighbours meet. Facades in convex
position all round a building, with some missing, have their convex hull. Everything else is a strip of the
stated depth behind every facade: cut off where another facade says that the building ends, filled at corners
that look inwards.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import cast

import numpy as np
import shapely
from shapely.geometry import MultiPoint, Polygon
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float
from frontage.solids.relief import GRID

_CORNER = 3.0  # m that a facade is lengthened or shortened to a corner at most: what a car or a tree hides
_HALF = 0.45  # of its length, too: the next face of a polygon with one face missing lies further away
_PARALLEL = 0.17  # sine between planes that have no corner (10 degrees), but a step
_FLUSH = 0.05  # m: planes of one wall
_BESIDE = 0.3  # m that a facade may stand before the plane of another one in convex position
_ROUND = np.radians(170.0)  # between the directions of neighbours in facades that stand all round
_SLIT = 0.5  # m: half of the gap between strips that is closed, and of the narrowest block
_MITRE = 20.0  # as many times that: how far a pointed corner reaches
_SHORT = 0.002  # m: what is nearer is one; twice the validator's snap tolerance
_GAP = 0.02  # m: a neck so narrow is none
_FAR = 1e4  # m


@dataclass(eq=False)
class Front:
    """A facade in plan: its ends (2, 2) m from left to right as seen from the street, the unit vector (2,)
    into the building, the heights m between which it stands, and its eaves (k, 2) m: along it, up."""

    ends: Float
    inward: Float
    low: float = 0.0
    high: float = 1.0
    eaves: Float = field(default_factory=lambda: np.zeros((0, 2)))
    near: list["Front"] = field(default_factory=list)  # those that meet it at an outer corner

    @property
    def along(self) -> Float:
        """The unit vector (2,) from its left to its right end."""
        return np.array([self.inward[1], -self.inward[0]])

    @property
    def length(self) -> float:
        """m from end to end."""
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))

    def behind(self, points: Float) -> Float:
        """How far behind its plane points (k, 2) are, m."""
        return np.asarray((points - self.ends[0]) @ self.inward, np.float64)

    def strip(self, left: float, right: float, depth: float) -> Polygon:
        """From its plane to `depth` m behind it (before it where negative), between two m along it."""
        a, b = (self.ends[0] + s * self.along for s in (left, right))
        return Polygon([a, b, b + depth * self.inward, a + depth * self.inward])

    def quad(self, depth: float) -> Polygon:
        """The strip of its own length."""
        return self.strip(0.0, self.length, depth)


def footprints(fronts: Sequence[Front], depth: float) -> list[tuple[Polygon, tuple[Front, ...]]]:
    """The blocks in plan, m local, largest first, each with the facades that stand on its border.

    Ends of the facades are moved to their corners. Facades one above the other have blocks of their own.
    """
    found: list[tuple[Polygon, tuple[Front, ...]]] = []
    for group in _storeys(fronts):
        follows = _meet(group, depth)
        for plan in _tidy(_body(group, follows, depth)):
            border = plan.exterior
            own = [f for f in group if border.distance(shapely.Point(f.ends.mean(0))) < _SLIT]
            found.append((plan, tuple(own) or tuple(group)))
    return sorted(found, key=lambda f: -float(f[0].area))


def _storeys(fronts: Sequence[Front]) -> list[list[Front]]:
    """Facades that stand beside each other, by height: a storey that is set back has a block of its own."""
    groups: list[list[Front]] = []
    for front in fronts:
        beside = [g for g in groups if any(_overlap(front, f) for f in g)]
        groups = [g for g in groups if g not in beside] + [[*(f for g in beside for f in g), front]]
    return groups


def _overlap(a: Front, b: Front) -> bool:
    """Whether half of the lower one of two facades stands at the height of the other."""
    return 2 * (min(a.high, b.high) - max(a.low, b.low)) > min(a.high - a.low, b.high - b.low)


def _meet(fronts: Sequence[Front], depth: float) -> dict[int, int]:
    """Move ends to the corners of neighbours, nearest pairs first; who follows whom, counter-clockwise."""
    pairs = [(i, j) for i in range(len(fronts)) for j in range(len(fronts)) if i != j]
    met = [(m, i, j) for i, j in pairs if (m := _corner(fronts[i], fronts[j], depth)) is not None]
    follows: dict[int, int] = {}
    for (_, right, left), i, j in sorted(met, key=lambda m: (m[0][0], m[1], m[2])):
        if i in follows or j in follows.values():
            continue
        follows[i] = j
        fronts[i].ends[1], fronts[j].ends[0] = right, left
        if _cross(fronts[i].along, fronts[j].along) > _PARALLEL:
            fronts[i].near.append(fronts[j])
            fronts[j].near.append(fronts[i])
    return follows


def _corner(one: Front, other: Front, depth: float) -> tuple[float, Float, Float] | None:
    """How far the right end of one facade and the left end of another are from where they meet, m; and where
    the two ends go. None: they do not meet."""
    a, b = one.ends[1], other.ends[0]
    reach = [min(_CORNER, _HALF * f.length) for f in (one, other)]
    if abs(_cross(one.along, other.along)) > _PARALLEL:
        sides = np.array([one.inward @ a, other.inward @ b])
        corner = np.linalg.solve(np.array([one.inward, other.inward]), sides)
        away = [float(np.linalg.norm(p - corner)) for p in (a, b)]
        return None if away[0] > reach[0] or away[1] > reach[1] else (sum(away), corner, corner)
    gap, step = float((b - a) @ one.along), float((b - a) @ one.inward)
    if one.inward @ other.inward < 0 or abs(gap) > min(reach) or abs(step) > depth:
        return None
    if abs(step) < _FLUSH:
        return abs(gap), (a + b) / 2, (a + b) / 2
    return abs(gap) + abs(step), a + gap / 2 * one.along, b - gap / 2 * one.along


def _body(fronts: Sequence[Front], follows: dict[int, int], depth: float) -> BaseGeometry:
    """What stands behind the facades of one group."""
    ring, within = _ring(fronts, follows)
    rest = [f for k, f in enumerate(fronts) if k not in within]
    if ring is not None:
        near = ring.buffer(_CORNER)
        rest = [f for f in rest if not near.covers(MultiPoint(f.ends))]
        return shapely.union_all([ring, *(f.quad(depth).difference(ring) for f in rest)])
    ends = np.concatenate([f.ends for f in fronts])
    inner = np.concatenate([0.75 * f.ends + 0.25 * f.ends[::-1] for f in fronts])  # ends may overshoot
    if all((f.behind(inner) > -_BESIDE).all() for f in fronts):
        body = MultiPoint(ends).convex_hull if _all_round(fronts) else _convex(fronts, ends, depth)
        for front in fronts:
            body = body.intersection(front.strip(-_FAR, _FAR, _FAR))
        return body
    return _strips(fronts, follows, depth)


def _ring(fronts: Sequence[Front], follows: dict[int, int]) -> tuple[Polygon | None, list[int]]:
    """The largest closed ring of facades that follow each other, and their numbers."""
    best, members = None, list[int]()
    for start in follows:
        chain = [start]
        while (after := follows.get(chain[-1], -1)) not in (-1, *chain):
            chain.append(after)
        if after != start or len(chain) < 3:
            continue
        polygon = Polygon(np.concatenate([fronts[k].ends for k in chain]))
        good = polygon.is_valid and polygon.exterior.is_ccw
        if good and (best is None or polygon.area > best.area):
            best, members = polygon, chain
    return best, members


def _all_round(fronts: Sequence[Front]) -> bool:
    """Whether facades look into all directions."""
    turn = np.sort([np.arctan2(f.inward[1], f.inward[0]) for f in fronts])
    return bool(np.diff(np.append(turn, turn[0] + 2 * np.pi)).max() < _ROUND)


def _convex(fronts: Sequence[Front], ends: Float, depth: float) -> BaseGeometry:
    """One facade, or several at outer corners: behind all their planes; no side reaches out behind the
    longest facade's strip further than it was measured."""
    main = max(fronts, key=lambda f: f.length)
    deep = main.behind(ends)
    along = ((ends - main.ends[0]) @ main.along)[(deep > -_BESIDE) & (deep <= depth)]
    parts = [main.strip(float(along.min()), float(along.max()), depth)]
    for front in fronts:
        deepest = max(depth, float(main.behind(front.ends).max()))
        parts.append(front.quad(depth).intersection(main.strip(-_FAR, _FAR, deepest)))
    return shapely.union_all(parts)


def _strips(fronts: Sequence[Front], follows: dict[int, int], depth: float) -> BaseGeometry:
    """A strip behind every facade, without what lies before facades that look another way."""
    parts: list[BaseGeometry] = []
    for front in fronts:
        others = [f.quad(-depth) for f in fronts if f.inward @ front.inward < 0.5]
        strip = front.quad(depth).difference(shapely.union_all(others))
        for other in front.near:
            strip = strip.intersection(other.strip(-_FAR, _FAR, _FAR))
        parts.append(strip)
    for i, j in follows.items():
        one, other = fronts[i], fronts[j]
        cosine = float(one.inward @ other.inward)
        if _cross(one.along, other.along) < -_PARALLEL and cosine > -_HALF:
            corner, both = one.ends[1], one.inward + other.inward
            offsets = np.array(
                [0 * both, depth * one.inward, depth / (1 + cosine) * both, depth * other.inward]
            )
            parts.append(MultiPoint(corner + offsets).convex_hull)
    return shapely.union_all(parts)


def _tidy(body: BaseGeometry) -> list[Polygon]:
    """The parts of a body without slits and fins that are narrower than a metre; as they are where nothing
    else is left. No vertex is so near to a border that the solid's vertices could fall together."""
    closed = _mitred(_mitred(_plain(body), _SLIT), -_SLIT)
    wide = _mitred(_mitred(closed, -_SLIT + _SHORT), _SLIT)
    if not wide.is_empty:
        closed = closed.intersection(wide)
    spikeless = _plain(_mitred(_mitred(closed, -_SHORT), _SHORT))
    parts = [p for p in shapely.get_parts(spikeless) if isinstance(p, Polygon) and p.area > 1.0]
    return [p if _is_sound(p) else _sound(p) for p in parts]


def _mitred(body: BaseGeometry, by: float) -> BaseGeometry:
    return body.buffer(by, join_style="mitre", mitre_limit=_MITRE)


def _plain(body: BaseGeometry) -> BaseGeometry:
    """On the grid, without vertices that a straight line replaces."""
    snapped = shapely.set_precision(shapely.set_precision(body, 1 / GRID).simplify(_SHORT), 1 / GRID)
    return cast(BaseGeometry, shapely.set_precision(snapped, 0.0))  # what follows is not rounded


def _is_sound(part: Polygon) -> bool:
    """Whether its borders stay apart: no hole touches another border, no neck has the width of a point."""
    inner = _mitred(part, -_SHORT)
    return isinstance(inner, Polygon) and len(inner.interiors) == len(part.interiors)


def _sound(part: Polygon) -> Polygon:
    """The largest part without holes of one that touches itself."""
    pieces = shapely.get_parts(_mitred(Polygon(part.exterior), -_GAP))
    largest = _plain(_mitred(max(pieces, key=lambda p: float(p.area)), _GAP / 2))
    return Polygon(shapely.get_exterior_ring(largest))


def _cross(a: Float, b: Float) -> float:
    return float(a[0] * b[1] - a[1] * b[0])
