"""Interiors: walls that were measured through the openings of a larger facade."""

from dataclasses import replace

import numpy as np

from frontage.facades.cells import CellMap, largest_part, occupied, widest_gap
from frontage.facades.front import FRONT, Front, Scene, some_of
from frontage.facades.street import beside, crossings
from frontage.geometry.arrays import Bool, Float, Int
from frontage.model.masonry import TOLERANCES

_SEEN_THROUGH = 0.5  # share of a wall's points measured through another facade that makes it an interior
_LEAK = 0.15  # share of the chance crossings of shut cells that an interior may still have (curtains, frames)
_EXPLAINED = 0.8  # share of a wall's points that one place in front must see to explain it
_GRAZING = 0.25  # sine of the angle (15 degrees) below which a surface returns nothing
_SIGHTS = 500  # lines of sight per plausible place
_COVER = 0.5  # m, cells of the wall extended over its neighbours
_COURT_WALL = 4.0  # m behind a front: a wall that looks the same way has a room and a court before it
_WHOLLY = 0.95  # share of a wall's points that lie behind the outline of a front that covers it
_ROOM = 12.0  # m: how far behind a facade its rooms reach
_OPEN = 0.25  # share of the strip before a wall that is open ground when it stands outside
_COURT = 2.0  # open ground over built-up area before it: the floor of a room has as much of both
_AWAY = 0.5  # cosine between outward normals below which a wall looks away from another
_TALL = 0.5  # of a front's height that its far side has at least: walls of rooms are a storey high


def drop_interiors(fronts: list[Front], scene: Scene, rng: np.random.Generator) -> list[Front]:
    """Leave out walls most of whose points lie behind a larger facade and were seen through its openings.

    With rays that is measured: lines of sight cross the facade, or its neighbours in the same plane, under
    and between its wall; a wall set back is seen over or beside it. Without, a wall close behind a larger one
    that looks the same way and nowhere reaches beyond it is a room's, for no house and court fit between;
    others are outside only if open ground lies before them, in a cloud cut out without its ground also if
    they look away from the larger one with nothing beyond, tall as it (the far side of a tower), and no place
    in front explains them.
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
    covers = _covers(outer, scene)
    if outer.side.told_by == "rays":
        crosses, x, z = crossings(wall, xyz, scene.scan.sensor_of(scene.cloud.index[rows]))
        return bool((crosses & _within(covers, x, z)).mean() > _SEEN_THROUGH)
    near = (q[:, 1] > FRONT) & (q[:, 1] < _COURT_WALL) & _with_gates(outer).within(q[:, 0], q[:, 2])
    if near.mean() > _WHOLLY and wall.normal @ inner.wall.normal > TOLERANCES.parallel_cos:
        return True
    room = (q[:, 1] > FRONT) & (q[:, 1] < _ROOM) & _within(covers, q[:, 0], q[:, 2])
    if room.mean() <= _SEEN_THROUGH:
        return False
    ground, mass, strip = beside(inner.wall, inner.cells, scene.around, scene.ground_z)
    if ground > max(_COURT * mass, _OPEN * strip):
        return False
    street, _, length = beside(wall, outer.cells, scene.around, scene.ground_z)
    far_side = outer.wall.normal @ inner.wall.normal < -_AWAY and mass < _OPEN * strip
    far_side &= inner.cells.size[1] > _TALL * outer.cells.size[1]
    return street > _OPEN * length or not far_side or _explained_by_a_place(outer, inner, xyz)


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
        crosses, x, z = crossings(wall, some, place[None], 0.5)
        inside = (crosses & outer.cells.within(x, z)).mean()
        closed = (crosses & outer.cells.within(x, z, outer.cells.shut)).mean()
        if inside > _EXPLAINED and closed < _LEAK * inside * shut:
            return True
    return False


def _covers(front: Front, scene: Scene) -> tuple[CellMap, CellMap]:
    """Where a line of sight goes through the wall, not past it: the outline with its gates, and the outline
    continued over what adjoins it in its plane (a room at the end of a house is seen through the neighbour's
    windows too).
    """
    q = front.wall.coordinates(scene.around)
    q = q[np.abs(q[:, 1]) < FRONT]
    own = front.slab.at(np.flatnonzero(np.abs(front.slab.q[:, 1]) < front.wall.threshold))
    own = own[front.cells.within(own[:, 0], own[:, 2])]
    x, z = np.concatenate([q[:, 0], own[:, 0]]), np.concatenate([q[:, 2], own[:, 2]])
    count, corner, _ = occupied(x, z, _COVER)
    row = largest_part(count, corner, _COVER, own, widest_gap(0.0)) or front.cells
    gates = _with_gates(front)
    # a side wall at its end is not behind it
    row = replace(row, whole=row.shrunk(_COVER) & _has_above(row.wall))
    return replace(gates, whole=gates.shrunk(_COVER)), row


def _within(covers: tuple[CellMap, CellMap], x: Float, z: Float) -> Bool:
    """Whether points (n,) on the wall's plane fall on either map."""
    return covers[0].within(x, z) | covers[1].within(x, z)


def _with_gates(front: Front) -> CellMap:
    """The outline with every gap in its border that has wall on both sides and above it: gates, shop windows,
    arcades, however wide. What has none above it is open sky, what has none beside it lies under an overhang.
    """
    cells = front.cells
    near = front.slab.at(np.flatnonzero(np.abs(front.slab.q[:, 1]) < FRONT))
    stands = np.zeros(cells.whole.size, np.bool_)
    stands[cells.flat(near[:, 0], near[:, 2])] = True
    stands = stands.reshape(cells.whole.shape) & cells.whole.any(0)
    left, right = (np.logical_or.accumulate(stands[:, ::way], 1)[:, ::way] for way in (1, -1))
    return replace(cells, whole=(cells.whole | (left & right)) & _has_above(cells.wall))


def _has_above(wall: Bool) -> Bool:
    """Cells (h, w), rows upwards, that are wall or have some above them."""
    return np.asarray(np.logical_or.accumulate(wall[::-1], 0)[::-1], np.bool_)
