"""Blocks under the eaves of a facade: the roof of a gable or a step runs back over the footprint."""

import itertools
from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import Polygon

from frontage.geometry.arrays import Float
from frontage.model import Failed, Surface, WorldRef
from frontage.solids.coarse.eaves import LEVEL_M
from frontage.solids.coarse.host import Host, host_solid
from frontage.solids.coarse.plan_facade import PlanFacade
from frontage.validation.validate import validate

_BESIDE_M = 3.0  # largest extent of the plan beyond the ends of the facade whose eaves it gets
_CLEAR_M = 0.1  # smallest distance between a break of the eaves and a corner of the plan
_UNBOUNDED_M = 1e4


def block_under_eaves(
    building: str, plan: Polygon, own: Sequence[PlanFacade], world: WorldRef
) -> Host | None:
    """Makes a valid block whose roof is a facade's eaves extruded over the plan along its horizontal normal.

    The facade is the highest one; its eaves must step or slope, and all other facades must stay below the
    roof. Returns None if that is not so; an upright block with a flat roof takes its place then.
    """
    facade = max(own, key=lambda f: f.high)
    line = _eaves_over_plan(facade, plan)
    if line is None or np.ptp(line[:, 1]) <= LEVEL_M or plan.interiors:
        return None
    if any(_stands_above(f, facade, line) for f in own if f is not facade):
        return None
    low = min(f.low for f in own)
    made = host_solid(building, _shell(plan, facade, line, low), world, "1")
    return None if isinstance(made, Failed) or validate(made.solid) else made


def _eaves_over_plan(facade: PlanFacade, plan: Polygon) -> Float | None:
    """Returns the eaves (k, 2) m (along, z) from end to end of the plan.

    Returns None if the plan extends too far beyond the facade, or the eaves break at a corner of the plan.
    """
    along = np.asarray(plan.exterior.coords)[:-1] @ facade.along
    line = facade.eaves
    low, high = float(along.min()), float(along.max())
    if line[0, 0] - low > _BESIDE_M or high - line[-1, 0] > _BESIDE_M:
        return None
    ends = np.interp([low, high], *line.T)
    breaks = line[1:-1][(line[1:-1, 0] > low) & (line[1:-1, 0] < high)]
    if len(breaks) and np.abs(breaks[:, :1] - along).min() < _CLEAR_M:
        return None
    return np.array([[low, ends[0]], *breaks, [high, ends[1]]])


def _stands_above(other: PlanFacade, facade: PlanFacade, line: Float) -> bool:
    """Decides whether the eaves of another facade stand above the roof."""
    ends = other.ends @ facade.along
    inner = ends[0] + (ends[1] - ends[0]) * np.linspace(0.1, 0.9, 9)
    share = (inner - ends[0]) / (ends[1] - ends[0] or 1.0)
    own = np.interp(other.eaves[0, 0] + share * np.ptp(other.eaves[:, 0]), *other.eaves.T)
    return bool((own > np.interp(inner, *line.T) + LEVEL_M).any())


def _shell(plan: Polygon, facade: PlanFacade, line: Float, low: float) -> list[Surface]:
    """Returns the ground, a wall per edge of the plan, and the roofs and steps under the eaves."""
    ring = np.asarray(shapely.geometry.polygon.orient(plan).exterior.coords)[:-1]
    shell = [Surface(np.insert(ring[::-1], 2, low, axis=1), "GroundSurface")]
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        foot = np.insert(np.array([a, b]), 2, low, axis=1)
        shell.append(Surface(np.concatenate([foot, _wall_top(a, b, facade, line)[::-1]]), "WallSurface"))
    plan_from_facade = np.column_stack([facade.along, facade.inward])
    in_facade = Polygon(ring @ plan_from_facade)
    for (s0, z0), (s1, z1) in itertools.pairwise(line):
        if s1 > s0:
            shell += _roof(in_facade, (s0, z0), (s1, z1), plan_from_facade)
        else:
            shell += _step(in_facade, s0, (z0, z1), plan_from_facade)
    return shell


def _roof(
    plan: Polygon, start: tuple[float, float], end: tuple[float, float], plan_from_facade: Float
) -> list[Surface]:
    """Returns the roof under a segment of the eaves, between two points (along, z) m."""
    (s0, z0), (s1, z1) = start, end
    surfaces = []
    for part in shapely.get_parts(plan.intersection(shapely.box(s0, -_UNBOUNDED_M, s1, _UNBOUNDED_M))):
        flat = np.asarray(shapely.geometry.polygon.orient(part).exterior.coords)[:-1]
        z = z0 + (z1 - z0) * (flat[:, 0] - s0) / (s1 - s0)
        surfaces.append(Surface(np.column_stack([flat @ plan_from_facade.T, z]), "RoofSurface"))
    return surfaces


def _step(plan: Polygon, at: float, heights: tuple[float, float], plan_from_facade: Float) -> list[Surface]:
    """Returns the wall where the eaves step between two heights (m), at a position (m) along the facade."""
    z0, z1 = heights
    surfaces = []
    cut = shapely.intersection(shapely.LineString([(at, -_UNBOUNDED_M), (at, _UNBOUNDED_M)]), plan)
    for edge in shapely.get_parts(cut):
        (_, d0), (_, d1) = sorted(edge.coords)
        near, far = (np.array([at, d]) @ plan_from_facade.T for d in (d0, d1))
        side = np.array([[*near, z0], [*near, z1], [*far, z1], [*far, z0]])
        surfaces.append(Surface(side, "WallSurface"))
    return surfaces


def _wall_top(a: Float, b: Float, facade: PlanFacade, line: Float) -> Float:
    """Returns the upper edge (k, 3) m of the wall from a (2,) to b (2,) m."""
    start, end = float(a @ facade.along), float(b @ facade.along)
    low, high = min(start, end), max(start, end)
    within = line[(line[:, 0] > low + _CLEAR_M / 2) & (line[:, 0] < high - _CLEAR_M / 2)]
    within = within if end > start else within[::-1]
    ends = np.interp([start, end], *line.T)
    share = (within[:, 0] - start) / (end - start) if len(within) else np.zeros(0)
    middle = np.column_stack([a + share[:, None] * (b - a), within[:, 1]])
    return np.concatenate([[[*a, ends[0]]], middle, [[*b, ends[1]]]])
