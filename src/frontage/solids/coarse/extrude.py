"""Blocks as hosts: a ground polygon extruded upwards, or a facade's outline extruded into the building."""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import Polygon

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import polygon_ring
from frontage.model import Face, Failed, Solid, Surface, WorldRef
from frontage.solids.brep import GRID_PER_M, newell_normal
from frontage.solids.coarse.host import Host, host_solid
from frontage.solids.coarse.overhangs import with_overhangs
from frontage.solids.coarse.plan_facade import PlanFacade
from frontage.solids.options import BuildOptions

_UP = 0.5  # vertical component of the normal of a block's roof or ground, at least


def ground_block(
    building: str,
    surfaces: Sequence[Surface],
    world: WorldRef,
    top: float | None = None,
    *,
    fronts: Sequence[PlanFacade] = (),
    options: BuildOptions | None = None,
) -> Host | Failed:
    """Extrudes a building's one ground polygon up to `top` (m local; None = the top of its highest wall).

    The host of a model whose walls and roof do not close: its walls are those of the model in plan, its roof
    is flat. Its plan reaches up to the measured `fronts` that stand before the ground polygon. Returns S304
    if there is not exactly one ground polygon, or nothing gives the height.
    """
    grounds = [s for s in surfaces if s.semantics == "GroundSurface"]
    walls = [s.ring[:, 2].max() for s in surfaces if s.semantics == "WallSurface"]
    if len(grounds) != 1 or (top is None and not walls):
        text = f"{building}: a block needs one ground polygon and a height; there are {len(grounds)} polygons"
        return Failed("S304", text, "use a block made from the facade")
    high = float(max(walls)) if top is None else top
    ground, notes = _with_overhangs(building, grounds[0], fronts, options or BuildOptions())
    made = host_solid(building, _prism_surfaces(ground, high), world, "1")
    if not isinstance(made, Host):
        return made
    note = f"{building}: a block over its ground polygon up to {high:.2f} m replaces the city model's solid"
    return Host(made.solid, (note, *notes, *made.notes))


def _with_overhangs(
    building: str, ground: Surface, fronts: Sequence[PlanFacade], options: BuildOptions
) -> tuple[Surface, tuple[str, ...]]:
    """Returns a ground polygon, at its mean height, under the storeys that jut out, and a note on that."""
    plan = Polygon(ground.ring[:, :2], [hole[:, :2] for hole in ground.holes])
    wide = with_overhangs(plan, fronts, options) if fronts and plan.is_valid else plan
    if wide is plan:
        return ground, ()
    z = float(ground.ring[:, 2].mean())
    rings = [np.array(r.coords)[:-1] for r in (wide.exterior, *wide.interiors)]
    flat = [np.column_stack([r, np.full(len(r), z)]) for r in rings]
    more = f"{wide.area - plan.area:.1f} m2 that jut out over its ground polygon are built to the ground"
    return Surface(flat[0], ground.semantics, ground.source_id, tuple(flat[1:])), (f"{building}: {more}",)


def _prism_surfaces(ground: Surface, high: float) -> list[Surface]:
    """Returns the ground, the roof at the height `high` (m) and the walls of a prism."""
    rings = (ground.ring, *ground.holes)
    up = newell_normal(rings[0])[2] > 0
    lower = [r[::-1] if up else r for r in rings]
    upper = [np.column_stack([r[:, :2], np.full(len(r), high)])[::-1] for r in lower]
    shell = [Surface(lower[0], "GroundSurface", "", tuple(lower[1:]))]
    shell.append(Surface(upper[0], "RoofSurface", "", tuple(upper[1:])))
    for low_ring, high_ring in zip(lower, upper, strict=True):
        above = high_ring[::-1]
        for a in range(len(low_ring)):
            b = (a + 1) % len(low_ring)
            side = np.array([low_ring[b], low_ring[a], above[a], above[b]])
            shell.append(Surface(side, "WallSurface"))
    return shell


def facade_block(
    building: str, local_from_facade: Rigid3, outline: Float, depth: float, world: WorldRef
) -> Host | Failed:
    """Extrudes a facade's outline (k, 2) m (x, z) by `depth` m along its horizontal normal.

    The host where there is no city model. The front and the back are walls; sides that look up are roof,
    sides that look down ground. Returns S304 if the outline or the depth makes no block.
    """
    raw = Polygon(outline)
    if not raw.is_valid or raw.area == 0 or depth <= 0:
        return Failed("S304", f"{building}: the facade's outline makes no block", "check outline and depth")
    polygon = shapely.set_precision(raw, 1 / GRID_PER_M).simplify(1 / GRID_PER_M)
    if not isinstance(polygon, Polygon) or polygon.is_empty:
        return Failed("S304", f"{building}: the facade's outline is too thin", "check outline and depth")
    ring = polygon_ring(polygon)
    front = local_from_facade.apply(np.insert(ring, 1, 0.0, axis=1))
    inward = local_from_facade.R[:, 1] * np.array([1.0, 1.0, 0.0])
    back = front + depth * inward / np.linalg.norm(inward)
    grid = np.rint(np.concatenate([front, back]) * GRID_PER_M).astype(np.int64)
    k = len(ring)
    faces = [Face(tuple(range(k)), "WallSurface"), Face(tuple(range(2 * k - 1, k - 1, -1)), "WallSurface")]
    for a in range(k):
        b = (a + 1) % k
        side = (b, a, a + k, b + k)
        up = float(newell_normal(grid[list(side)] / GRID_PER_M)[2])
        kind = "RoofSurface" if up > _UP else "GroundSurface" if up < -_UP else "WallSurface"
        faces.append(Face(side, kind))
    note = f"{building}: no city model; a block of {depth:g} m behind the facade is used"
    return Host(Solid(building, grid, world.origin, tuple(faces), "1"), (note,))
