"""The block behind several facades under the eaves of one: the roof of a gable runs back over the plan."""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import Polygon

from frontage.geometry.arrays import Float
from frontage.model import Failed, Surface, WorldRef
from frontage.solids.hosts.eaves import LEVEL
from frontage.solids.hosts.host import Host, host_solid
from frontage.solids.hosts.plan import Front
from frontage.validation.validate import validate

_BESIDE = 3.0  # m that the plan may reach beyond the ends of the facade whose eaves it gets
_CLEAR = 0.1  # m between a break of the eaves and a corner of the plan
_FAR = 1e4  # m


def roofed(building: str, plan: Polygon, own: Sequence[Front], world: WorldRef) -> Host | None:
    """A valid block whose roof is the eaves of a facade pulled over the plan along its level normal.

    The facade is the one with the highest eaves among those with steps or verges; every other facade must
    stand below that roof. None: there is no such facade, and an upright block has to do.
    """
    front = max(own, key=lambda f: f.high)
    line = _over(front, plan)
    if line is None or np.ptp(line[:, 1]) <= LEVEL or plan.interiors:
        return None
    if any(_above(f, front, line) for f in own if f is not front):
        return None
    low = min(f.low for f in own)
    made = host_solid(building, _shell(plan, front, line, low), world, "1")
    return None if isinstance(made, Failed) or validate(made.solid) else made


def _over(front: Front, plan: Polygon) -> Float | None:
    """The eaves (k, 2) m (along, z) from end to end of the plan, no break in them at one of its corners."""
    along = np.asarray(plan.exterior.coords)[:-1] @ front.along
    line = front.eaves
    low, high = float(along.min()), float(along.max())
    if line[0, 0] - low > _BESIDE or high - line[-1, 0] > _BESIDE:
        return None
    ends = np.interp([low, high], *line.T)
    breaks = line[1:-1][(line[1:-1, 0] > low) & (line[1:-1, 0] < high)]
    if len(breaks) and np.abs(breaks[:, :1] - along).min() < _CLEAR:
        return None
    return np.array([[low, ends[0]], *breaks, [high, ends[1]]])


def _above(other: Front, front: Front, line: Float) -> bool:
    """Whether another facade's eaves stand above the roof."""
    ends = other.ends @ front.along
    inner = ends[0] + (ends[1] - ends[0]) * np.linspace(0.1, 0.9, 9)
    where = (inner - ends[0]) / (ends[1] - ends[0] or 1.0)
    own = np.interp(other.eaves[0, 0] + where * np.ptp(other.eaves[:, 0]), *other.eaves.T)
    return bool((own > np.interp(inner, *line.T) + LEVEL).any())


def _shell(plan: Polygon, front: Front, line: Float, low: float) -> list[Surface]:
    """Ground, a wall per edge of the plan, a roof per piece of the eaves, upright steps between them."""
    ring = np.asarray(shapely.geometry.polygon.orient(plan).exterior.coords)[:-1]
    shell = [Surface(np.insert(ring[::-1], 2, low, axis=1), "GroundSurface")]
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        foot = np.insert(np.array([a, b]), 2, low, axis=1)
        shell.append(Surface(np.concatenate([foot, _top(a, b, front, line)[::-1]]), "WallSurface"))
    turn = np.column_stack([front.along, front.inward])
    level = Polygon(ring @ turn)
    for k in range(len(line) - 1):
        (s0, z0), (s1, z1) = line[k], line[k + 1]
        if s1 > s0:
            for part in shapely.get_parts(level.intersection(shapely.box(s0, -_FAR, s1, _FAR))):
                flat = np.asarray(shapely.geometry.polygon.orient(part).exterior.coords)[:-1]
                z = z0 + (z1 - z0) * (flat[:, 0] - s0) / (s1 - s0)
                shell.append(Surface(np.column_stack([flat @ turn.T, z]), "RoofSurface"))
            continue
        cut = shapely.intersection(shapely.LineString([(s0, -_FAR), (s0, _FAR)]), level)
        for edge in shapely.get_parts(cut):
            (_, d0), (_, d1) = sorted(edge.coords)
            near, far = (np.array([s0, d]) @ turn.T for d in (d0, d1))
            side = np.array([[*near, z0], [*near, z1], [*far, z1], [*far, z0]])
            shell.append(Surface(side, "WallSurface"))
    return shell


def _top(a: Float, b: Float, front: Front, line: Float) -> Float:
    """The upper edge (k, 3) m of the wall from a to b."""
    start, end = float(a @ front.along), float(b @ front.along)
    low, high = min(start, end), max(start, end)
    within = line[(line[:, 0] > low + _CLEAR / 2) & (line[:, 0] < high - _CLEAR / 2)]
    within = within if end > start else within[::-1]
    ends = np.interp([start, end], *line.T)
    share = (within[:, 0] - start) / (end - start) if len(within) else np.zeros(0)
    middle = np.column_stack([a + share[:, None] * (b - a), within[:, 1]])
    return np.concatenate([[[*a, ends[0]]], middle, [[*b, ends[1]]]])
