"""Puts a facade far from the host's wall onto a step of that wall: the model does not know every jetty."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry import LinearRing, Polygon
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float
from frontage.geometry.ring import at_depth
from frontage.model import Solid
from frontage.model.masonry import MASONRY
from frontage.solids.brep import GRID_PER_M
from frontage.solids.coarse.tidy import buffered
from frontage.solids.options import BuildOptions
from frontage.solids.relief import FacadeReliefs, Relief
from frontage.solids.walls import HostWall, find_walls

_LEAST_M2 = 0.01  # smaller parts of a step come from rounding


def on_a_step(
    solid: Solid, facade: FacadeReliefs, others: Sequence[FacadeReliefs], options: BuildOptions
) -> tuple[FacadeReliefs, tuple[HostWall, ...]] | None:
    """Returns a facade whose reliefs all lie on steps of the wall behind or before it, and that wall.

    Storeys that jut out, and those set back, are steps of the measured front, no errors of registration. The
    wall stays where `others` were measured on it: between the piers of an arcade that the model draws as a
    wall, there are several steps; what is left below the feet of piers joins none of them.

    Returns None where no wall is that near, and for a model without depth.
    """
    if not options.depth or options.max_offset >= MASONRY.arcade:
        return None
    near = find_walls(solid, facade, options.model_copy(update={"max_offset": MASONRY.arcade}))
    found = [wall for wall in near if abs(depth_of(wall, facade)) > options.max_offset]
    regions = [region_on(facade, wall) for wall in found]
    best = int(np.argmax([r.area for r in regions])) if regions else -1
    if best < 0 or regions[best].area == 0.0:
        return None
    wall, region = found[best], regions[best]
    depth = depth_of(wall, facade)
    if depth > 0.0:
        region = region.difference(shapely.union_all([_outline_on(facade, o, wall, options) for o in others]))
        region = buffered(buffered(region, -MASONRY.threshold / 2.0), MASONRY.threshold / 2.0)
    steps = _steps(facade, region, depth)
    return (
        (FacadeReliefs(facade.id, facade.local_from_facade, facade.outline, steps), (wall,))
        if steps
        else None
    )


def on_and_off(facade: FacadeReliefs, walls: Sequence[HostWall]) -> tuple[FacadeReliefs, FacadeReliefs]:
    """Returns a facade with the reliefs that some walls have a place for, and one with the others.

    The others lie within the outline of the facade, but on none of the walls. Reliefs with a broken outline
    are among the first ones.
    """
    covered = shapely.union_all([region_on(facade, wall) for wall in walls])
    bare = shapely.make_valid(Polygon(facade.outline)).difference(covered)
    off = {
        r.id
        for r in facade.reliefs
        if np.isfinite(r.ring).all() and bare.intersects(_area_of(r)) and not covered.intersects(_area_of(r))
    }
    parts = [tuple(r for r in facade.reliefs if (r.id in off) is is_off) for is_off in (False, True)]
    return replace(facade, reliefs=parts[0]), replace(facade, reliefs=parts[1])


def depth_of(wall: HostWall, facade: FacadeReliefs) -> float:
    """Returns how far (m) a facade lies behind a wall."""
    wall_from_facade = wall.local_from_wall.inverse @ facade.local_from_facade
    return float(wall_from_facade.apply(at_depth(facade.outline, 0.0))[:, 1].mean())


def _steps(facade: FacadeReliefs, region: BaseGeometry, depth: float) -> tuple[Relief, ...]:
    """Returns the parts of a region that hold reliefs, as steps with these on them, the largest one first.

    Every relief goes to the part that holds most of it, and those in none to the first step.
    """
    parts = [p for p in shapely.get_parts(region) if isinstance(p, Polygon) and p.area > _LEAST_M2]
    parts.sort(key=lambda p: -float(p.area))
    if not parts:
        return ()
    own: list[list[Relief]] = [[] for _ in parts]
    for relief in facade.reliefs:
        own[int(np.argmax([p.intersection(_area_of(relief)).area for p in parts]))].append(relief)
    held = [(p, tuple(r)) for p, r in zip(parts, own, strict=True) if r]
    names = [f"{facade.id}/step", *(f"{facade.id}/step-{k}" for k in range(2, len(held) + 1))]
    return tuple(
        Relief(name, np.asarray(p.exterior.coords)[:-1], depth, "WallSurface", reliefs)
        for name, (p, reliefs) in zip(names, held, strict=True)
    )


def _area_of(relief: Relief) -> BaseGeometry:
    """Returns what a relief covers in its facade's plane."""
    return shapely.make_valid(Polygon(relief.ring))


def _outline_on(
    facade: FacadeReliefs, other: FacadeReliefs, wall: HostWall, options: BuildOptions
) -> BaseGeometry:
    """Returns the outline of another facade in this one's plane, if that was measured on the wall."""
    parallel = other.local_from_facade.R[:, 1] @ wall.local_from_wall.R[:, 1]
    if parallel < np.cos(np.radians(options.max_angle)) or abs(depth_of(wall, other)) > options.max_offset:
        return Polygon()
    facade_from_other = facade.local_from_facade.inverse @ other.local_from_facade
    return shapely.make_valid(Polygon(facade_from_other.apply(at_depth(other.outline, 0.0))[:, [0, 2]]))


def region_on(facade: FacadeReliefs, wall: HostWall) -> BaseGeometry:
    """Returns the part of the facade's outline, in its frame (x, z) m, that lies on a wall."""
    facade_from_wall = facade.local_from_facade.inverse @ wall.local_from_wall

    def flat(ring: LinearRing) -> Float:
        """Returns a ring of the wall in the facade's plane."""
        corners = np.asarray(ring.coords)[:-1] / GRID_PER_M
        return facade_from_wall.apply(at_depth(corners, 0.0))[:, [0, 2]]

    region = shapely.union_all(
        [shapely.make_valid(Polygon(flat(p.exterior), [flat(h) for h in p.interiors])) for p in wall.polygons]
    )
    return shapely.make_valid(Polygon(facade.outline)).intersection(region)
