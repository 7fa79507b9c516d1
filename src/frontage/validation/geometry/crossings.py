"""Which triangles meet where they should not: exact, after a search over boxes.

Triangles are closed: touching counts. What two triangles share by construction, a vertex or an edge with the
same number, does not count; anything beyond it does.
"""

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float, Int
from frontage.validation.geometry.predicates import Sign, drop_axis, orient2d, orient3d, without_axis


def box_pairs(xyz: Float, first: Int, second: Int | None, slack: float) -> Int:
    """Pairs (n, 2) of triangles whose boxes, grown by `slack`, meet.

    `first`, `second` (t, 3) vertex ids into `xyz` (v, 3); without `second` pairs (i < j) within `first`.
    Boxes stand along the main walls, not along the axes of the world, so that they are thin.
    """
    turned = xyz @ _along_walls(xyz, first).T
    low, high = _boxes(turned, first, slack)
    low2, high2 = (low, high) if second is None else _boxes(turned, second, slack)
    if not len(low) or not len(low2):
        return np.zeros((0, 2), np.int64)
    spread = np.sort(np.argsort(high.max(0) - low.min(0))[1:])
    x, y = (int(k) for k in spread)
    z = 3 - x - y
    tree = shapely.STRtree(shapely.box(low2[:, x], low2[:, y], high2[:, x], high2[:, y]))
    i, j = tree.query(shapely.box(low[:, x], low[:, y], high[:, x], high[:, y]))
    meet = (low[i, z] <= high2[j, z]) & (low2[j, z] <= high[i, z])
    if second is None:
        meet &= i < j
    pairs = np.stack([i[meet], j[meet]], axis=1)
    return np.asarray(pairs[np.lexsort(pairs.T[::-1])])


def _boxes(xyz: Float, triangles: Int, slack: float) -> tuple[Float, Float]:
    corners = xyz[triangles]
    return corners.min(1) - slack / 2, corners.max(1) + slack / 2


def _along_walls(xyz: Float, triangles: Int) -> Float:
    """A rotation (3, 3) about the vertical after which most wall area is parallel to an axis."""
    a, b, c = (xyz[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    angle, weight = np.arctan2(normal[:, 1], normal[:, 0]), np.hypot(normal[:, 0], normal[:, 1])
    turn = np.arctan2(weight @ np.sin(4 * angle), weight @ np.cos(4 * angle)) / 4
    s, c2 = np.sin(turn), np.cos(turn)
    return np.array([[c2, s, 0.0], [-s, c2, 0.0], [0.0, 0.0, 1.0]])


def meeting(grid: Int, first: Int, second: Int) -> Bool:
    """Whether triangles (n, 3) and (n, 3), vertex ids into `grid`, share a point beyond common vertices."""
    common = first[:, :, None] == second[:, None, :]
    shared = common.sum((1, 2))
    hit: Bool = shared == 3
    for number, rule in ((2, _across_edge), (1, _around_vertex), (0, _apart)):
        chosen = np.nonzero(shared == number)[0]
        if number < 2:
            chosen = chosen[_planes_cut(grid, first[chosen], second[chosen])]
        if len(chosen):
            hit[chosen] = rule(
                grid,
                _turned(first[chosen], common[chosen].any(2)),
                _turned(second[chosen], common[chosen].any(1)),
            )
    return hit


def _turned(triangles: Int, common: Bool) -> Int:
    """The triangles with their common vertices first (one), or last (two: the other one first)."""
    lone = np.where(common.sum(1) == 2, np.argmin(common, 1), np.argmax(common, 1))
    return np.asarray(np.take_along_axis(triangles, (lone[:, None] + np.arange(3)) % 3, axis=1))


def _planes_cut(grid: Int, first: Int, second: Int) -> Bool:
    """False where one triangle, but for common vertices, lies strictly on one side of the other's plane."""
    cut = np.ones(len(first), np.bool_)
    for one, other in ((first, second), (second, first)):
        left = np.nonzero(cut)[0]
        o, t = one[left], other[left]
        sides = np.stack([orient3d(grid, o[:, 0], o[:, 1], o[:, 2], t[:, k]) for k in range(3)], axis=1)
        own = (t[:, :, None] == o[:, None, :]).any(2)
        above, below = ((sides > 0) | own).all(1), ((sides < 0) | own).all(1)
        cut[left[above | below]] = False
    return cut


def _across_edge(grid: Int, first: Int, second: Int) -> Bool:
    """Common edge: they meet elsewhere only when folded onto each other."""
    a, u, v, b = first[:, 0], first[:, 1], first[:, 2], second[:, 0]
    flat = orient3d(grid, u, v, a, b) == 0
    axis = drop_axis(grid, a, u, v)
    pu, pv, pa, pb = (without_axis(grid[k], axis) for k in (u, v, a, b))
    same = orient2d(pu, pv, pa) == orient2d(pu, pv, pb)
    return np.asarray(flat & same)


def _around_vertex(grid: Int, first: Int, second: Int) -> Bool:
    """Common vertex: they meet elsewhere only if the edge opposite to it in one meets the other."""
    hit = _segment_meets(grid, first[:, 1], first[:, 2], second)
    rest = np.nonzero(~hit)[0]
    hit[rest] = _segment_meets(grid, second[rest, 1], second[rest, 2], first[rest])
    return hit


def _apart(grid: Int, first: Int, second: Int) -> Bool:
    """Nothing in common: they meet only if an edge of one meets the other."""
    hit = np.zeros(len(first), np.bool_)
    for one, other in ((first, second), (second, first)):
        for k in range(3):
            rest = np.nonzero(~hit)[0]
            o = one[rest]
            hit[rest] = _segment_meets(grid, o[:, k], o[:, (k + 1) % 3], other[rest])
    return hit


def _segment_meets(grid: Int, p: Int, q: Int, triangle: Int) -> Bool:
    """Whether closed segments p-q and closed triangles share a point (n,)."""
    a, b, c = triangle.T
    side_p, side_q = orient3d(grid, a, b, c, p), orient3d(grid, a, b, c, q)
    hit = np.zeros(len(p), np.bool_)
    flat = (side_p == 0) & (side_q == 0)
    through = np.nonzero((side_p * side_q <= 0) & ~flat)[0]
    if len(through):
        turns = [
            orient3d(grid, p[through], q[through], s[through], t[through])
            for s, t in ((a, b), (b, c), (c, a))
        ]
        hit[through] = _one_sign(turns)
    flat_ones = np.nonzero(flat)[0]
    if len(flat_ones):
        hit[flat_ones] = _flat_meets(grid, p[flat_ones], q[flat_ones], triangle[flat_ones])
    return hit


def _one_sign(turns: list[Sign]) -> Bool:
    """None positive beside a negative one."""
    all_turns = np.stack(turns)
    return np.asarray((all_turns >= 0).all(0) | (all_turns <= 0).all(0))


def _flat_meets(grid: Int, p: Int, q: Int, triangle: Int) -> Bool:
    """The same in one plane."""
    axis = drop_axis(grid, *triangle.T)
    pp, qq = without_axis(grid[p], axis), without_axis(grid[q], axis)
    corners = [without_axis(grid[triangle[:, k]], axis) for k in range(3)]
    edges = [(corners[k], corners[(k + 1) % 3]) for k in range(3)]
    hit = _one_sign([orient2d(s, t, pp) for s, t in edges]) | _one_sign(
        [orient2d(s, t, qq) for s, t in edges]
    )
    for s, t in edges:
        hit |= _segments_cross(pp, qq, s, t)
    return hit


def _segments_cross(p: Int, q: Int, s: Int, t: Int) -> Bool:
    """Whether closed segments of the plane meet; those on one line are left to the point tests."""
    over = orient2d(p, q, s) * orient2d(p, q, t) <= 0
    across = orient2d(s, t, p) * orient2d(s, t, q) <= 0
    line = (orient2d(p, q, s) == 0) & (orient2d(p, q, t) == 0)
    return np.asarray(over & across & ~line)
