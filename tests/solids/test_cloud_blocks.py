"""Blocks made from the cloud: eaves, footprints, and random arrangements of facades, all of them valid."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from facade_fakes import WORLD, facade
from frontage.geometry.ring import rectangle
from frontage.model import Estimate, Facade
from frontage.solids.brep import GRID_PER_M, volume6
from frontage.solids.coarse.cloud_blocks import cloud_blocks
from frontage.solids.coarse.eaves import clean_outline
from frontage.solids.coarse.footprints import footprints
from frontage.solids.coarse.plan_facade import PlanFacade
from frontage.validation import validate

DEPTH = 8.0


def front(a: Sequence[float], b: Sequence[float], low: float = 0.0, high: float = 9.0) -> PlanFacade:
    """Returns a facade between two points in plan, with the building on its left."""
    ends = np.array([a, b], np.float64)
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    return PlanFacade(ends, np.array([-along[1], along[0]]), low, high)


def chain(
    points: Sequence[Sequence[float]], without: Sequence[int] = (), closed: bool = False
) -> list[PlanFacade]:
    """Returns facades along a line of points, some of them missing."""
    pairs = list(zip(points, [*points[1:], points[0]], strict=True))
    return [front(a, b) for k, (a, b) in enumerate(pairs if closed else pairs[:-1]) if k not in without]


def ngon(n: int, side: float = 4.0) -> list[list[float]]:
    radius = side / 2 / np.sin(np.pi / n)
    turn = np.arange(n) * 2 * np.pi / n
    return (radius * np.column_stack([np.cos(turn), np.sin(turn)])).tolist()


def plan(fronts: list[PlanFacade]) -> Polygon:
    ((polygon, _),) = footprints(fronts, DEPTH)
    return polygon


def profile(
    points: Sequence[tuple[float, float]], bumps: Sequence[tuple[float, float, float]] = ()
) -> Facade:
    """Returns a facade with an upper outline (x, z) from left to right, and bumps (x from, to, height)."""
    x = np.arange(points[0][0], points[-1][0] + 0.01, 0.05)
    z = np.interp(x, *np.transpose(points))
    for low, high, by in bumps:
        z = np.where((x >= low) & (x <= high), z + by, z)
    ring = np.concatenate([[[x[0], 0], [x[-1], 0]], np.column_stack([x, z])[::-1]])
    return replace(facade(), outline=ring)


def top(made: np.ndarray) -> np.ndarray:
    return made[2:][::-1]


def test_chimneys_tanks_and_notches_leave_level_eaves():
    rough = profile([(0, 12), (30, 12)], [(3, 4, 2.5), (10, 12, 2), (20, 20.6, 5), (25, 26.5, -1.5)])
    assert top(clean_outline(rough, np.nan)) == pytest.approx(np.array([[0, 12], [30, 12]]), abs=0.02)


def test_two_houses_of_different_heights_have_a_step_between_them():
    eaves = top(clean_outline(profile([(0, 9), (8.99, 9), (9, 12), (20, 12)]), np.nan))
    assert eaves == pytest.approx(np.array([[0, 9], [9, 9], [9, 12], [20, 12]]), abs=0.06)


@pytest.mark.parametrize("apex", [3.0, 5.0, 6.5])
def test_a_gable_keeps_its_verges(apex):
    eaves = top(clean_outline(profile([(0, 6), (apex, 6 + 0.8 * 4), (10, 6)]), np.nan))
    assert eaves == pytest.approx(np.array([[0, 6], [apex, 9.2], [10, 6]]), abs=0.15)


def test_a_tapering_tower_is_level():
    eaves = top(clean_outline(profile([(0, 2), (0.4, 20), (3.6, 20), (4, 3)]), np.nan))
    assert eaves == pytest.approx(np.array([[0, 20], [4, 20]]), abs=0.05)


@pytest.mark.parametrize("n", [4, 5, 6, 8, 12])
def test_facades_on_all_sides_give_their_ring(n):
    whole = ngon(n)
    assert plan(chain(whole, closed=True)).symmetric_difference(Polygon(whole)).area < 1e-2


@pytest.mark.parametrize(("n", "without"), [(6, (1,)), (6, (1, 3)), (6, (0, 2, 4)), (8, (2, 5)), (8, (2, 6))])
def test_missing_faces_of_a_tower_are_closed_by_chords(n, without):
    whole = ngon(n)
    assert plan(chain(whole, without, closed=True)).symmetric_difference(Polygon(whole)).area < 1e-2


def test_a_ring_with_inner_corners_and_a_step():
    ring = [[0, 0], [20, 0], [20, 12], [12, 12], [12, 6], [9, 6], [9, 5], [0, 5]]
    assert plan(chain(ring, closed=True)).symmetric_difference(Polygon(ring)).area < 1e-2


def test_ends_that_stop_short_or_overshoot_go_to_the_corner():
    short = [
        front((0.8, 0), (9.1, 0)),
        front((10, 0.9), (10, 8.8)),
        front((10.5, 9), (1, 9)),
        front((0, 9.6), (0, 1)),
    ]
    assert plan(short).symmetric_difference(shapely.box(0, 0, 10, 9)).area < 1e-2


def test_facades_of_a_corner_house():
    assert plan(chain([[0, 0], [20, 0], [20, 12]])).area == pytest.approx(20 * 8 + 8 * 4)
    short = plan(chain([[0, 0], [20, 0], [20, 2]]))
    assert short.symmetric_difference(shapely.box(0, 0, 20, 8)).area < 1e-2


def test_a_splayed_side_leaves_no_notch():
    turn = np.radians(40)
    body = plan(chain([[0, 0], [9, 0], [9 + 4 * np.cos(turn), 4 * np.sin(turn)]]))
    assert body.convex_hull.area == pytest.approx(body.area)
    assert body.bounds[3] == pytest.approx(8.0)


def test_three_sides_give_the_depth_of_the_longer_one():
    body = plan(chain([[0, 11], [0, 0], [7, 0], [7, 3]]))
    assert body.symmetric_difference(shapely.box(0, 0, 7, 11)).area < 1e-2


def test_an_acute_corner_ends_at_both_planes():
    turn = np.radians(130)
    tip = [15 + 12 * np.cos(turn), 12 * np.sin(turn)]
    body = plan(chain([[0, 0], [15, 0], tip]))
    assert body.difference(front((15, 0), tip).strip(-99, 99, 99)).area < 1e-6


def test_the_corner_of_a_courtyard_is_filled_to_its_mitre():
    body = plan(chain([[0, 0], [10, 0], [10, -10]]))
    assert body.area == pytest.approx(10 * 8 * 2 + 8 * 8)


def test_a_step_between_parallel_facades():
    body = plan([front((0, 0), (10, 0)), front((10.4, 2), (18, 2))])
    assert body.area == pytest.approx((10.2 + 7.8) * 8, abs=0.1)
    assert body.geom_type == "Polygon" and len(body.exterior.coords) == 9


def test_a_wing_leaves_the_wall_of_an_avant_corps_whole():
    wing = chain([[0, 4], [0, 0], [5, 0], [5, 1.6], [10, 1.6]])
    body = shapely.union_all([p for p, _ in footprints([*wing, front((10, 1.2), (16, 1.2))], DEPTH)])
    assert body.covers(shapely.box(10.1, 1.21, 15.9, 5.0))  # though it stands in the space before the cheek
    assert body.bounds[0] == pytest.approx(0.0, abs=0.01)  # and nothing lies before the side of the wing


def test_a_wall_of_a_room_does_not_cut_off_the_end_of_a_front():
    assert plan([front((0, 0), (12, 0)), front((10.2, 0.1), (10.2, 5), 0, 3)]).covers(
        shapely.box(0.01, 0.01, 11.99, 7.9)
    )


def test_a_storey_that_is_set_back_is_a_block_of_its_own():
    found = footprints([front((0, 0), (20, 0), 0, 8), front((4, 3), (16, 3), 8, 14)], DEPTH)
    assert [p.area for p, _ in found] == [pytest.approx(160), pytest.approx(96)]


@pytest.mark.parametrize("gable", [0, 1])
def test_a_gable_roofs_the_whole_house(gable):
    """For two or four sides of a house, with the gable in front or at the side."""
    peak = np.array([[-5, 0], [5, 0], [5, 6], [0, 9], [-5, 6]], float)
    for sides in (
        chain([[0, 0], [10, 0], [10, 10]]),
        chain([[0, 0], [10, 0], [10, 10], [0, 10]], closed=True),
    ):
        outlines = [peak if k % 2 == gable else rectangle(-5, 0, 5, 6) for k in range(len(sides))]
        walls = [upright(one, k, o, 0.0) for k, (one, o) in enumerate(zip(sides, outlines, strict=True))]
        (host,) = cloud_blocks("B01", walls, 0.0, 10.0, WORLD)
        assert not validate(host.solid)
        assert volume6(host.solid) / 6e12 == pytest.approx(10 * 10 * 7.5, rel=0.01)
        assert "under the eaves of the highest one" in host.notes[0]


def test_a_step_runs_back_over_the_plan_and_a_high_side_makes_it_level():
    step = np.array([[-8, 0], [8, 0], [8, 9], [0, 9], [0, 6], [-8, 6]], float)
    sides = chain([[0, 0], [16, 0], [16, 12], [0, 12]], closed=True)
    for left, area in ((6.0, 16 * 6 + 8 * 3), (8.0, 16 * 9)):
        tops = [step, rectangle(-6, 0, 6, 9), rectangle(-8, 0, 8, 6), rectangle(-6, 0, 6, left)]
        walls = [upright(one, k, o, 0.0) for k, (one, o) in enumerate(zip(sides, tops, strict=True))]
        (host,) = cloud_blocks("B01", walls, 0.0, DEPTH, WORLD)
        assert not validate(host.solid)
        assert volume6(host.solid) / 6e12 == pytest.approx(area * 12, rel=0.02)


def upright(one: PlanFacade, number: int, outline: np.ndarray, lean: float) -> Facade:
    """Returns a facade through a facade in plan at height 0, leaning by an angle (rad)."""
    f = facade(azimuth=float(np.arctan2(one.inward[1], one.inward[0])), lean=lean)
    pose = replace(f.frame, t=np.array([*one.ends.mean(0), 0.0]))
    known = Estimate(pose, np.eye(6) * 1e-8, 500.0)
    return replace(f, id=f"B01/F{number}", local_from_facade=known, outline=outline)


KINDS = ["tower", "ring", "line", "rows", "any"]


def arrangement(seed: int, kind: str) -> list[Facade]:
    """Returns towers with missing faces, L and U shapes, steps, acute corners, rows, or random facades.

    Their ends are moved as measured ones are.
    """
    rng = np.random.default_rng(seed)
    if kind == "tower":
        n = int(rng.integers(3, 13))
        fronts = chain(ngon(n, rng.uniform(1.5, 12)), np.flatnonzero(rng.random(n) < 0.3), closed=True)
    elif kind == "ring":
        w, d, a, b = rng.uniform(8, 30), rng.uniform(8, 30), *rng.uniform(0.05, 0.95, 2)
        points = [[0, 0], [w, 0], [w, d * b], [w * a, d * b], [w * a, d], [0, d]]
        fronts = chain(points, np.flatnonzero(rng.random(6) < 0.3), closed=True)
    elif kind == "line":
        turns = rng.choice(
            [rng.uniform(-2.6, 2.6), np.pi / 2, -np.pi / 2, 0.5, 0.05], int(rng.integers(1, 5))
        )
        heading = np.cumsum([0, *turns])
        steps = rng.uniform(1, 20, len(heading))[:, None] * np.column_stack(
            [np.cos(heading), np.sin(heading)]
        )
        fronts = chain(np.concatenate([[[0, 0]], np.cumsum(steps, axis=0)]).tolist())
    elif kind == "rows":
        x = np.cumsum(rng.uniform(2, 12, 4))
        y = rng.choice([0, 0.03, 0.5, 3.0, 9.0], 3) * rng.choice([-1, 1], 3)
        fronts = [front((x[k], y[k]), (x[k + 1] - rng.choice([0, 0.3, 2.0]), y[k])) for k in range(3)]
    else:
        ends = rng.uniform(-15, 15, (int(rng.integers(1, 6)), 2, 2))
        fronts = [front(a, b) for a, b in ends if np.linalg.norm(a - b) > 1]
    made = []
    for k, one in enumerate(fronts or [front((0, 0), (5, 0))]):
        left, right = np.array([-1, 1]) * one.length / 2 + rng.choice([0, 0, 0.3, -0.3, 1.0], 2)
        right = max(right, left + 0.5)
        low, high = rng.choice([0.0, 0.0, 5.0]), rng.uniform(6, 20)
        outline = rectangle(left, low, right, high)
        if rng.random() < 0.4:  # a gable, or a step
            x, rise = rng.uniform(0.3, 0.7) * (right - left) + left, rng.uniform(0.2, 0.6) * (right - left)
            tops = (
                [[x, high + rise]]
                if rng.random() < 0.6
                else [[x, high], [x, high + rise], [left, high + rise]]
            )
            outline = np.array(
                [[left, low], [right, low], [right, high], *tops, [left, high]][: 4 + len(tops)]
            )
            outline = np.concatenate([outline, [[left, high]]]) if len(tops) == 1 else outline
        made.append(upright(one, k, outline, rng.choice([0.0, 0.01, -0.01])))
    return made


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(0, 2**32 - 1), st.sampled_from(KINDS))
def test_random_arrangements_give_valid_blocks(seed, kind):
    facades = arrangement(seed, kind)
    made = cloud_blocks("B01", facades, 0.0, DEPTH, WORLD)
    assert isinstance(made, tuple)
    for host in made:
        assert not validate(host.solid)
        assert host.notes[0].startswith("B01: no city model; a block ")
    rings = [f.frame.apply(np.insert(f.outline, 1, 0.0, axis=1)) for f in facades]
    high = max(r[:, 2].max() for r in rings)
    assert max(h.solid.vertices[:, 2].max() for h in made) / GRID_PER_M <= high + 0.01
    assert sum(volume6(h.solid) for h in made) > 0
