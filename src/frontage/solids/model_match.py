"""Matches measured buildings with buildings of a city model by the walls that lie on each other."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import Polygon

from frontage.geometry.arrays import Float
from frontage.model import Facade
from frontage.model.citymodel import CityBuilding
from frontage.model.masonry import MASONRY
from frontage.solids.brep import ring_edges
from frontage.solids.options import BuildOptions

_MIN_SHARE = 0.2  # share of a facade, or of all walls of a building that face it, that must lie on each other


@dataclass(frozen=True)
class ModelMatch:
    """Measured buildings that stand on the same buildings of the city model: the ids of both."""

    measured: tuple[str, ...]
    model: tuple[str, ...] = ()


def match_model(
    facades: Mapping[str, Sequence[Facade]], model: Sequence[CityBuilding], options: BuildOptions
) -> tuple[ModelMatch, ...]:
    """Matches measured buildings (id -> facades) with model buildings; each id occurs in one match only.

    A facade belongs to a model building if the building's walls within `max_offset` and `max_angle` cover a
    fifth of the facade, or the facade covers a fifth of them. A building without walls is matched by
    upright walls over the edges of its ground.
    """
    matches: list[tuple[list[str], set[str]]] = []
    for name, own in facades.items():
        found = {b.id for b in model if any(_lie_on_each_other(f, _walls(b, f), options) for f in own)}
        joined = [m for m in matches if m[1] & found]
        names = [n for m in joined for n in m[0]] + [name]
        matches = [m for m in matches if m not in joined]
        matches.append((names, found.union(*(m[1] for m in joined))))
    order = list(facades)
    made = [
        ModelMatch(tuple(sorted(n, key=order.index)), tuple(b.id for b in model if b.id in m))
        for n, m in matches
    ]
    return tuple(sorted(made, key=lambda m: order.index(m.measured[0])))


def facades_of_matches(
    facades: Mapping[str, Sequence[Facade]],
    matches: Sequence[ModelMatch],
    model: Sequence[CityBuilding],
    options: BuildOptions,
) -> list[tuple[str, ...]]:
    """Returns for every match the ids of the facades that stand on its buildings of the city model.

    The points of a party wall or of a jetty may be taken for the house next door. Such a facade goes to the
    match whose walls cover a fifth of it, if those of its own do not; any other stays with its own building.
    """
    every = {f.id: f for own in facades.values() for f in own}
    home = {f.id: k for k, m in enumerate(matches) for n in m.measured for f in facades[n]}
    walls = options.model_copy(update={"max_offset": max(options.max_offset, MASONRY.facade_reach)})
    for name, facade in every.items():
        if not matches[home[name]].model:
            continue
        own = [[b for b in model if b.id in m.model] for m in matches]
        share = [sum(_covered(facade, _walls(b, facade), walls)[0] for b in some) for some in own]
        least = _MIN_SHARE * shapely.make_valid(Polygon(facade.outline)).area
        best = int(np.argmax(share))
        if share[home[name]] < least <= share[best]:
            home[name] = best
    return [tuple(name for name in every if home[name] == k) for k in range(len(matches))]


def _walls(building: CityBuilding, facade: Facade) -> Iterator[Float]:
    """Yields wall rings (k, 3) of LoD2 or below, or upright rectangles over the edges of the ground.

    The rectangles stand in where the model has no walls, or where its heights have nothing in common with
    the facade's, as in models made from maps.
    """
    surfaces = [s for shell in building.level("2") if not shell.installation for s in shell.surfaces]
    z = facade.frame.apply(np.insert(facade.outline, 1, 0.0, axis=1))[:, 2]
    walls = [s.ring for s in surfaces if s.semantics == "WallSurface"]
    if any(r[:, 2].min() < z.max() and r[:, 2].max() > z.min() for r in walls):
        yield from walls
        return
    for ring in (s.ring for s in surfaces if s.semantics == "GroundSurface"):
        flat = ring if shapely.Polygon(ring[:, :2]).exterior.is_ccw else ring[::-1]
        for a, b in ring_edges(flat.tolist()):
            low, high = float(z.min()), float(z.max())
            yield np.array([[*p[:2], h] for p, h in ((a, low), (b, low), (b, high), (a, high))])


def _lie_on_each_other(facade: Facade, walls: Iterable[Float], options: BuildOptions) -> bool:
    """Decides whether walls near the facade's plane cover enough of it, or it covers enough of them."""
    covered, whole = _covered(facade, walls, options)
    area = shapely.make_valid(Polygon(facade.outline)).area
    return covered > 0 and (covered > _MIN_SHARE * area or covered > _MIN_SHARE * whole)


def _covered(facade: Facade, walls: Iterable[Float], options: BuildOptions) -> tuple[float, float]:
    """Returns how much (m2) of a facade the walls near its plane cover, and how large these walls are."""
    outline = shapely.make_valid(Polygon(facade.outline))
    covered = whole = 0.0
    limit = np.cos(np.radians(options.max_angle))
    for ring in walls:
        in_facade = facade.frame.inverse.apply(ring)
        normal = np.cross(in_facade[1:-1] - in_facade[0], in_facade[2:] - in_facade[0]).sum(0)
        if -normal[1] < limit * np.linalg.norm(normal) or abs(in_facade[:, 1].mean()) > options.max_offset:
            continue
        projected = shapely.make_valid(Polygon(in_facade[:, [0, 2]]))
        covered += float(projected.intersection(outline).area)
        whole += float(projected.area)
    return covered, whole
