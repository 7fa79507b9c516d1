"""Borders of one window: unbiased however beams slant, with sills, surrounds and shutters before the wall."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.openings.borders.depth import find_depth, find_wall
from frontage.openings.borders.edges import EdgeTraits, SolidSide, footprint
from frontage.openings.borders.locate import find_borders
from frontage.openings.borders.measure import facade_edge_traits, measure
from frontage.openings.wall.crossings import CrossingBeams

WINDOW = (1.0, 6.0, 2.2, 7.6)
BELOW_LEFT = (-3.0, -8.0, 1.7)
BELOW_RIGHT = (7.0, -9.0, 1.7)
AHEAD = (1.6, -8.0, 6.8)
NOISE = 0.003  # m, of ranges
FRAME = 0.15  # m behind the wall
SILL = (0.95, 5.92, 2.25, 6.0)


def sight(eyes, spacing, *, blocks=(), seed=0, returned=1.0, rays=True):
    """Lines of sight from `eyes` to a wall with a window; `blocks` (x0, z0, x1, z1, y) stand before it."""
    rng = np.random.default_rng(seed)
    x0, z0, x1, z1 = WINDOW
    places, slopes, depths, ranges = [], [], [], []
    for eye in np.array(eyes):
        x, z = np.meshgrid(np.arange(0.2, 3.0, spacing), np.arange(5.2, 8.4, spacing))
        p = np.column_stack([x.ravel(), z.ravel()]) + rng.uniform(-spacing / 2, spacing / 2, (x.size, 2))
        s = (p - eye[[0, 2]]) / -eye[1]
        inside = (p[:, 0] > x0) & (p[:, 0] < x1) & (p[:, 1] > z0) & (p[:, 1] < z1)
        way = np.where(s > 0, [x1, z1], [x0, z0]) - p
        with np.errstate(divide="ignore"):
            reveal = np.where(np.abs(s) > 1e-9, way / s, np.inf).min(1)
        depth = np.where(inside, np.minimum(reveal, FRAME), 0.0)
        lost = inside & (depth == FRAME) & (rng.random(len(p)) > returned)
        for bx0, bz0, bx1, bz1, y in sorted(blocks, key=lambda b: -b[4]):
            q = p + s * y
            hit = (q[:, 0] > bx0) & (q[:, 0] < bx1) & (q[:, 1] > bz0) & (q[:, 1] < bz1)
            depth, lost = np.where(hit, y, depth), lost & ~hit
        places.append(p[~lost])
        slopes.append(s[~lost])
        depths.append((depth + rng.normal(0, NOISE, len(depth)))[~lost])
        ranges.append(np.hypot(1.0, np.hypot(*s[~lost].T)) * -eye[1] * rays)
    place, slope, depth = np.vstack(places), np.vstack(slopes), np.concatenate(depths)
    if not rays:
        place, slope = place + slope * depth[:, None], np.zeros_like(slope)
    order = np.argsort(place[:, 0], kind="stable")
    return CrossingBeams(
        place[order].T,
        slope[order].T,
        np.zeros(len(order)),
        depth[order],
        np.concatenate(ranges)[order],
        0.015,
    )


def surround(width=0.12, y=-0.04):
    x0, z0, x1, z1 = WINDOW
    a, b, c, d = x0 - width, z0 - width, x1 + width, z1 + width
    return [(a, b, x0, d, y), (x1, b, c, d, y), (x0, b, x1, z0, y), (x0, z1, x1, d, y)]


def errors_of(spacing, eyes, blocks=(), seeds=5, **kwargs):
    """Errors (n, 4) m of left, bottom, right, top, and as multiples of their sigmas."""
    rough = tuple(np.add(WINDOW, (-0.03, 0.02, 0.03, -0.02)))
    error, ratio = [], []
    for seed in range(seeds):
        (found,) = measure(
            sight(eyes, spacing, blocks=blocks, seed=seed, **kwargs), [rough], spacing, spacing
        )
        sigma = np.sqrt(np.diag(found.covariance))[[0, 2, 1, 3]]
        error.append(np.subtract(found.place, WINDOW))
        ratio.append(error[-1] / sigma)
    return np.array(error), np.array(ratio)


@pytest.mark.parametrize("eyes", [(BELOW_LEFT,), (BELOW_LEFT, BELOW_RIGHT), (AHEAD,)])
@pytest.mark.parametrize("blocks", [[], [(*SILL, -0.08)], surround()], ids=["plain", "sill", "surround"])
def test_borders_are_unbiased_and_their_sigmas_honest(eyes, blocks):
    error, ratio = errors_of(0.02, eyes, blocks)
    assert np.abs(error.mean(0)).max() < 0.002
    assert np.sqrt(np.mean(ratio**2)) < 1.3
    assert np.median(np.abs(error / ratio)) < 0.003  # the sigma itself


@pytest.mark.parametrize(("spacing", "limit"), [(0.01, 0.001), (0.04, 0.003)])
def test_no_bias_at_other_spacings(spacing, limit):
    error, ratio = errors_of(spacing, (BELOW_LEFT,), [(*SILL, -0.08)])
    assert np.abs(error.mean(0)).max() < limit
    assert np.sqrt(np.mean(ratio**2)) < 1.4


def test_open_shutters_off_the_edge_leave_it_uncertain():
    left, right = (0.35, 6.0, 0.97, 7.6, -0.06), (2.23, 6.0, 2.85, 7.6, -0.06)
    error, ratio = errors_of(0.02, (BELOW_LEFT, BELOW_RIGHT), [left, right])
    assert np.abs(error[:, [0, 2]]).max() < 0.02
    assert np.abs(ratio).max() < 4.0


def test_panes_that_return_nothing():
    error, _ = errors_of(0.02, (BELOW_LEFT,), returned=0.0)
    assert np.abs(error.mean(0)).max() < 0.008


def test_without_rays_the_wall_tells():
    error, _ = errors_of(0.01, (BELOW_LEFT,), rays=False)
    assert np.abs(error.mean(0)).max() < 0.005  # half the spacing: what lies behind the edge is in its shadow


def test_a_hidden_border_is_not_told():
    """A parapet before the lower part: the bottom may lie anywhere behind it."""
    parapet = (-0.5, 4.0, 4.0, 6.6, -0.9)
    low = (1.0, 6.8, 2.2, 7.6)
    view = sight((BELOW_LEFT,), 0.02, blocks=[parapet])
    _, borders = find_borders(view, low, cell=0.02, rise=0.0, frame=FRAME, spacing=0.02, traits=EdgeTraits())
    assert (
        borders[2].at == low[1]
        and 0.15 < borders[2].sigma < 0.6
        and max(b.sigma for b in (borders[0], borders[1], borders[3])) < 0.01
    )


def test_a_single_row_of_wall_leaves_a_border_the_gap_to_the_opening():
    """Rows 9 cm apart: the sill lies anywhere between the last one on the wall and the first one inside."""
    view = sight((AHEAD,), 0.01)
    rows = np.round((view.place[1] - 5.93) / 0.09) * 0.09 + 5.93  # at 5.93 and 6.02
    (found,) = measure(view.part(np.flatnonzero(np.abs(view.place[1] - rows) < 0.003)), [WINDOW], 0.02, 0.01)
    assert 5.93 < found.place[1] < 6.02
    assert abs(found.place[1] - WINDOW[1]) < 2.0 * np.sqrt(found.covariance[2, 2])
    assert 0.01 < np.sqrt(found.covariance[2, 2]) < 0.04  # 9 cm / sqrt(12) = 2.6 cm


def test_a_face_is_told_by_what_the_sensor_sees_beside_it_not_by_mixed_echoes():
    """A sill 8 cm before the wall, seen at 45 degrees: echoes of its edge trail far up behind it."""
    view = sight((BELOW_LEFT,), 0.02, blocks=[(*SILL, -0.08)])
    z = view.points[1]
    edge = np.flatnonzero((view.depth < -0.07) & (z > SILL[3] - 0.012))
    depth = view.depth.copy()
    depth[edge] += np.random.default_rng(0).uniform(0.0, 0.2, len(edge))
    mixed = CrossingBeams(view.place, view.slope, view.level, depth, view.range, view.wall)
    (found,) = measure(mixed, [WINDOW], 0.02, 0.02)
    assert found.borders[2].edge.face.y == pytest.approx(-0.08, abs=0.005)
    assert abs(found.place[1] - WINDOW[1]) < 0.008


@pytest.mark.parametrize("blocks", [[], surround()], ids=["plain", "surround"])
def test_depth_is_that_of_the_frame_behind_the_wall(blocks):
    found = [find_depth(sight((BELOW_LEFT,), 0.02, blocks=blocks, seed=k), WINDOW, 0.0) for k in range(6)]
    error = np.array([d.value for d in found]) - FRAME
    sigma = np.array([d.sigma[0] for d in found])
    assert abs(error.mean()) < 0.001
    assert np.abs(error / sigma).max() < 3.0


def test_masonry_of_a_whole_storey_that_stands_out_is_relief():
    view = sight((BELOW_LEFT,), 0.02, blocks=surround(width=3.0, y=-0.03))
    others = np.array([-0.03, -0.03, -0.03, 0.0, 0.0])
    alone, common = find_depth(view, WINDOW, 0.0), find_depth(view, WINDOW, 0.0, others=others)
    assert alone.value == pytest.approx(FRAME + 0.03, abs=0.003)
    assert common.value == pytest.approx(FRAME, abs=0.003)
    assert alone.sigma[0] < 0.005 < 0.013 < common.sigma[0] < 0.017  # two of five say so


def test_walls_of_one_level_are_pooled():
    wall, sigma = find_wall(sight((AHEAD,), 0.02), WINDOW, np.array([0.001, 0.002, 0.002, 0.001, 0.0, 0.3]))
    assert wall == 0.001
    assert sigma < 0.004


def test_relief_that_bends_the_mean_of_the_wall_is_no_opening():
    """A wall whose local mean lies 2 cm before it, drawn there by the relief around."""
    view = sight((BELOW_LEFT,), 0.02)
    bent = CrossingBeams(
        view.place - 0.02 * view.slope,
        view.slope,
        view.level - 0.02,
        view.depth + 0.02,
        view.range,
        view.wall,
    )
    (found,) = measure(bent, [WINDOW], 0.02, 0.02)
    assert np.abs(np.subtract(found.place, WINDOW)).max() < 0.004
    assert found.depth.value == pytest.approx(FRAME, abs=0.003)


def test_faces_that_few_points_tell_come_from_the_facade():
    view = sight((BELOW_LEFT,), 0.02, blocks=[(*SILL, -0.08)])
    outlines = measure(view, [WINDOW], 0.02, 0.02) * 3
    face = facade_edge_traits([_scored(o) for o in outlines]).faces[2]
    assert isinstance(face, SolidSide) and abs(face.y + 0.08) < 0.005


def test_footprints_grow_with_the_range_by_diffraction_at_least():
    view = sight((BELOW_LEFT,), 0.02)
    clean = facade_edge_traits([_scored(o) for o in measure(view, [WINDOW], 0.02, 0.02)])
    assert clean.widening == pytest.approx(1e-4)  # no mixed echoes
    assert footprint(np.array([0.0, 1.0, 25.0]), clean.widening) == pytest.approx(
        [0, 0.00125, 0.0028], rel=0.01
    )
    edge = np.flatnonzero(np.abs(view.place[1] - WINDOW[1]) < 0.009)
    depth = view.depth.copy()
    depth[edge] = np.random.default_rng(0).uniform(0.0, FRAME, len(edge))
    mixed = CrossingBeams(view.place, view.slope, view.level, depth, view.range, view.wall)
    assert facade_edge_traits([_scored(o) for o in measure(mixed, [WINDOW], 0.02, 0.02)]).widening > 1.4e-4


def _scored(outline):
    return type(outline)(**{**outline.__dict__, "borders": _with_scores(outline.borders)})


def _with_scores(borders):
    return tuple(type(b)(**{**b.__dict__, "scores": np.zeros(5)}) for b in borders)


def test_leaves_before_an_edge_are_not_its_face():
    """Twelve leaves at twelve depths hide half of the masonry beside an edge seen from one side only."""
    leaves = [(0.9, 6.25 + 0.1 * k, 1.0, 6.3 + 0.1 * k, -0.03 - 0.0075 * k) for k in range(12)]
    error, ratio = errors_of(0.04, (BELOW_LEFT,), leaves)
    assert np.abs(error[:, 0]).max() < 0.003
    assert np.abs(ratio[:, 0]).max() < 2.0


def test_a_reveal_in_sight_corrects_what_the_face_hides():
    """One scanner sees the reveal; what the face hides from the other is off by its depth, and follows."""
    rough = tuple(np.add(WINDOW, (-0.02, 0.0, 0.0, 0.0)))
    near = sight((BELOW_LEFT, BELOW_RIGHT), 0.02)
    hidden = near.slope[0] > 0.0
    found = []
    for off in (-0.006, 0.006):
        moved = replace(near, place=near.place + near.slope * np.where(hidden, off, 0.0))
        (one,) = measure(moved.part(np.argsort(moved.place[0], kind="stable")), [rough], 0.02, 0.02)
        found.append(one.place[0])
    assert np.ptp(found) < 0.0008
    assert np.abs(np.subtract(found, WINDOW[0])).max() < 0.0015
