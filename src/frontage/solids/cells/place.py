"""Places reliefs on a wall: in whole 0.1 mm, apart from each other and from the wall's border.

Borders closer than the gap are joined, what leaves its surface is clipped, and overlaps are clipped or
refused. Every change is noted in the log, and every refusal is a `Failed` there.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import Polygon

from frontage.solids.brep import GRID_PER_M
from frontage.solids.cells.context import BuildContext
from frontage.solids.cells.fit import fit_polygon
from frontage.solids.cells.placed import PlacedRelief
from frontage.solids.cells.placing_area import SAME, PlacingArea
from frontage.solids.cells.project import ProjectedRelief
from frontage.solids.relief import Relief


def place_reliefs(
    area: PlacingArea, reliefs: Sequence[ProjectedRelief], context: BuildContext
) -> list[PlacedRelief]:
    """Places all reliefs that fit; each follows the relief that it lies on."""
    placed: list[PlacedRelief] = []
    _place_on(area, reliefs, -1, placed, context)
    return placed


def _place_on(
    area: PlacingArea,
    reliefs: Sequence[ProjectedRelief],
    parent: int,
    placed: list[PlacedRelief],
    context: BuildContext,
) -> None:
    """Places reliefs on one surface (the wall, or the relief with the index `parent`), then those on them."""
    room = area.room(context.gap)
    shapely.prepare(room)
    base = placed[parent].height if parent >= 0 else 0
    lines = list(area.seams) + ([area.ground] if not area.ground.is_empty else [])
    here: list[tuple[PlacedRelief, ProjectedRelief]] = []
    for projected in reliefs:
        relief = projected.relief
        close = shapely.dwithin([p.polygon for p, _ in here], projected.polygon, context.gap)
        near = [here[k][0] for k in np.flatnonzero(close).tolist()]
        polygon = fit_polygon(projected, room, lines, near, context)
        if polygon is not None:
            height = base + _relief_height(relief, context)
            height = _levelled_height(relief, height, polygon, near, context)
            here.append((PlacedRelief(relief, polygon, height, parent), projected))
    first = len(placed)
    placed += [p for p, _ in here]
    for k, (one, projected) in enumerate(here):
        if projected.inside:
            foot = area.ground.intersection(one.polygon.boundary.buffer(SAME))
            _place_on(PlacingArea(one.polygon, foot), projected.inside, first + k, placed, context)


def _relief_height(relief: Relief, context: BuildContext) -> int:
    """Returns the height of a relief over the surface around it, in 0.1 mm."""
    if relief.depth is None or not context.options.depth:
        return 0
    if abs(relief.depth) < context.options.gap:
        context.log.note(
            f"{relief.id}: made flush because its depth of {relief.depth:.3f} m is below the gap"
        )
        return 0
    return int(np.rint(relief.depth * GRID_PER_M))


def _levelled_height(
    relief: Relief,
    height: int,
    polygon: Polygon,
    near: Sequence[PlacedRelief],
    context: BuildContext,
) -> int:
    """Returns the height, or that of a touching relief if the step between the two would be a sliver."""
    for other in near:
        step = abs(height - other.height)
        if 0 < step < context.gap and other.polygon.dwithin(polygon, SAME):
            context.log.note(f"{relief.id}: given the depth of {other.relief.id}, which it touches")
            return other.height
    return height
