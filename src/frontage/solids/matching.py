"""Which buildings of a city model do facades belong to? By the walls that lie where they were measured."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import Polygon

from frontage.geometry.arrays import Float
from frontage.model import Facade
from frontage.model.citymodel import CityBuilding
from frontage.solids.relief import BuildOptions

_SHARE = 0.2  # of a facade, or of all walls of a building facing it, that must lie on each other


@dataclass(frozen=True)
class Group:
    """Buildings of the scan that stand on the same buildings of the model: ids of both."""

    measured: tuple[str, ...]
    model: tuple[str, ...] = ()


def match_model(
    facades: Mapping[str, Sequence[Facade]], model: Sequence[CityBuilding], options: BuildOptions
) -> tuple[Group, ...]:
    """Groups of measured buildings (id -> facades) and model buildings; each id is in one group only.

    A facade belongs to a model building where its walls (or, without walls, the edges of its ground) within
    `max_offset` and `max_angle` cover a fifth of it, or it covers a fifth of them.
    """
    pairs: dict[str, list[str]] = {name: [] for name in facades}
    for name, own in facades.items():
        for b in model:
            if any(_meet(f, _walls(b, f), options) for f in own):
                pairs[name].append(b.id)
    groups: list[tuple[list[str], set[str]]] = []
    for name, found in pairs.items():
        joined = [g for g in groups if g[1] & set(found)]
        names = [n for g in joined for n in g[0]] + [name]
        groups = [g for g in groups if g not in joined]
        groups.append((names, set(found).union(*(g[1] for g in joined))))
    order = list(facades)
    made = [
        Group(tuple(sorted(n, key=order.index)), tuple(b.id for b in model if b.id in m)) for n, m in groups
    ]
    return tuple(sorted(made, key=lambda g: order.index(g.measured[0])))


def _walls(building: CityBuilding, facade: Facade) -> Iterator[Float]:
    """Wall rings (k, 3) of level 2 or below; rectangles over the ground's edges where there are none.

    Also where the model's heights have nothing to do with the facade's: maps have none.
    """
    surfaces = [s for shell in building.level("2") if not shell.installation for s in shell.surfaces]
    z = facade.frame.apply(np.insert(facade.outline, 1, 0.0, axis=1))[:, 2]
    walls = [s.ring for s in surfaces if s.semantics == "WallSurface"]
    if any(r[:, 2].min() < z.max() and r[:, 2].max() > z.min() for r in walls):
        yield from walls
        return
    for ring in (s.ring for s in surfaces if s.semantics == "GroundSurface"):
        flat = ring if shapely.Polygon(ring[:, :2]).exterior.is_ccw else ring[::-1]
        for a, b in zip(flat, np.roll(flat, -1, axis=0), strict=True):
            low, high = (np.array([z.min()]), np.array([z.max()]))
            yield np.array([np.r_[p[:2], h] for p, h in ((a, low), (b, low), (b, high), (a, high))])


def _meet(facade: Facade, walls: Iterable[Float], options: BuildOptions) -> bool:
    outline = shapely.make_valid(Polygon(facade.outline))
    covered = whole = 0.0
    limit = np.cos(np.radians(options.max_angle))
    for ring in walls:
        at = facade.frame.inverse.apply(ring)
        normal = np.cross(at[1:-1] - at[0], at[2:] - at[0]).sum(0)
        if -normal[1] < limit * np.linalg.norm(normal) or abs(at[:, 1].mean()) > options.max_offset:
            continue
        shadow = shapely.make_valid(Polygon(at[:, [0, 2]]))
        covered += float(shadow.intersection(outline).area)
        whole += float(shadow.area)
    return covered > 0 and (covered > _SHARE * outline.area or covered > _SHARE * whole)
