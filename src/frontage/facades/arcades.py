"""Distinguishes the wall of an arcade, which is seen under the front, from walls of rooms behind a front."""

from dataclasses import replace

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
            if outer.cells.area > inner.cells.area and stands_in_arcade(outer, inner, xyz, sensors, scene):
                found[k] = _opened(outer, inner, scene)
                pairs.add((k, number))
    return found, frozenset(pairs)


def _opened(outer: FacadeCandidate, inner: FacadeCandidate, scene: FacadeScene) -> FacadeCandidate:
    """Returns a front without the gaps between its piers, up to the top of the wall that is seen there."""
    cells = outer.cells
    lowest, gates = _gates(outer, scene)
    ends = outer.wall.coordinates(scene.cloud.xyz[inner.wall.inliers])[:, 0]
    before = gates & _span(outer, ends)
    top = inner.cells.corner[1] + inner.cells.cell * (np.flatnonzero(inner.cells.whole.any(1))[-1] + 1)
    top += float(inner.wall.point[2] - outer.wall.point[2])
    rows = cells.corner[1] + cells.cell * np.arange(cells.whole.shape[0])
    gap = before & (rows[:, None] < np.minimum(lowest, top))
    return replace(outer, cells=replace(cells, whole=cells.whole & ~gap, shut=cells.shut & ~gap))


def stands_in_arcade(
    outer: FacadeCandidate, inner: FacadeCandidate, xyz: Float, sensors: Float, scene: FacadeScene
) -> bool:
    """Decides whether `inner` is the wall of an arcade, or of a storey that is set back, under `outer`.

    It faces the same way, no further behind than an arcade is deep, and ends at its ceiling. Most lines of
    sight from `sensors` (n, 3) m to its points xyz (n, 3) m local pass under the front where this leaves
    headroom above the ground, and it does so over most of its width. Next to nothing closes the way there, as
    the frames and panes of shop windows would, and the ground of the street goes on up to the wall.
    """
    depth = float((inner.wall.point - outer.wall.point) @ outer.wall.normal)
    same_way = outer.wall.normal @ inner.wall.normal > TOLERANCES.parallel_cos
    if not same_way or not MASONRY.relief < depth <= MASONRY.arcade:
        return False
    lowest, gates = _gates(outer, scene)
    crosses, x, z = _ways(outer, xyz, sensors)
    column = _columns(outer, x)
    under = crosses & gates[column] & (z < lowest[column])
    if under.mean() <= (_MOST if np.isfinite(sensors).any() else _FEW):
        return False
    q = outer.wall.coordinates(xyz)
    ceiling = float(np.median(lowest[column[under]])) + MASONRY.threshold
    span = _span(outer, q[:, 0])
    if gates[span & np.isfinite(lowest)].mean() <= _MOST or (q[:, 2] > ceiling).mean() > _FEW:
        return False
    return _is_free(outer, lowest, gates, under.sum()) and _goes_on(outer, gates & span, depth, scene)


def _ways(outer: FacadeCandidate, xyz: Float, sensors: Float) -> tuple[Bool, Float, Float]:
    """Returns which ways to points (n, 3) m local cross the outer wall, and where they do, as `crossings`.

    If no sensor is known, the shortest ways are used. Unlike lines of sight, they pass no pier at an angle.
    """
    if np.isfinite(sensors).any():
        return crossings(outer.wall, xyz, sensors)
    x, y, z = outer.wall.coordinates(xyz).T
    return y > outer.wall.threshold, x, z


def _goes_on(outer: FacadeCandidate, hall: Bool, depth: float, scene: FacadeScene) -> bool:
    """Decides whether ground was measured in most places behind the gates, at the height of the street.

    `hall` are the columns of the outer wall's cells whose gates lead to a wall at a depth of `depth` m. A
    place is a strip of `_PLACE_M` of the width.
    """
    q = outer.wall.coordinates(scene.around)
    level = np.abs(scene.around[:, 2] - scene.ground_z) < MASONRY.threshold
    behind = (q[:, 1] > MASONRY.relief / 2.0) & (q[:, 1] < depth - MASONRY.relief / 2.0)
    at = np.flatnonzero(hall)
    wide = max(1, round(_PLACE_M / outer.cells.cell))
    column = _columns(outer, q[level & behind, 0])
    floor = np.intersect1d(column[hall[column]] // wide, at // wide)
    return bool(len(floor) > _MOST * len(np.unique(at // wide)))


def _gates(outer: FacadeCandidate, scene: FacadeScene) -> tuple[Float, Bool]:
    """Returns the height (m, facade coordinates) of the lowest wall of every column, and which are open."""
    cells = outer.cells
    wall = cells.wall.any(0)
    lowest = np.where(wall, cells.corner[1] + cells.cell * cells.wall.argmax(0), -np.inf)
    foot = scene.ground_z - outer.wall.point[2]
    return lowest, np.asarray(lowest - foot >= MASONRY.door_height, np.bool_)


def _columns(outer: FacadeCandidate, x: Float) -> Int:
    """Returns the columns (n,) of the cells of a wall that points at x (n,) m lie in."""
    cells = outer.cells
    return np.clip(np.floor((x - cells.corner[0]) / cells.cell), 0, cells.wall.shape[1] - 1).astype(np.int64)


def _span(outer: FacadeCandidate, x: Float) -> Bool:
    """Returns which columns of the cells of a wall lie between the leftmost and rightmost of x (n,) m."""
    first, last = _columns(outer, np.array([x.min(), x.max()]))
    number = np.arange(outer.cells.wall.shape[1])
    return np.asarray((number >= first) & (number <= last))


def _is_free(outer: FacadeCandidate, lowest: Float, gates: Bool, through: int) -> bool:
    """Decides whether few points were measured in the gates, given how many lines of sight go `through`.

    The faces of piers do not count. Columns may stand somewhat behind the plane of the front.
    """
    q = outer.slab.q
    reach = int(np.ceil(_REVEAL_M / outer.cells.cell))
    middle = ndimage.binary_erosion(gates, np.ones(2 * reach + 1, np.bool_), border_value=1)
    column = _columns(outer, q[:, 0])
    below = lowest[column] - q[:, 2]
    inside = middle[column] & (below > _REVEAL_M) & (below < MASONRY.door_height)
    return bool((inside & (np.abs(q[:, 1]) < MASONRY.relief)).sum() < _FREE * through)
