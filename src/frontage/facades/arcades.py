"""Distinguishes the wall of an arcade, which is seen under the front, from walls of rooms behind a front."""

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from frontage.facades.candidate import FacadeCandidate, sample_rays
from frontage.facades.scene import FacadeScene
from frontage.facades.street import crossings
from frontage.geometry.arrays import Bool, Float, Int
from frontage.model.masonry import MASONRY, TOLERANCES

_MOST = 0.5  # share that counts as most of it
_FEW = 0.1  # share that counts as next to nothing
# points that a free way may hold for every line of sight through it: columns behind the plane of a front
# return fewer points, frames and panes of shop windows return one or more
_FREE = 0.3
_BAND_M = 1.0  # m, least length of a band in the relief of a wall that closes a gap like the wall
_PLACE_M = 0.5  # m, twice the distance of the surroundings' points, so that none is empty by chance
_REVEAL_M = 0.3  # m beside a pier in which its own faces are seen


def with_open_arcades(
    candidates: list[FacadeCandidate], scene: FacadeScene, rng: np.random.Generator
) -> tuple[list[FacadeCandidate], frozenset[tuple[int, int]]]:
    """Returns the walls, and the pairs of front and wall of an arcade among them, as their numbers.

    The outlines of fronts over an arcade end at its ceiling, and at the sides of piers. What is seen there
    belongs to the wall of the arcade.
    """
    found, pairs = list(candidates), set[tuple[int, int]]()
    for number, inner in enumerate(candidates):
        rows = sample_rays(inner.wall.inliers, rng)
        xyz, sensors = scene.cloud.xyz[rows], scene.sensors(rows)
        for k, outer in enumerate(found):
            if stands_in_arcade(outer, inner, xyz, sensors, scene):
                found[k] = _opened(outer, inner, scene)
                pairs.add((k, number))
    return found, frozenset(pairs)


def _opened(outer: FacadeCandidate, inner: FacadeCandidate, scene: FacadeScene) -> FacadeCandidate:
    """Returns a front without the gaps between its piers, up to the first thing that closes them.

    That is above the wall that is seen in them: the front hides the top of this wall, and its lowest part may
    stand out, as an entablature does. A podium goes with the gap, because outlines have no holes. What stands
    near the plane bounds columns: they are narrower than their capitals, and recede at their sides.
    """
    cells = outer.cells
    gates = _Gates.of(outer, scene)
    ends = outer.wall.coordinates(scene.cloud.xyz[inner.wall.inliers])[:, 0]
    span = _span(outer, ends)
    top = inner.cells.corner[1] + inner.cells.cell * (np.flatnonzero(inner.cells.whole.any(1))[-1] + 1)
    top += float(inner.wall.point[2] - outer.wall.point[2])
    rows = cells.corner[1] + cells.cell * np.arange(cells.whole.shape[0])
    shut = cells.shut & (rows[:, None] >= top)
    closed = np.where(shut.any(0), rows[shut.argmax(0)], top)
    ceiling = np.minimum(gates.ceiling, closed)
    hall = gates.open & span
    gap = hall & (rows[:, None] < ceiling)
    if gap.any():
        wide = ndimage.binary_opening(~gates.open, np.ones(round(MASONRY.room_width / cells.cell), np.bool_))
        beside = span & ~wide & (rows[:, None] < np.median(ceiling[hall]))
        piers = _relief(outer, MASONRY.step_out + outer.wall.threshold)
        gap |= beside & ~ndimage.binary_closing(piers, np.ones((3, 3), np.bool_))
    return replace(outer, cells=replace(cells, whole=cells.whole & ~gap, shut=cells.shut & ~gap))


def stands_in_arcade(
    outer: FacadeCandidate, inner: FacadeCandidate, xyz: Float, sensors: Float, scene: FacadeScene
) -> bool:
    """Decides whether `inner` is the wall of an arcade, or of a storey that is set back, under `outer`.

    It faces the same way, no further behind than an arcade is deep, and ends at its ceiling. Most lines of
    sight from `sensors` (n, 3) m to its points xyz (n, 3) m local pass under the front where this leaves
    headroom above the ground or above a podium, and it does so over most of its width. Next to nothing closes
    the way there, as the frames and panes of shop windows would, and the ground of the street, or the top of
    the podium, goes on up to the wall.
    """
    depth = float((inner.wall.point - outer.wall.point) @ outer.wall.normal)
    same_way = outer.wall.normal @ inner.wall.normal > TOLERANCES.parallel_cos
    if not same_way or not MASONRY.relief < depth <= MASONRY.arcade:
        return False
    gates = _Gates.of(outer, scene)
    crosses, x, z = _ways(outer, xyz, sensors)
    column = _columns(outer, x)
    under = crosses & gates.open[column] & (z > gates.floor[column]) & (z < gates.ceiling[column])
    if under.mean() <= (_MOST if np.isfinite(sensors).any() else _FEW):
        return False
    q = outer.wall.coordinates(xyz)
    ceiling = float(np.median(gates.ceiling[column[under]])) + MASONRY.threshold
    span = _span(outer, q[:, 0])
    if gates.open[span & np.isfinite(gates.ceiling)].mean() <= _MOST or (q[:, 2] > ceiling).mean() > _FEW:
        return False
    return _is_free(outer, gates, under.sum()) and _goes_on(outer, gates, span, depth, scene)


@dataclass(frozen=True, eq=False)
class _Gates:
    """The gates of a front: headroom above the ground, or above a podium that is no higher than a person.

    floor    (w,) m, facade coordinates: the ground, or the top of the podium, in every column of its cells
    ceiling  (w,) m, the lowest wall above it; -inf in columns without wall
    open     (w,) whether there is headroom between both
    """

    floor: Float
    ceiling: Float
    open: Bool

    @classmethod
    def of(cls, outer: FacadeCandidate, scene: FacadeScene) -> "_Gates":
        """Finds the gates of a front."""
        cells, foot = outer.cells, scene.ground_z - outer.wall.point[2]
        h = cells.wall.shape[0]
        rows = cells.corner[1] + cells.cell * np.arange(h + 1)
        solid = cells.wall | _long_relief(outer)
        above = np.minimum.accumulate(np.where(solid, np.arange(h)[:, None], h)[::-1], 0)[::-1]
        floor = np.maximum(rows[:-1], foot)[:, None]
        clear = (above < h) & (rows[above] - floor >= MASONRY.door_height) & (floor <= foot + MASONRY.person)
        start = clear.argmax(0)  # the lowest row with headroom above it, or the first row
        at = above[start, np.arange(len(start))]
        return cls(floor[start, 0], np.where(at < h, rows[at], -np.inf), clear.any(0))


def _ways(outer: FacadeCandidate, xyz: Float, sensors: Float) -> tuple[Bool, Float, Float]:
    """Returns which ways to points (n, 3) m local cross the outer wall, and where they do, as `crossings`.

    If no sensor is known, the shortest ways are used. Unlike lines of sight, they pass no pier at an angle.
    """
    if np.isfinite(sensors).any():
        return crossings(outer.wall, xyz, sensors)
    x, y, z = outer.wall.coordinates(xyz).T
    return y > outer.wall.threshold, x, z


def _goes_on(outer: FacadeCandidate, gates: _Gates, span: Bool, depth: float, scene: FacadeScene) -> bool:
    """Decides whether a floor was measured in most places behind the gates, as high as that of the gates.

    `span` (w,) are the columns of the outer wall's cells before a wall at a depth of `depth` m. A place is a
    strip of `_PLACE_M` of the width.
    """
    q, hall = outer.wall.coordinates(scene.around), gates.open & span
    level = np.abs(q[:, 2] - np.median(gates.floor[hall])) < MASONRY.threshold
    behind = (q[:, 1] > MASONRY.relief / 2.0) & (q[:, 1] < depth - MASONRY.relief / 2.0)
    at = np.flatnonzero(hall)
    wide = max(1, round(_PLACE_M / outer.cells.cell))
    column = _columns(outer, q[level & behind, 0])
    floor = np.intersect1d(column[hall[column]] // wide, at // wide)
    return bool(len(floor) > _MOST * len(np.unique(at // wide)))


def _long_relief(outer: FacadeCandidate) -> Bool:
    """Returns the cells (h, w) of bands and columns in the relief of a wall, which stand off its plane.

    Bands are longer than a person is wide, and columns as high as a door.
    """
    held, cell = _relief(outer, MASONRY.relief), outer.cells.cell
    band, column = (round(size / cell) for size in (_BAND_M, MASONRY.door_height))
    long: Bool = ndimage.binary_opening(held, np.ones((1, band), np.bool_))
    return long | ndimage.binary_opening(held, np.ones((column, 1), np.bool_))


def _relief(outer: FacadeCandidate, behind: float) -> Bool:
    """Returns the cells (h, w) of a wall that hold points of its relief, at most `behind` m behind it."""
    q = outer.slab.q
    q = q[(q[:, 1] > -MASONRY.relief) & (q[:, 1] < behind)]
    return outer.cells.marked(q[:, 0], q[:, 2])


def _columns(outer: FacadeCandidate, x: Float) -> Int:
    """Returns the columns (n,) of the cells of a wall that points at x (n,) m lie in."""
    cells = outer.cells
    return np.clip(np.floor((x - cells.corner[0]) / cells.cell), 0, cells.wall.shape[1] - 1).astype(np.int64)


def _span(outer: FacadeCandidate, x: Float) -> Bool:
    """Returns which columns of the cells of a wall lie between the leftmost and rightmost of x (n,) m."""
    first, last = _columns(outer, np.array([x.min(), x.max()]))
    number = np.arange(outer.cells.wall.shape[1])
    return np.asarray((number >= first) & (number <= last))


def _is_free(outer: FacadeCandidate, gates: _Gates, through: int) -> bool:
    """Decides whether few points were measured in the gates, given how many lines of sight go `through`.

    The faces of piers do not count. Columns may stand somewhat behind the plane of the front.
    """
    q = outer.slab.q
    reach = int(np.ceil(_REVEAL_M / outer.cells.cell))
    middle = ndimage.binary_erosion(gates.open, np.ones(2 * reach + 1, np.bool_), border_value=1)
    column = _columns(outer, q[:, 0])
    below = gates.ceiling[column] - q[:, 2]
    inside = middle[column] & (below > _REVEAL_M) & (below < MASONRY.door_height)
    return bool((inside & (np.abs(q[:, 1]) < MASONRY.relief)).sum() < _FREE * through)
