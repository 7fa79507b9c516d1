"""Drop interiors: walls that were measured through the openings of a larger facade."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from frontage.facades.arcades import stands_in_arcade
from frontage.facades.bows import is_strip_beside
from frontage.facades.candidate import FacadeCandidate, sample_rays
from frontage.facades.cells import CellMap
from frontage.facades.corners import APART_M, is_side
from frontage.facades.galleries import without_galleries
from frontage.facades.outline import at_or_below, largest_part, occupied, widest_gap
from frontage.facades.plane.connected import RELIEF_M
from frontage.facades.roomfaces import without_room_faces
from frontage.facades.scene import FacadeScene
from frontage.facades.street import SEEN_THROUGH, StripBefore, crossings, share_through, strip_before
from frontage.geometry.arrays import Bool, Float, Int
from frontage.model.masonry import MASONRY, TOLERANCES

_LEAK = 0.15  # share of chance crossings of shut cells that an interior may still have (curtains, frames)
_EXPLAINED = 0.8  # share of a wall's points that one sensor place must see to explain it
_GRAZING_SINE = 0.25  # sine of 15 degrees, below which a surface returns nothing
_STEEPEST_SINE = 0.5  # sine of 30 degrees: flatter lines do not pass through the openings of a wall
_MOST_LINES = 500  # lines of sight per plausible sensor
_ADJOINING_CELL_M = 0.5  # m, cells of the wall extended over its neighbours
_COURT_DEPTH_M = 4.0  # m behind a front: nearer than this, no house and court fit between two walls
_WHOLLY = 0.95  # share of a wall's points that lie behind the outline of a front that covers it
_ROOM_DEPTH_M = 12.0  # m: how far behind a facade its rooms reach
_AWAY_COS = 0.5  # cosine between outward normals, below minus which a wall faces away from another
_TALL = 0.5  # share of a front's height that its far side has, at least; walls of rooms are one storey high


def drop_interiors(
    candidates: list[FacadeCandidate],
    scene: FacadeScene,
    rng: np.random.Generator,
    known: Sequence[FacadeCandidate] = (),
) -> list[FacadeCandidate]:
    """Removes walls most of whose points lie behind a larger facade and were seen through its openings.

    The fronts of galleries before a larger wall are removed first: they are layers of that wall. Walls of
    rooms that were scanned from within are removed as well.

    With rays this is measured: lines of sight cross the larger facade, or its neighbours in the same plane,
    under and between its wall. A wall that is set back is seen over or beside the facade and stays, and so
    does the wall of an arcade. Panes mirror what stands before them, so that a wall of windows may show more
    behind it than it has wall itself: a larger wall is dropped where it was seen through the facade wholly.

    Without rays the rules are:

    - The wall of an arcade stays, and so does the side of the house, which goes on round the end of a front.
    - A wall close behind a larger one that faces the same way, and nowhere reaches beyond it, belongs to a
      room, because no house and court fit between.
    - A wall that begins behind a larger one, and past which that one runs, is seen from within only, unless
      open ground lies between.
    - Any other wall behind a larger one stands outside only if open ground lies before it.
    - In a cloud that was cut out without its ground, a wall also stands outside if it is the far side of a
      tower (it faces away, is tall, and has nothing built before it) and no sensor place explains it.

    known  walls that are facades, which may show interiors as well
    """
    candidates = without_room_faces(without_galleries(candidates, scene, rng.spawn(1)[0]), scene, known)
    kept = []
    for inner in candidates:
        rows = sample_rays(inner.wall.inliers, rng)
        others = [outer for outer in (*known, *candidates) if outer is not inner]
        is_interior = any(_is_interior(outer, inner, rows, scene) for outer in others)
        if not is_interior or (inner.side.told_by != "rays" and is_strip_beside(inner, others)):
            kept.append(inner)
    return kept


def _is_interior(outer: FacadeCandidate, inner: FacadeCandidate, rows: Int, scene: FacadeScene) -> bool:
    """Decides whether `inner`, with the points `rows` (n,) of the cloud, is an interior behind `outer`."""
    xyz = scene.cloud.xyz[rows]
    q = outer.wall.coordinates(xyz)
    is_larger, has_rays = outer.cells.area > inner.cells.area, outer.side.told_by == "rays"
    if not (is_larger or has_rays) or not _lies_behind(q):
        return False
    sensors = scene.sensors(rows)
    if has_rays:
        least = SEEN_THROUGH if is_larger else _WHOLLY
        through = share_through(outer.wall, _Covers.of(outer, scene).hold, xyz, sensors) > least
        return through and not stands_in_arcade(outer, inner, xyz, sensors, scene)
    if is_side(outer, inner) or stands_in_arcade(outer, inner, xyz, sensors, scene):
        return False
    if _faces_the_same_way(outer, inner) and _is_covered_without_a_court(outer, q):
        return True
    if _is_inner_face(outer, inner, q, scene):
        return True
    if not _lies_where_rooms_are(_Covers.of(outer, scene), q):
        return False
    before = strip_before(inner.wall, inner.cells, scene.around, scene.ground_z)
    if before.is_outdoors:
        return False
    if strip_before(outer.wall, outer.cells, scene.around, scene.ground_z).has_open_ground:
        return True  # ground was measured here, so an outer wall would show some before it
    return not _is_far_side(outer, inner, before) or _is_explained_by_a_sensor(outer, inner, xyz)


def _lies_behind(q: Float) -> bool:
    """Decides whether most points (n, 3) m, facade coordinates, lie behind the facade's relief."""
    return bool((q[:, 1] > RELIEF_M).mean() >= SEEN_THROUGH)


def _faces_the_same_way(outer: FacadeCandidate, inner: FacadeCandidate) -> bool:
    """Decides whether both walls face the same way, within 15 degrees."""
    return bool(outer.wall.normal @ inner.wall.normal > TOLERANCES.parallel_cos)


def _is_covered_without_a_court(outer: FacadeCandidate, q: Float) -> bool:
    """Decides whether the outer wall covers all points (n, 3) m, too close behind it for a court between."""
    close = (q[:, 1] > RELIEF_M) & (q[:, 1] < _COURT_DEPTH_M)
    return bool((close & _with_gates(outer).within(q[:, 0], q[:, 2])).mean() > _WHOLLY)


def _lies_where_rooms_are(covers: "_Covers", q: Float) -> bool:
    """Decides whether most points (n, 3) m lie behind the outer wall and within the depth of its rooms."""
    deep = (q[:, 1] > RELIEF_M) & (q[:, 1] < _ROOM_DEPTH_M)
    return bool((deep & covers.hold(q[:, 0], q[:, 2])).mean() > SEEN_THROUGH)


def _is_inner_face(outer: FacadeCandidate, inner: FacadeCandidate, q: Float, scene: FacadeScene) -> bool:
    """Decides whether a wall behind a front is seen from within only.

    q (n, 3) m are its points in the facade coordinates of the front. It begins behind the front, which runs
    past it and hides it, and no open ground was measured there before it: it is the side of a room or of an
    arcade, or the inner face of the house's own side.
    """
    near, far = np.quantile(q[:, 1], (1.0 - _WHOLLY, _WHOLLY))
    if abs(near) >= APART_M or far - near <= APART_M:
        return False
    hidden = _with_gates(outer)
    past = q - (inner.wall.normal @ outer.wall.axes) * (MASONRY.half_brick + outer.cells.cell)
    if hidden.within(past[:, 0], past[:, 2]).mean() < _WHOLLY:
        return False
    around = outer.wall.coordinates(scene.around)
    behind = (around[:, 1] > RELIEF_M) & (around[:, 1] < _ROOM_DEPTH_M)
    behind &= hidden.within(around[:, 0], around[:, 2])
    return not strip_before(inner.wall, inner.cells, scene.around[behind], scene.ground_z).is_outdoors


def _is_far_side(outer: FacadeCandidate, inner: FacadeCandidate, before: StripBefore) -> bool:
    """Decides whether `inner` may be the far side of a tower whose near side is `outer`."""
    faces_away = outer.wall.normal @ inner.wall.normal < -_AWAY_COS
    is_tall = inner.cells.size[1] > _TALL * outer.cells.size[1]
    return bool(faces_away and before.is_free_of_buildings and is_tall)


def _is_explained_by_a_sensor(outer: FacadeCandidate, inner: FacadeCandidate, xyz: Float) -> bool:
    """Decides whether some plausible sensor before `outer` sees most points (n, 3) m of `inner` through it.

    The sensor must not see `inner` edge-on, and hardly any line may pass through shut cells of `outer`.
    """
    wall = outer.wall
    shut = float(outer.cells.shut.sum() / max(outer.cells.whole.sum(), 1))
    some = xyz[:: max(1, len(xyz) // _MOST_LINES)]
    for sensor in outer.side.sensors @ wall.axes.T + wall.point:
        line = sensor - inner.wall.point
        if abs(line @ inner.wall.normal) < _GRAZING_SINE * np.linalg.norm(line):
            continue
        crosses, x, z = crossings(wall, some, sensor[None], _STEEPEST_SINE)
        inside = (crosses & outer.cells.within(x, z)).mean()
        closed = (crosses & outer.cells.within(x, z, outer.cells.shut)).mean()
        if inside > _EXPLAINED and closed < _LEAK * inside * shut:
            return True
    return False


@dataclass(frozen=True, eq=False)
class _Covers:
    """Where a line of sight passes through a wall and not past it.

    That is the outline with its gates, and the outline continued over the walls that adjoin it in its plane:
    a room at the end of a house is seen through the neighbour's windows too.
    """

    own: CellMap
    row: CellMap

    @classmethod
    def of(cls, facade: FacadeCandidate, scene: FacadeScene) -> "_Covers":
        """Maps the wall of a facade and of its neighbours."""
        q = facade.wall.coordinates(scene.around)
        q = q[np.abs(q[:, 1]) < RELIEF_M]
        own = facade.slab.at(np.flatnonzero(np.abs(facade.slab.q[:, 1]) < facade.wall.threshold))
        own = own[facade.cells.within(own[:, 0], own[:, 2])]
        x, z = np.concatenate([q[:, 0], own[:, 0]]), np.concatenate([q[:, 2], own[:, 2]])
        count, corner, _ = occupied(x, z, _ADJOINING_CELL_M)
        row = largest_part(count, corner, _ADJOINING_CELL_M, own, widest_gap(0.0)) or facade.cells
        gates = _with_gates(facade, q)
        # shrunk, because a side wall at the end of a facade is not behind it
        row = replace(row, whole=row.shrunk(_ADJOINING_CELL_M) & at_or_below(row.wall))
        return cls(replace(gates, whole=gates.shrunk(_ADJOINING_CELL_M)), row)

    def hold(self, x: Float, z: Float) -> Bool:
        """Returns whether points (n,) m on the wall's plane fall on either map."""
        return self.own.within(x, z) | self.row.within(x, z)


def _with_gates(facade: FacadeCandidate, beside: Float | None = None) -> CellMap:
    """Adds to the outline every gap in its border with wall on both sides and above it, however wide.

    These are gates, shop windows and arcades. A gap without wall above it is open sky; one without wall
    beside it lies under an overhang. The pier at the end may belong to the neighbour: `beside` (n, 3) m,
    facade coordinates, are points in the plane of whatever stands there.
    """
    cells = facade.cells
    near = facade.slab.at(np.flatnonzero(np.abs(facade.slab.q[:, 1]) < RELIEF_M))
    standing = _held(near, cells) & cells.whole.any(0)
    if beside is not None:  # in a cloud that was thinned: every point stands for what is above and below it
        reach = 2 * int(_ADJOINING_CELL_M / cells.cell) + 1
        standing |= ndimage.binary_dilation(_held(beside, cells), np.ones((reach, 1), np.bool_))
    left, right = (np.logical_or.accumulate(standing[:, ::way], 1)[:, ::way] for way in (1, -1))
    return replace(cells, whole=(cells.whole | (left & right)) & at_or_below(cells.wall))


def _held(q: Float, cells: CellMap) -> Bool:
    """Returns the cells (h, w) that hold any of the points q (n, 3) m, facade coordinates."""
    at = ((q[:, [2, 0]] - np.array(cells.corner)[::-1]) / cells.cell).astype(np.int64)
    row, column = at[((at >= 0) & (at < cells.whole.shape)).all(1)].T
    held = np.zeros(cells.whole.shape, np.bool_)
    held[row, column] = True
    return held
