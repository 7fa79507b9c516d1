"""Adjusts the depths of placed reliefs: to the room behind them, and to touching reliefs."""

import numpy as np
import shapely

from frontage.solids.brep import GRID_PER_M
from frontage.solids.cells.clearance import Clearance
from frontage.solids.cells.context import BuildContext
from frontage.solids.cells.placed import PlacedRelief, base_height, with_height, without

_TOUCHING = 4.0  # 0.1 mm: reliefs this close touch


def limit_depths(
    placed: list[PlacedRelief], clearance: Clearance, context: BuildContext
) -> list[PlacedRelief]:
    """Makes reliefs shallower that would meet another face of the host.

    A recess without room becomes flush; a protrusion without room is refused (S315).
    """
    k = 0
    while k < len(placed):
        one = placed[k]
        base = base_height(placed, k)
        free = clearance.free_height(one.polygon, one.height)
        if free != one.height:
            enough = abs(free - base) >= context.gap and (free > base) == (one.height > base)
            if enough:
                limit = f"{abs(free - base) / GRID_PER_M:.3f} m"
                context.log.note(f"{one.relief.id}: limited to {limit}, because no more is free behind it")
                placed = with_height(placed, k, free)
            elif one.height < base:
                context.log.refuse(
                    "S315", one.relief, "meets another part of the building", "check its depth"
                )
                placed = without(placed, k)
                continue
            else:
                context.log.note(f"{one.relief.id}: made flush because there is no room for its depth")
                placed = with_height(placed, k, base)
        k += 1
    return placed


def level_slivers(placed: list[PlacedRelief], gap: float) -> list[PlacedRelief]:
    """Brings touching reliefs to one height where the step between them is below `gap` (0.1 mm).

    Repeated until no such step is left, because a relief that moves may come close to another one.
    """
    polygons = np.array([p.polygon for p in placed], object)
    i, j = shapely.STRtree(polygons).query(polygons, "dwithin", _TOUCHING)
    parent = np.array([p.parent for p in placed])
    pairs = (i < j) & (parent[i] == parent[j])
    i, j = i[pairs], j[pairs]
    while True:
        height = np.array([p.height for p in placed])
        step = np.abs(height[i] - height[j])
        slivers = np.flatnonzero((step > 0) & (step < gap))
        if not len(slivers):
            return placed
        pair = [int(k[slivers[0]]) for k in (i, j)]
        shallower = min((placed[k].height for k in pair), key=abs)
        for k in pair:
            placed = with_height(placed, k, shallower)
