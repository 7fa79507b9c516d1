"""Projects the reliefs of a facade onto the walls of a solid, each to the wall that covers it best."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.solids.brep import GRID_PER_M
from frontage.solids.cells.context import BuildContext
from frontage.solids.cells.placing_area import wall_region
from frontage.solids.relief import FacadeReliefs, Relief, names_of
from frontage.solids.walls import HostWall


@dataclass(frozen=True, eq=False)
class ProjectedRelief:
    """A relief projected onto a wall: its polygon in 0.1 mm (x, z), and the reliefs on its own surface."""

    relief: Relief
    polygon: BaseGeometry
    inside: tuple["ProjectedRelief", ...] = ()


def assign_to_walls(
    facade: FacadeReliefs, walls: Sequence[HostWall], context: BuildContext
) -> tuple[dict[int, list[ProjectedRelief]], dict[str, float]]:
    """Assigns each relief to the wall that covers most of it.

    Returns wall index -> its reliefs, and relief id -> offset (m) from the measured plane to the wall, the
    mean over the ring. Reliefs with a broken outline (S312) or on no wall (S310) are refused.
    """
    motions = [w.local_from_wall.inverse @ facade.local_from_facade for w in walls]
    regions = [wall_region(w) for w in walls]
    by_wall: dict[int, list[ProjectedRelief]] = {}
    offsets: dict[str, float] = {}
    for relief in facade.reliefs:
        projected = [_project(relief, m) for m in motions]
        if not all(p.polygon.is_valid and p.polygon.area > 0 for p in projected):
            context.log.refuse(
                "S312", relief, "its outline crosses itself or has no area", "repair the outline"
            )
            continue
        share = [float(r.intersection(p.polygon).area) for r, p in zip(regions, projected, strict=True)]
        best = int(np.argmax(share))
        if share[best] == 0.0:
            context.log.refuse(
                "S310", relief, "lies on no wall of the host", "check outline and registration"
            )
            continue
        offset = -float(_in_wall_frame(relief.ring, motions[best])[:, 1].mean())
        offsets |= dict.fromkeys(names_of(relief), offset)
        by_wall.setdefault(best, []).append(projected[best])
    return by_wall, offsets


def without_protrusions(reliefs: Sequence[ProjectedRelief], context: BuildContext) -> list[ProjectedRelief]:
    """Replaces protrusions by the reliefs on them, for a model without depth."""
    flat: list[ProjectedRelief] = []
    for r in reliefs:
        if r.relief.depth is not None and r.relief.depth < 0:
            context.log.note(f"{r.relief.id}: a protrusion, left out because the model has no depth")
            flat += without_protrusions(r.inside, context)
        else:
            flat.append(r)
    return flat


def _project(relief: Relief, wall_from_facade: Rigid3) -> ProjectedRelief:
    grid = np.rint(_in_wall_frame(relief.ring, wall_from_facade)[:, [0, 2]] * GRID_PER_M)
    inside = tuple(_project(r, wall_from_facade) for r in relief.inside)
    polygon = Polygon(grid) if len(grid) > 2 and np.isfinite(grid).all() else Polygon()
    return ProjectedRelief(relief, polygon, inside)


def _in_wall_frame(ring: Float, wall_from_facade: Rigid3) -> Float:
    """Returns a ring (k, 2) m of the measured plane in the wall frame (k, 3) m."""
    return wall_from_facade.apply(np.column_stack([ring[:, 0], np.zeros(len(ring)), ring[:, 1]]))
