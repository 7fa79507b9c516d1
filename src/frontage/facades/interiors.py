"""Interiors: walls that were measured through the openings of a larger facade."""

from dataclasses import replace

import numpy as np

from frontage.facades.cells import CellMap, largest_part, occupied, widest_gap
from frontage.facades.front import FRONT, Front, Scene, some_of
from frontage.facades.street import beside, seen_through
from frontage.geometry.arrays import Float, Int

_SEEN_THROUGH = 0.5  # share of a wall's points measured through another facade that makes it an interior
_LEAK = 0.15  # share of the chance crossings of shut cells that an interior may still have (curtains, frames)
_GRAZING = 0.25  # sine of the angle (15 degrees) below which a surface returns nothing
_SIGHTS = 500  # lines of sight per plausible place
_COVER = 0.5  # m, cells of the wall extended over its neighbours
_ROOM = 12.0  # m: how far behind a facade its rooms reach
_OPEN = 0.25  # share of the strip before a wall that is open ground when it stands outside
_COURT = 2.0  # open ground over built-up area before it: the floor of a room has as much of both
_AWAY = 0.5  # cosine between outward normals below which a wall looks away from another


def drop_interiors(fronts: list[Front], scene: Scene, rng: np.random.Generator) -> list[Front]:
    """Leave out walls most of whose points lie behind a larger facade and were seen through its openings.

    With rays that is measured: lines of sight cross the facade, or its neighbours in the same plane.
    Without, a wall behind a larger one is outside only if open ground lies before it; in a cloud cut out
    without its ground also if it looks away from the larger one with nothing beyond (the far side of a
    tower) and no place in front explains it.
    """
    kept = []
    for inner in fronts:
        rows = some_of(inner.wall.inliers, rng)
        larger = (f for f in fronts if f.cells.area > inner.cells.area)
        if not any(_is_interior(outer, inner, rows, scene) for outer in larger):
            kept.append(inner)
    return kept


def _is_interior(outer: Front, inner: Front, rows: Int, scene: Scene) -> bool:
    """Whether `inner`, with the points `rows` of the cloud, is an interior behind `outer`."""
    wall, xyz = outer.wall, scene.cloud.xyz[rows]
    q = wall.coordinates(xyz)
    if (q[:, 1] > FRONT).mean() < _SEEN_THROUGH:
        return False
    cover = _cover(outer, scene)
    if outer.side.told_by == "rays":
        sensors = scene.scan.sensor_of(scene.cloud.index[rows])
        return seen_through(wall, cover, xyz, sensors)[0] > _SEEN_THROUGH
    room = (q[:, 1] > FRONT) & (q[:, 1] < _ROOM) & cover.within(q[:, 0], q[:, 2])
    if room.mean() <= _SEEN_THROUGH:
        return False
    ground, mass, strip = beside(inner.wall, inner.cells, scene.around, scene.ground_z)
    if ground > max(_COURT * mass, _OPEN * strip):
        return False
    street, _, length = beside(wall, outer.cells, scene.around, scene.ground_z)
    looks_away = outer.wall.normal @ inner.wall.normal < -_AWAY and mass < _OPEN * strip
    return street > _OPEN * length or not looks_away or _explained_by_a_place(outer, inner, xyz)


def _explained_by_a_place(outer: Front, inner: Front, xyz: Float) -> bool:
    """Whether from some plausible place in front of `outer` most points (n, 3) of `inner` are seen, not
    edge-on, through the holes of `outer` and hardly any through what is shut.
    """
    wall = outer.wall
    shut = float(outer.cells.shut.sum() / max(outer.cells.whole.sum(), 1))
    some = xyz[:: max(1, len(xyz) // _SIGHTS)]
    for place in outer.side.sensors @ wall.axes.T + wall.point:
        sight = place - inner.wall.point
        if abs(sight @ inner.wall.normal) < _GRAZING * np.linalg.norm(sight):
            continue
        inside, closed = seen_through(wall, outer.cells, some, place[None], 0.5)
        if inside > _SEEN_THROUGH and closed < _LEAK * inside * shut:
            return True
    return False


def _cover(front: Front, scene: Scene) -> CellMap:
    """The wall's outline continued over what adjoins it in its plane: a room at the end of a house is seen
    through the neighbour's windows too.
    """
    q = front.wall.coordinates(scene.around)
    q = q[np.abs(q[:, 1]) < FRONT]
    if len(q) < 10:
        return front.cells
    own = front.slab.at(np.flatnonzero(np.abs(front.slab.q[:, 1]) < front.wall.threshold))
    own = own[front.cells.within(own[:, 0], own[:, 2])]
    x, z = np.concatenate([q[:, 0], own[:, 0]]), np.concatenate([q[:, 2], own[:, 2]])
    count, corner, _ = occupied(x, z, _COVER)
    cover = largest_part(count, corner, _COVER, own, widest_gap(0.0)) or front.cells
    return replace(cover, whole=cover.shrunk(_COVER))  # a side wall at its end is not behind it
