"""Ground plans with the storeys that jut out over them, as measured facades show them.

The ground polygon of a city model leaves out what stands over an arcade, a passage or a deep entrance. A
block over it has no wall there, and openings of the storeys above would have no host.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float
from frontage.model.masonry import MASONRY
from frontage.solids.brep import GRID_PER_M
from frontage.solids.coarse.plan_facade import PlanFacade
from frontage.solids.coarse.tidy import borders_are_apart, buffered, simplified
from frontage.solids.options import BuildOptions

_SLIT_M = 0.01  # m, half the width of slits that are closed
_FIN_M = 0.05  # m, half the width of what juts out, at least: less is an error of the plan
_LOST_M = 0.5  # m of wall that another facade may lose
_LEAST_M2 = 0.05  # m2 of plan, 5 cm over a metre: less is an error of the plan
_MOST = 0.5  # share of an area that counts as most of it
_LEVEL_M = 0.3  # m between the feet of storeys that are one: beams and the edges of soffits
_ROUNDS = 2  # a front at a corner may reach over what another one has added


@dataclass(frozen=True, eq=False)
class Storey:
    """A part of a block with one plan (m local), from its foot (m local) to the next storey or the roof."""

    foot: float
    plan: Polygon


def storeys_over(
    plan: Polygon,
    ground: float,
    facades: Sequence[PlanFacade],
    options: BuildOptions,
    beside: BaseGeometry | None = None,
) -> tuple[Storey, ...]:
    """Returns the storeys of a block over a ground plan (m local), extended to the measured facades.

    Each plan contains the one below. A facade on a wall of the plan makes it reach up to the line of that
    wall, from the `ground` (m local) up. A front without such a wall, on which openings were found, makes it
    reach up to its own plane: from the ground up where it stands on it, else from its foot up, so that people
    pass under it. `beside` is the area of other parts of the building, which stay free.
    """
    bodies = {f: body for f in facades if (body := _body(plan, f, facades, options)) is not None}
    feet = {f: _foot(f, facades, options) for f in bodies}
    hanging = [f for f in bodies if feet[f] - ground >= MASONRY.door_height]
    growing = _Growing(facades, bodies, options, Polygon() if beside is None else beside)
    storeys = [Storey(ground, growing.plan(plan, [f for f in facades if f not in hanging]))]
    for level in _levels(hanging, feet):
        foot, below = feet[level[0]], storeys[-1].plan
        above = [f for f in facades if (f.low + f.high) / 2 > foot]
        wide = _over(below, replace(growing, facades=above).plan(below, level))
        if wide is not None:
            storeys.append(Storey(foot, wide))
    return tuple(storeys)


def _foot(facade: PlanFacade, facades: Sequence[PlanFacade], options: BuildOptions) -> float:
    """Returns the height (m) from which a facade needs a wall.

    That is its lower border, or the foot of its lowest opening. But a soffit lies above the openings of the
    walls that were seen under it, and the thinnest lintel over them.
    """
    if facade.held is None:
        return facade.foot
    under = [f.held[3] for f in facades if f.held is not None and _shared(facade, f, options) > 0.0]
    heads = [head + MASONRY.half_brick for head in under if head < facade.foot]
    return min(facade.foot, max([facade.held[1], *heads]))


def _levels(facades: Sequence[PlanFacade], feet: Mapping[PlanFacade, float]) -> list[list[PlanFacade]]:
    """Groups facades whose `feet` are at one height, lowest first."""
    levels: list[list[PlanFacade]] = []
    for facade in sorted(facades, key=feet.__getitem__):
        if levels and feet[facade] - feet[levels[-1][0]] < _LEVEL_M:
            levels[-1].append(facade)
        else:
            levels.append([facade])
    return levels


@dataclass(frozen=True, eq=False)
class _Growing:
    """Makes plans reach up to facades.

    facades  whose walls must not disappear
    bodies   fronts that jut out, and the areas behind their openings
    beside   the area that stays free
    """

    facades: Sequence[PlanFacade]
    bodies: Mapping[PlanFacade, Polygon]
    options: BuildOptions
    beside: BaseGeometry

    def plan(self, plan: Polygon, fronts: Sequence[PlanFacade]) -> Polygon:
        """Returns a plan that reaches up to `fronts`, as far as no other facade loses its wall."""
        for _ in range(_ROUNDS):
            earlier = plan
            for front in fronts:
                plan = self._reaching(plan, front)
            if plan is earlier:
                break
        return plan

    def _reaching(self, plan: Polygon, front: PlanFacade) -> Polygon:
        """Returns a plan that reaches up to a front.

        It stays as it is where it would fall apart or where a wall would disappear that another facade was
        measured on, unless that one was seen through the openings of a front that juts out.
        """
        others = [f for f in self.facades if f is not front]
        if front in self.bodies:
            more = _before(plan, front).union(self.bodies[front])
            others = [f for f in others if not _mostly_behind(f, front, self.options)]
        else:
            line, length = _on_wall(plan, front, self.options)
            more = _before(plan, line) if length > 0.0 else Polygon()
        more = more.difference(self.beside)
        if more.difference(plan).area < _LEAST_M2:
            return plan
        found = _without_slits(plan.union(more))
        if not isinstance(found, Polygon) or not borders_are_apart(found) or found.area < plan.area:
            return plan
        held = [(_on_wall(p, f, self.options)[1] for f in others) for p in (plan, found)]
        kept = all(now > was - _LOST_M for was, now in zip(*held, strict=True))
        return found if kept else plan


def _over(below: Polygon, wide: Polygon) -> Polygon | None:
    """Returns a plan whose borders are those of the plan below or stand apart; None if it is the same."""
    more = simplified(buffered(buffered(wide.difference(below), -_FIN_M), _FIN_M))
    found = shapely.union(below, _onto_border(more, below), grid_size=1.0 / GRID_PER_M)
    if more.area < _LEAST_M2 or not isinstance(found, Polygon) or not borders_are_apart(found):
        return None
    return found


def _onto_border(area: BaseGeometry, plan: Polygon) -> BaseGeometry:
    """Moves the vertices of an area that nearly lie on the border of a plan onto it, first to its corners."""
    border = plan.boundary

    def moved(xy: Float) -> Float:
        lines = shapely.shortest_line(shapely.points(xy), border)
        near = shapely.length(lines) < _SLIT_M
        return np.where(near[:, None], shapely.get_coordinates(lines).reshape(-1, 2, 2)[:, 1], xy)

    return shapely.transform(shapely.snap(area, plan, _SLIT_M), moved).buffer(0.0)  # lines are left out


def _without_slits(plan: BaseGeometry) -> BaseGeometry:
    """Closes the narrowest slits of a plan, and removes vertices that a straight line replaces."""
    return simplified(buffered(buffered(simplified(plan), _SLIT_M), -_SLIT_M))


def _body(
    plan: Polygon, facade: PlanFacade, facades: Sequence[PlanFacade], options: BuildOptions
) -> Polygon | None:
    """Returns the area behind the openings of a front that juts out over a plan; None for other facades.

    Such a front has no wall of the plan near it, the plan lies behind some of it, and it hides what is behind
    it: where other facades were measured behind most of it, it is a fence, a scaffold or an error of the
    scan. The area is as deep as the one between front and plan; it may reach beyond the corner of the plan.
    """
    if facade.held is None or _on_wall(plan, facade, options)[1] > 0.0:
        return None
    behind = sum(_shared(facade, f, options) for f in facades if f is not facade)
    before = _before(plan, facade)
    inside = shapely.LineString(facade.ends + 2.0 * _SLIT_M * facade.inward)
    covered = float(inside.intersection(before).length)
    if covered < _LOST_M or behind > _MOST * facade.length * (facade.high - facade.low):
        return None
    left, _, right, _ = facade.held
    left, right = max(left - MASONRY.half_brick, 0.0), min(right + MASONRY.half_brick, facade.length)
    return facade.strip(left, right, float(before.area) / covered)


def _mostly_behind(other: PlanFacade, front: PlanFacade, options: BuildOptions) -> bool:
    """Decides whether most of another facade lies behind a front: it was seen through its openings."""
    return _shared(front, other, options) > _MOST * other.length * (other.high - other.low)


def _shared(front: PlanFacade, other: PlanFacade, options: BuildOptions) -> float:
    """Returns how much (m2) of a front lies before another facade that is parallel to it."""
    depth = float(front.depth_of(other.ends).mean())
    parallel = front.inward @ other.inward > np.cos(np.radians(options.max_angle))
    if not parallel or not MASONRY.step_out < depth <= MASONRY.arcade:
        return 0.0
    s = np.sort((other.ends - front.ends[0]) @ front.along)
    wide = min(s[1], front.length) - max(s[0], 0.0)
    high = min(front.high, other.high) - max(front.low, other.low)
    return float(max(wide, 0.0) * max(high, 0.0))


def _on_wall(plan: Polygon, facade: PlanFacade, options: BuildOptions) -> tuple[PlanFacade, float]:
    """Returns a facade on the line of the wall of the plan that it was measured on, and how long that is, m.

    Without a wall within `max_offset`, that is the facade as it is, and 0.
    """
    ring = np.array(shapely.orient_polygons(plan).exterior.coords)
    a, b = ring[:-1], ring[1:]
    way = b - a
    length = np.linalg.norm(way, axis=1)
    parallel = way @ facade.along > np.cos(np.radians(options.max_angle)) * length
    near = np.abs(facade.depth_of((a + b) / 2)) < options.max_offset
    s = np.sort([(p - facade.ends[0]) @ facade.along for p in (a, b)], axis=0)
    shared = np.minimum(s[1], facade.length) - np.maximum(s[0], 0.0)
    fits = np.where(parallel & near, shared, 0.0)
    k = int(fits.argmax())
    if fits[k] <= 0.0:
        return facade, 0.0
    along = way[k] / length[k]
    ends = a[k] + np.outer((facade.ends - a[k]) @ along, along)
    inward = np.array([-along[1], along[0]])
    return PlanFacade(ends, inward, facade.low, facade.high), float(fits[fits > 0.0].sum())


def _before(plan: Polygon, facade: PlanFacade) -> BaseGeometry:
    """Returns the area between a facade and the plan right behind it, and between parts of the plan there."""
    step: Float = -MASONRY.arcade * facade.inward
    corners = np.array(plan.exterior.coords)
    sides = [Polygon([p, q, q + step, p + step]) for p, q in pairwise(corners)]
    step_m = 1.0 / GRID_PER_M
    swept = shapely.union_all([plan, *(s for s in sides if s.is_valid and s.area > 0.0)], grid_size=step_m)
    strip = facade.own_strip(MASONRY.arcade)
    between = shapely.convex_hull(strip.intersection(plan))
    reached = shapely.intersection(strip, swept.union(between.buffer(0.0)), grid_size=step_m)
    return shapely.difference(reached.buffer(0.0), plan, grid_size=step_m)  # lines are left out
