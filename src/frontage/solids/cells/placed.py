"""Reliefs in their place on a wall."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from shapely.geometry import Polygon

from frontage.solids.relief import Relief


@dataclass(frozen=True, eq=False)
class PlacedRelief:
    """A relief in its place on a wall.

    polygon  in whole 0.1 mm (x, z)
    height   of its surface in 0.1 mm, positive = behind the wall
    parent   index of the relief that it lies on, in the list of all placed reliefs; -1 = the wall
    """

    relief: Relief
    polygon: Polygon
    height: int
    parent: int


def base_height(placed: Sequence[PlacedRelief], index: int) -> int:
    """Returns the height (0.1 mm) of the surface that a relief lies on; 0 for the wall."""
    parent = placed[index].parent
    return placed[parent].height if parent >= 0 else 0


def with_height(placed: Sequence[PlacedRelief], index: int, height: int) -> list[PlacedRelief]:
    """Moves one relief, and all that lie on it, to another height (0.1 mm)."""
    moved, by = list(placed), {index: height - placed[index].height}
    for k, one in enumerate(placed):
        if k == index or one.parent in by:
            by[k] = by[index] if k == index else by[one.parent]
            moved[k] = replace(one, height=one.height + by[k])
    return moved


def without(placed: Sequence[PlacedRelief], index: int) -> list[PlacedRelief]:
    """Removes one relief, and all that lie on it."""
    gone = {index}
    for k, one in enumerate(placed):
        if one.parent in gone:
            gone.add(k)
    left = [k for k in range(len(placed)) if k not in gone]
    new_index = {k: n for n, k in enumerate(left)} | {-1: -1}
    return [replace(placed[k], parent=new_index[placed[k].parent]) for k in left]
