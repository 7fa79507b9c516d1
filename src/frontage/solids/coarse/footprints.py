"""Footprints of the blocks behind facades.

Facades that surround a building give the ring through their corners. Facades in convex position on all sides,
with some missing, give their convex hull. All others give a strip of the stated depth behind every facade,
cut off where another facade ends the building and filled at inner corners.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import LineString, MultiPoint, Polygon
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float
from frontage.solids.coarse.corners import OVERSHOOT_M, PARALLEL_SINE, REACH_M, move_ends_to_corners
from frontage.solids.coarse.plan_facade import PlanFacade, cross2d
from frontage.solids.coarse.tidy import SLIT_M, tidy_footprints

_FRONT_OF_M = 0.3  # in convex position, a facade may stand this far in front of the plane of another one
_ALL_ROUND = np.radians(170.0)  # largest angle between neighbouring directions of facades on all sides
_OVER_SHARE = 0.25  # share of its length by which a facade is measured too long at most
_SIMILAR_COSINE = 0.5  # facades that differ by less than 60 degrees do not cut off each other's strips
_FILLED_COSINE = -0.45  # inner corners are filled unless the two facades look towards each other
_UNBOUNDED_M = 1e4


def footprints(facades: Sequence[PlanFacade], depth: float) -> list[tuple[Polygon, tuple[PlanFacade, ...]]]:
    """Returns the blocks in plan (m local), largest first, each with the facades that stand on its border.

    Blocks are `depth` m deep where the facades leave them open. Moves the ends of the facades to their
    corners. Facades one above the other get blocks of their own.
    """
    found: list[tuple[Polygon, tuple[PlanFacade, ...]]] = []
    for group in _same_height_groups(facades):
        follows = move_ends_to_corners(group, depth)
        for plan in tidy_footprints(_area_behind(group, follows, depth)):
            border = plan.exterior
            own = [f for f in group if border.distance(shapely.Point(f.ends.mean(0))) < SLIT_M]
            found.append((plan, tuple(own) or tuple(group)))
    return sorted(found, key=lambda f: -float(f[0].area))


def _same_height_groups(facades: Sequence[PlanFacade]) -> list[list[PlanFacade]]:
    """Groups facades whose heights overlap: a storey that is set back gets a block of its own."""
    groups: list[list[PlanFacade]] = []
    for facade in facades:
        beside = [g for g in groups if any(_heights_overlap(facade, f) for f in g)]
        groups = [g for g in groups if g not in beside] + [[*(f for g in beside for f in g), facade]]
    return groups


def _heights_overlap(a: PlanFacade, b: PlanFacade) -> bool:
    """Decides whether half of the lower facade stands at the height of the other."""
    return 2 * (min(a.high, b.high) - max(a.low, b.low)) > min(a.high - a.low, b.high - b.low)


def _area_behind(facades: Sequence[PlanFacade], follows: dict[int, int], depth: float) -> BaseGeometry:
    """Returns the area behind the facades of one group."""
    ring, members = _largest_ring(facades, follows)
    rest = [f for k, f in enumerate(facades) if k not in members]
    if ring is not None:
        near = ring.buffer(REACH_M)
        rest = [f for f in rest if not near.covers(MultiPoint(f.ends))]
        return shapely.union_all([ring, *(f.own_strip(depth).difference(ring) for f in rest)])
    if _in_convex_position(facades):
        ends = np.concatenate([f.ends for f in facades])
        body = MultiPoint(ends).convex_hull if _on_all_sides(facades) else _open_convex(facades, ends, depth)
        for facade in facades:
            body = body.intersection(facade.strip(-_UNBOUNDED_M, _UNBOUNDED_M, _UNBOUNDED_M))
        return body
    return _strips(facades, follows, depth)


def _largest_ring(facades: Sequence[PlanFacade], follows: dict[int, int]) -> tuple[Polygon | None, list[int]]:
    """Returns the largest closed ring of facades that follow each other, and their indices."""
    best, members = None, list[int]()
    for start in follows:
        chain = [start]
        while (after := follows.get(chain[-1], -1)) not in (-1, *chain):
            chain.append(after)
        if after != start or len(chain) < 3:
            continue
        polygon = Polygon(np.concatenate([facades[k].ends for k in chain]))
        good = polygon.is_valid and polygon.exterior.is_ccw
        if good and (best is None or polygon.area > best.area):
            best, members = polygon, chain
    return best, members


def _in_convex_position(facades: Sequence[PlanFacade]) -> bool:
    """Decides whether every facade lies behind the planes of all others, its ends excepted."""
    over = [min(OVERSHOOT_M, _OVER_SHARE * f.length) for f in facades]
    inner = np.concatenate(
        [f.ends + o * np.array([f.along, -f.along]) for f, o in zip(facades, over, strict=True)]
    )
    return all((f.depth_of(inner) > -_FRONT_OF_M).all() for f in facades)


def _on_all_sides(facades: Sequence[PlanFacade]) -> bool:
    """Decides whether facades look in all directions."""
    turn = np.sort([np.arctan2(f.inward[1], f.inward[0]) for f in facades])
    return bool(np.diff(np.append(turn, turn[0] + 2 * np.pi)).max() < _ALL_ROUND)


def _open_convex(facades: Sequence[PlanFacade], ends: Float, depth: float) -> BaseGeometry:
    """Returns the area behind one facade, or behind several that meet at outer corners.

    Behind the strip of the longest facade, no side reaches further than it was measured.
    """
    longest = max(facades, key=lambda f: f.length)
    deep = longest.depth_of(ends)
    along = ((ends - longest.ends[0]) @ longest.along)[(deep > -_FRONT_OF_M) & (deep <= depth)]
    parts = [longest.strip(float(along.min()), float(along.max()), depth)]
    for facade in facades:
        deepest = max(depth, float(longest.depth_of(facade.ends).max()))
        parts.append(
            facade.own_strip(depth).intersection(longest.strip(-_UNBOUNDED_M, _UNBOUNDED_M, deepest))
        )
    return shapely.union_all(parts)


def _strips(facades: Sequence[PlanFacade], follows: dict[int, int], depth: float) -> BaseGeometry:
    """Returns strips behind all facades and inner corners, without the open space before other facades."""
    parts: list[BaseGeometry] = []
    for facade in facades:
        strip = _without_open_space(facade.own_strip(depth), [facade], facades, depth)
        for other in facade.corner_neighbours:
            strip = strip.intersection(other.strip(-_UNBOUNDED_M, _UNBOUNDED_M, _UNBOUNDED_M))
        parts.append(strip)
    for i, j in follows.items():
        one, other = facades[i], facades[j]
        cosine = float(one.inward @ other.inward)
        if cross2d(one.along, other.along) < -PARALLEL_SINE and cosine > _FILLED_COSINE:
            parts.append(
                _without_open_space(_inner_corner(one, other, depth, cosine), [one, other], facades, depth)
            )
    return shapely.union_all(parts)


def _without_open_space(
    area: BaseGeometry, own: Sequence[PlanFacade], facades: Sequence[PlanFacade], depth: float
) -> BaseGeometry:
    """Returns an area behind some facades without the space before facades that look another way.

    That is all the space before a facade if all of `own` stand behind its plane. Otherwise, it is `depth` m
    of open space, and none where one of `own` stands in it, because the space ends there.
    """
    for other in facades:
        if any(f.inward @ other.inward >= _SIMILAR_COSINE or _stands_before(f, other, depth) for f in own):
            continue
        behind = all((other.depth_of(f.ends) > -_FRONT_OF_M).all() for f in own)
        reach = _UNBOUNDED_M if behind else 0.0
        area = area.difference(other.strip(-reach, other.length + reach, -(reach or depth)))
    return area


def _stands_before(facade: PlanFacade, other: PlanFacade, depth: float) -> bool:
    """Decides whether more than the end of a facade stands in the space before another one."""
    before = other.strip(-OVERSHOOT_M, other.length + OVERSHOOT_M, -depth)
    inside = LineString(facade.ends).intersection(before)
    return bool(inside.length > OVERSHOOT_M)


def _inner_corner(one: PlanFacade, other: PlanFacade, depth: float, cosine: float) -> BaseGeometry:
    """Returns the kite that fills the inner corner between the strips of two facades, up to its mitre."""
    corner, both = one.ends[1], one.inward + other.inward
    offsets = np.array([0 * both, depth * one.inward, depth / (1 + cosine) * both, depth * other.inward])
    return MultiPoint(corner + offsets).convex_hull
