"""Exact test of which triangles intersect where they should not.

Triangles are closed, so touching counts. A vertex or an edge that two triangles share by its number does not
count; anything beyond it does.
"""

import numpy as np

from frontage.geometry.arrays import Bool, Int
from frontage.validation.geometry.predicates import Sign, drop_axis, orient2d, orient3d, without_axis


def triangles_meet(grid: Int, first: Int, second: Int) -> Bool:
    """Returns which pairs (n,) of triangles share a point beyond their common vertices and edges.

    `first` and `second` (n, 3) are vertex ids into `grid` (v, 3), integer coordinates.
    """
    common = first[:, :, None] == second[:, None, :]
    shared = common.sum((1, 2))
    hit: Bool = shared == 3
    for number, rule in ((2, _meet_beyond_edge), (1, _meet_beyond_vertex), (0, _meet_unconnected)):
        chosen = np.nonzero(shared == number)[0]
        if number < 2:
            chosen = chosen[_planes_cut(grid, first[chosen], second[chosen])]
        if len(chosen):
            hit[chosen] = rule(
                grid,
                _common_first(first[chosen], common[chosen].any(2)),
                _common_first(second[chosen], common[chosen].any(1)),
            )
    return hit


def _common_first(triangles: Int, common: Bool) -> Int:
    """Rotates triangles: the one common vertex comes first, or, if two are common, the third one."""
    lone = np.where(common.sum(1) == 2, np.argmin(common, 1), np.argmax(common, 1))
    return np.asarray(np.take_along_axis(triangles, (lone[:, None] + np.arange(3)) % 3, axis=1))


def _planes_cut(grid: Int, first: Int, second: Int) -> Bool:
    """Returns False where the other vertices of one triangle lie on one side of the other's plane."""
    cut = np.ones(len(first), np.bool_)
    for one, other in ((first, second), (second, first)):
        left = np.nonzero(cut)[0]
        o, t = one[left], other[left]
        sides = np.stack([orient3d(grid, o[:, 0], o[:, 1], o[:, 2], t[:, k]) for k in range(3)], axis=1)
        own = (t[:, :, None] == o[:, None, :]).any(2)
        above, below = ((sides > 0) | own).all(1), ((sides < 0) | own).all(1)
        cut[left[above | below]] = False
    return cut


def _meet_beyond_edge(grid: Int, first: Int, second: Int) -> Bool:
    """Triangles with a common edge meet elsewhere only if they are folded onto each other."""
    a, u, v, b = first[:, 0], first[:, 1], first[:, 2], second[:, 0]
    flat = orient3d(grid, u, v, a, b) == 0
    axis = drop_axis(grid, a, u, v)
    pu, pv, pa, pb = (without_axis(grid[k], axis) for k in (u, v, a, b))
    same = orient2d(pu, pv, pa) == orient2d(pu, pv, pb)
    return np.asarray(flat & same)


def _meet_beyond_vertex(grid: Int, first: Int, second: Int) -> Bool:
    """Triangles with a common vertex meet elsewhere only if an edge opposite to it meets the other one."""
    hit = _segment_meets(grid, first[:, 1], first[:, 2], second)
    rest = np.nonzero(~hit)[0]
    hit[rest] = _segment_meets(grid, second[rest, 1], second[rest, 2], first[rest])
    return hit


def _meet_unconnected(grid: Int, first: Int, second: Int) -> Bool:
    """Triangles with nothing in common meet only if an edge of one meets the other."""
    hit = np.zeros(len(first), np.bool_)
    for one, other in ((first, second), (second, first)):
        for k in range(3):
            rest = np.nonzero(~hit)[0]
            o = one[rest]
            hit[rest] = _segment_meets(grid, o[:, k], o[:, (k + 1) % 3], other[rest])
    return hit


def _segment_meets(grid: Int, p: Int, q: Int, triangle: Int) -> Bool:
    """Returns which closed segments from p to q share a point with their closed triangles (n,)."""
    a, b, c = triangle.T
    side_p, side_q = orient3d(grid, a, b, c, p), orient3d(grid, a, b, c, q)
    hit = np.zeros(len(p), np.bool_)
    coplanar = (side_p == 0) & (side_q == 0)
    through = np.nonzero((side_p * side_q <= 0) & ~coplanar)[0]
    if len(through):
        turns = [
            orient3d(grid, p[through], q[through], s[through], t[through])
            for s, t in ((a, b), (b, c), (c, a))
        ]
        hit[through] = _one_sign(turns)
    in_plane = np.nonzero(coplanar)[0]
    if len(in_plane):
        hit[in_plane] = _coplanar_segment_meets(grid, p[in_plane], q[in_plane], triangle[in_plane])
    return hit


def _one_sign(turns: list[Sign]) -> Bool:
    """Returns where no sign is positive while another one is negative."""
    all_turns = np.stack(turns)
    return np.asarray((all_turns >= 0).all(0) | (all_turns <= 0).all(0))


def _coplanar_segment_meets(grid: Int, p: Int, q: Int, triangle: Int) -> Bool:
    """Does the same as `_segment_meets` for segments in the plane of their triangles."""
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
    """Returns which closed segments of the plane cross; collinear ones are left to tests of their ends."""
    over = orient2d(p, q, s) * orient2d(p, q, t) <= 0
    across = orient2d(s, t, p) * orient2d(s, t, q) <= 0
    line = (orient2d(p, q, s) == 0) & (orient2d(p, q, t) == 0)
    return np.asarray(over & across & ~line)
