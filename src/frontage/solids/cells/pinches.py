"""Cuts corners of reliefs where the solid would touch itself along an edge."""

from dataclasses import replace

import shapely
from shapely.geometry import Polygon

from frontage.solids.brep import GRID_PER_M
from frontage.solids.cells.context import BuildContext
from frontage.solids.cells.contract import SHORTEST, Node
from frontage.solids.cells.partition import Partition, partition_wall
from frontage.solids.cells.placed import PlacedRelief, without
from frontage.solids.walls import HostWall

_ROUNDS = 8  # of cutting corners, before the reliefs that still touch are refused


def partition_without_pinches(
    wall: HostWall, placed: list[PlacedRelief], context: BuildContext
) -> tuple[Partition, list[PlacedRelief]]:
    """Partitions a wall; corners of reliefs are cut until the solid touches itself nowhere.

    Returns the partition and the changed reliefs.
    """
    partition = partition_wall(wall, placed)
    for number in range(_ROUNDS + 1):
        nodes = partition.pinched_nodes()
        if not nodes:
            break
        for node in nodes:
            placed = _without_corner(placed, node, context, last_round=number == _ROUNDS)
        partition = partition_wall(wall, placed)
    return partition, placed


def _without_corner(
    placed: list[PlacedRelief], node: Node, context: BuildContext, last_round: bool
) -> list[PlacedRelief]:
    """Cuts the corner of the last relief at a node; removes the relief (S316) if that is not possible."""
    half = context.gap / 2
    point = shapely.Point(node)
    here = [k for k, p in enumerate(placed) if p.polygon.boundary.dwithin(point, SHORTEST)]
    here = [k for k in here if placed[k].height] or here
    if not here:
        return placed
    one = placed[here[-1]]
    square = shapely.box(node[0] - half, node[1] - half, node[0] + half, node[1] + half)
    rest = shapely.difference(one.polygon, square, grid_size=1.0)
    if last_round or not isinstance(rest, Polygon) or rest.interiors:
        context.log.refuse(
            "S316", one.relief, "touches another opening in a single point", "separate or join the two"
        )
        return without(placed, here[-1])
    cut = f"{half / GRID_PER_M:g} m cut off at a corner that touched another relief in a single point"
    context.log.note(f"{one.relief.id}: {cut}")
    placed = list(placed)
    placed[here[-1]] = replace(one, polygon=rest)
    return placed
