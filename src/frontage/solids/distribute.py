"""Distributes the reliefs of a facade among the coarse solids of a building that has several parts."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from frontage.model import Solid
from frontage.model.masonry import MASONRY
from frontage.solids.brep import GRID_PER_M
from frontage.solids.options import BuildOptions
from frontage.solids.relief import FacadeReliefs, Relief
from frontage.solids.walls import find_walls


def distribute_reliefs(
    facade: FacadeReliefs, solids: Sequence[Solid], options: BuildOptions
) -> list[FacadeReliefs]:
    """Returns the facade once per solid, each with the reliefs that its walls cover best.

    A relief that no wall covers goes to the solid with the largest wall under the facade. Where no wall is
    within `max_offset`, those that the facade may stand on a step of count.
    """
    if len(solids) == 1:
        return [facade]
    walls = [_walls_in_facade(facade, s, options) for s in solids]
    if not any(w.intersects(shapely.make_valid(Polygon(facade.outline))) for w in walls):
        far = options.model_copy(update={"max_offset": max(options.max_offset, MASONRY.arcade)})
        walls = [_walls_in_facade(facade, s, far) for s in solids]
    largest = max(range(len(solids)), key=lambda k: walls[k].area)
    chosen: list[list[Relief]] = [[] for _ in solids]
    for relief in facade.reliefs:
        ring = shapely.make_valid(Polygon(relief.ring))
        covered = [float(w.intersection(ring).area) for w in walls]
        chosen[int(np.argmax(covered)) if max(covered) > 0 else largest].append(relief)
    return [replace(facade, reliefs=tuple(own)) for own in chosen]


def _walls_in_facade(facade: FacadeReliefs, solid: Solid, options: BuildOptions) -> BaseGeometry:
    """Returns the walls of a solid that a facade was measured on, in the facade frame (x, z) m."""
    facade_from_local = facade.local_from_facade.inverse
    rings = [
        facade_from_local.apply(solid.vertices[list(solid.faces[k].ring)] / GRID_PER_M)[:, [0, 2]]
        for w in find_walls(solid, facade, options)
        for k in w.faces
    ]
    return shapely.union_all([shapely.make_valid(Polygon(r)) for r in rings])
