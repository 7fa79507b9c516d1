"""Finds the protrusions and niches of a facade that the host draws itself, as the wall of a bay or a wing."""

from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry import Polygon

from frontage.geometry.rigid import Rigid3
from frontage.model import Solid
from frontage.solids.cells.set_off import depth_of, region_on
from frontage.solids.options import BuildOptions
from frontage.solids.relief import FacadeReliefs, Relief
from frontage.solids.walls import find_walls

_MOST = 0.5  # share of a front that lies on the host's wall at its depth


def with_drawn_fronts(facade: FacadeReliefs, solid: Solid, options: BuildOptions) -> list[FacadeReliefs]:
    """Returns the facade without the fronts that the solid has walls for, and each of these as a facade.

    The openings of such a front lie in that wall, and nothing is added before or cut behind the facade.
    """
    kept: list[Relief] = []
    fronts: list[FacadeReliefs] = []
    for relief in facade.reliefs:
        front = _front_of(relief, facade)
        if front is not None and _is_drawn(front, relief.depth or 0.0, solid, options):
            fronts.append(front)
        else:
            kept.append(relief)
    return [replace(facade, reliefs=tuple(kept)), *fronts] if fronts else [facade]


def _front_of(relief: Relief, facade: FacadeReliefs) -> FacadeReliefs | None:
    """Returns the front of a protrusion or niche as a facade of its own; None for other reliefs."""
    if not relief.depth or not relief.inside:
        return None
    frame = facade.local_from_facade
    moved = Rigid3(frame.to, frame.frm, frame.R, frame.apply(np.array([[0.0, relief.depth, 0.0]]))[0])
    return FacadeReliefs(relief.id, moved, relief.ring, relief.inside)


def _is_drawn(front: FacadeReliefs, depth: float, solid: Solid, options: BuildOptions) -> bool:
    """Decides whether most of a front lies on walls that are nearer to it than to its facade.

    The front lies `depth` m behind the facade, a protrusion by a negative one.
    """
    walls = find_walls(solid, front, options)
    behind = [-depth_of(wall, front) for wall in walls]
    near = [region_on(front, w) for w, y in zip(walls, behind, strict=True) if abs(y) < abs(y + depth)]
    whole = shapely.make_valid(Polygon(front.outline))
    return bool(shapely.union_all(near).area > _MOST * whole.area)
