"""Ground plans with the storeys that jut out over them, as measured facades show them.

The ground polygon of a city model leaves out what stands over an arcade, a passage or a deep entrance. A
block over it has no wall there, and openings of the storeys above would have no host.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float
from frontage.solids.coarse.plan_facade import PlanFacade
from frontage.solids.coarse.tidy import buffered, simplified
from frontage.solids.options import BuildOptions

_FARTHEST_M = 4.0  # m between a facade and the ground plan behind it, at most: the depth of an arcade
_SLIT_M = 0.01  # m, half the width of slits that are closed
_LOST_M = 0.5  # m of wall that another facade may lose
_LEAST_M2 = 0.5  # m2 of plan: less is an error of the plan


def with_overhangs(plan: Polygon, facades: Sequence[PlanFacade], options: BuildOptions) -> Polygon:
    """Returns a ground plan (m local) that reaches up to the measured facades before it.

    A facade must have been measured on a wall of the plan, within `max_offset`. The line of that wall is the
    border, so that a front with a passage in it stays flat. The plan stays as it is where it would fall apart
    or where a wall would disappear that another facade was measured on. A whole front that juts out has no
    such wall; it stands on a step of the wall behind it.
    """
    for facade in facades:
        line, length = _on_wall(plan, facade, options)
        before = _before(plan, line)
        if length == 0.0 or before.area < _LEAST_M2:
            continue
        found = _without_slits(plan.union(before))
        if not isinstance(found, Polygon) or not found.is_valid or found.area < plan.area:
            continue
        held = [(_on_wall(p, f, options)[1] for f in facades if f is not facade) for p in (plan, found)]
        if all(now > was - _LOST_M for was, now in zip(*held, strict=True)):
            plan = found
    return plan


def _without_slits(plan: BaseGeometry) -> BaseGeometry:
    """Closes the narrowest slits of a plan, and removes vertices that a straight line replaces."""
    return simplified(buffered(buffered(simplified(plan), _SLIT_M), -_SLIT_M))


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
    step: Float = -_FARTHEST_M * facade.inward
    corners = np.array(plan.exterior.coords)
    sides = [Polygon([p, q, q + step, p + step]) for p, q in pairwise(corners)]
    swept = shapely.union_all([plan, *(s for s in sides if s.is_valid and s.area > 0.0)])
    strip = facade.own_strip(_FARTHEST_M)
    between = shapely.convex_hull(strip.intersection(plan))
    return strip.intersection(swept.union(between)).difference(plan)
