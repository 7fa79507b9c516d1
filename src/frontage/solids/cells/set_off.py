"""Puts a facade far from the host's wall onto a step of that wall: the model does not know every jetty."""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import LinearRing, Polygon

from frontage.geometry.arrays import Float
from frontage.geometry.ring import at_depth
from frontage.model import Solid
from frontage.model.masonry import MASONRY
from frontage.solids.brep import GRID_PER_M
from frontage.solids.options import BuildOptions
from frontage.solids.relief import FacadeReliefs, Relief
from frontage.solids.walls import HostWall, find_walls


def on_a_step(
    solid: Solid, facade: FacadeReliefs, options: BuildOptions
) -> tuple[FacadeReliefs, tuple[HostWall, ...]] | None:
    """Returns a facade whose reliefs all lie on a step of the wall behind or before it, and that wall.

    Storeys that jut out, and those set back, are steps of the measured front, no errors of registration.
    Returns None where no wall is that near, and for a
    model without depth.
    """
    if not options.depth or options.max_offset >= MASONRY.arcade:
        return None
    found = find_walls(solid, facade, options.model_copy(update={"max_offset": MASONRY.arcade}))
    rings = [_ring_on(facade, wall) for wall in found]
    area = [0.0 if r is None else float(r.area) for r in rings]
    best = int(np.argmax(area)) if area else -1
    ring = rings[best] if best >= 0 else None
    if ring is None:
        return None
    corners = np.asarray(ring.exterior.coords)[:-1]
    wall_from_facade = found[best].local_from_wall.inverse @ facade.local_from_facade
    depth = float(wall_from_facade.apply(at_depth(corners, 0.0))[:, 1].mean())
    step = Relief(f"{facade.id}/step", corners, depth, "WallSurface", facade.reliefs)
    return FacadeReliefs(facade.id, facade.local_from_facade, facade.outline, (step,)), (found[best],)


def covers_any(facade: FacadeReliefs, walls: Sequence[HostWall]) -> bool:
    """Decides whether any of the walls lies within the facade's outline, and not only beside it."""
    return any(_ring_on(facade, wall) is not None for wall in walls)


def _ring_on(facade: FacadeReliefs, wall: HostWall) -> Polygon | None:
    """Returns the largest part of the facade's outline, in its frame, that lies on a wall."""
    facade_from_wall = facade.local_from_facade.inverse @ wall.local_from_wall

    def flat(ring: LinearRing) -> Float:
        """Returns a ring of the wall in the facade's plane."""
        corners = np.asarray(ring.coords)[:-1] / GRID_PER_M
        return facade_from_wall.apply(at_depth(corners, 0.0))[:, [0, 2]]

    region = shapely.union_all(
        [shapely.make_valid(Polygon(flat(p.exterior), [flat(h) for h in p.interiors])) for p in wall.polygons]
    )
    shared = shapely.make_valid(Polygon(facade.outline)).intersection(region)
    parts = [p for p in shapely.get_parts(shared) if isinstance(p, Polygon) and p.area > 0.0]
    return max(parts, key=lambda p: float(p.area), default=None)
