"""Blocks as hosts: a ground polygon extruded upwards, or a facade's outline extruded into the building."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import polygon_ring
from frontage.model import Face, Failed, Solid, Surface, WorldRef
from frontage.model.masonry import MASONRY
from frontage.solids.brep import GRID_PER_M, newell_normal
from frontage.solids.coarse.host import Host, host_solid
from frontage.solids.coarse.overhangs import Storey, storeys_over
from frontage.solids.coarse.plan_facade import PlanFacade
from frontage.solids.coarse.tidy import borders_are_apart, tidy_footprints
from frontage.solids.options import BuildOptions

_UP = 0.5  # vertical component of the normal of a block's roof or ground, at least
_LEAST_SOFFIT_M2 = 1e-6  # smaller parts come from rounding


def ground_block(
    building: str,
    surfaces: Sequence[Surface],
    world: WorldRef,
    top: float | None = None,
    *,
    fronts: Sequence[PlanFacade] = (),
    beside: BaseGeometry | None = None,
    options: BuildOptions | None = None,
) -> Host | Failed:
    """Extrudes a building's ground up to `top` (m local; None = the top of its highest wall).

    The host of a model whose walls and roof do not close: its walls are those of the model in plan, its roof
    is flat. It reaches up to the measured `fronts` that stand before the ground, but not into the area
    `beside` it, which belongs to other parts of the building. Returns S304 if its ground polygons are not one
    piece of ground, or nothing gives the height.
    """
    grounds = [s for s in surfaces if s.semantics == "GroundSurface"]
    walls = [s.ring[:, 2].max() for s in surfaces if s.semantics == "WallSurface"]
    ground = _one_ground(grounds)
    if ground is None or (top is None and not walls):
        text = f"{building}: a block needs one ground polygon and a height; there are {len(grounds)} polygons"
        return Failed("S304", text, "use a block made from the facade")
    high = float(max(walls)) if top is None else top
    shell, notes = _shell(building, ground, high, fronts, beside, options or BuildOptions())
    made = host_solid(building, shell, world, "1")
    if not isinstance(made, Host):
        return made
    note = f"{building}: a block over its ground polygon up to {high:.2f} m replaces the city model's solid"
    return Host(made.solid, (note, *notes, *made.notes))


def ground_plan(grounds: Sequence[Surface]) -> BaseGeometry:
    """Returns the area (m local) that ground surfaces cover together."""
    polygons = [Polygon(s.ring[:, :2], [hole[:, :2] for hole in s.holes]) for s in grounds]
    return shapely.union_all([shapely.make_valid(p) for p in polygons])


def level_grounds(grounds: Sequence[Surface], z: float) -> list[Surface]:
    """Returns ground surfaces at one height (m); polygons that touch become one."""
    if len(grounds) == 1:
        ring, *holes = (
            np.column_stack([r[:, :2], np.full(len(r), z)]) for r in (grounds[0].ring, *grounds[0].holes)
        )
        return [replace(grounds[0], ring=ring, holes=tuple(holes))]
    return [_level(p, z, "GroundSurface") for p in tidy_footprints(ground_plan(grounds))]


def _one_ground(grounds: Sequence[Surface]) -> Surface | None:
    """Returns the ground of a building, which may be drawn as several polygons, at the height of the largest.

    Polygons that people pass under are no ground but the undersides of balconies and bays.
    """
    if len(grounds) < 2:
        return next(iter(grounds), None)
    z = _height(max(grounds, key=lambda s: Polygon(s.ring[:, :2]).area))
    level = level_grounds([s for s in grounds if _height(s) < z + MASONRY.door_height], z)
    return level[0] if len(level) == 1 else None


def _height(surface: Surface) -> float:
    """Returns the mean height (m) of the corners of a surface."""
    return float(surface.ring[:, 2].mean())


def _shell(
    building: str,
    ground: Surface,
    high: float,
    fronts: Sequence[PlanFacade],
    beside: BaseGeometry | None,
    options: BuildOptions,
) -> tuple[list[Surface], list[str]]:
    """Returns the shell of a block over a ground polygon with the storeys that jut out, and notes."""
    plan = Polygon(ground.ring[:, :2], [hole[:, :2] for hole in ground.holes])
    z = float(ground.ring[:, 2].mean())
    low = [s for s in fronts if s.low < high]
    storeys: tuple[Storey, ...] = ()
    notes = []
    if low and plan.is_valid:
        try:
            storeys = storeys_over(plan, z, low, options, beside)
        except shapely.errors.GEOSException:  # areas that GEOS cannot join
            notes.append(f"{building}: its ground polygon could not be extended to storeys that jut out")
    storeys = tuple(s for s in storeys if s.foot < high - MASONRY.room_height) or (Storey(z, plan),)
    first = storeys[0]
    if len(storeys) == 1 and first.plan is plan:
        return _prism_surfaces(ground, high), notes
    if (more := first.plan.area - plan.area) > 0.0:
        text = f"{more:.1f} m2 that jut out over its ground polygon are built to the ground"
        notes.append(f"{building}: {text}")
    for below, storey in pairwise(storeys):
        more = storey.plan.area - below.plan.area
        notes.append(f"{building}: {more:.1f} m2 jut out over its ground polygon from {storey.foot:.2f} m up")
    return _stacked_surfaces(storeys, high), notes


def _stacked_surfaces(storeys: Sequence[Storey], high: float) -> list[Surface]:
    """Returns the ground, the soffits, the walls of every storey and the roof at the height `high` (m)."""
    shell = _prism_surfaces(_level(storeys[0].plan, storeys[0].foot, "GroundSurface"), high)[:1]
    for k, storey in enumerate(storeys):
        upper = storeys[k + 1].foot if k + 1 < len(storeys) else high
        prism = _prism_surfaces(_level(storey.plan, storey.foot, "GroundSurface"), upper)
        shell += prism[2:] if upper < high else prism[1:]
    for below, storey in pairwise(storeys):
        for part in _soffits(below.plan, storey.plan):
            up = _level(part, storey.foot, "OuterCeilingSurface")
            shell.append(replace(up, ring=up.ring[::-1], holes=tuple(h[::-1] for h in up.holes)))
    return shell


def _soffits(below: Polygon, plan: Polygon) -> list[Polygon]:
    """Returns what of a plan stands over the air; parts whose borders touch themselves are triangles."""
    over = shapely.set_precision(plan.difference(below), 1 / GRID_PER_M)
    parts = [p for p in shapely.get_parts(over) if isinstance(p, Polygon) and p.area > _LEAST_SOFFIT_M2]
    found: list[Polygon] = []
    for p in parts:
        triangles = [] if borders_are_apart(p) else shapely.constrained_delaunay_triangles(p).geoms
        found += [t for t in triangles if isinstance(t, Polygon)] or [p]
    return found


def _level(plan: Polygon, z: float, semantics: str) -> Surface:
    """Returns a level surface over a plan, which looks up."""
    plan = shapely.orient_polygons(plan)
    rings = [np.insert(np.array(r.coords)[:-1], 2, z, axis=1) for r in (plan.exterior, *plan.interiors)]
    return Surface(rings[0], semantics, "", tuple(rings[1:]))


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
