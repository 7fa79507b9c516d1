"""Layouts of fronts: nothing overlaps, everything asked for occurs, measures stay within their bounds."""

from collections import Counter
from functools import lru_cache
from itertools import pairwise

import numpy as np
import pytest
import shapely

from frontage.geometry.arrays import Float
from frontage.geometry.ring import rectangle, ring_area
from frontage.simulate.houses.elevation import CLEARANCE_M
from frontage.simulate.houses.shapes import SHAPES, BarLayout, opening_ring, plan_bars
from frontage.simulate.meshing import inset
from frontage.simulate.scene import FacadePlan, House, OpeningPlan, Scene
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street

BARE = {"trees": 0, "cars": 0, "lamps": 0, "people": 0}


@lru_cache
def streets() -> tuple[Scene, ...]:
    return tuple(build_street(SceneSpec(seed=seed, houses=5, **BARE)) for seed in (2, 4, 5, 8))  # type: ignore[arg-type]


def houses() -> list[House]:
    return [h for scene in streets() for h in scene.houses]


def facades() -> list[FacadePlan]:
    return [f for h in houses() for f in h.facades]


def openings() -> list[OpeningPlan]:
    return [o for f in facades() for o in f.openings]


def wall_of(facade: FacadePlan, wall_y: float) -> shapely.Polygon:
    if wall_y == 0:
        return shapely.Polygon(facade.outline)
    (ring,) = (p.front for p in facade.protrusions if p.kind == "oriel" and p.y_range[0] == wall_y)
    return shapely.Polygon(ring)


def test_openings_lie_in_their_wall_and_apart() -> None:
    for facade in facades():
        shapes = [shapely.Polygon(o.ring) for o in facade.openings]
        for k, (opening, shape) in enumerate(zip(facade.openings, shapes, strict=True)):
            wall = wall_of(facade, opening.wall_y)
            assert wall.contains(shape) and wall.exterior.distance(shape) >= CLEARANCE_M - 1e-9, opening.id
            for other in shapes[:k]:
                assert shape.distance(other) >= CLEARANCE_M - 1e-9, opening.id


def test_no_opening_is_hidden_behind_an_oriel() -> None:
    seen = 0
    for facade in facades():
        for oriel in (p for p in facade.protrusions if p.kind == "oriel"):
            seen += 1
            hidden = [o for o in facade.openings if o.wall_y == 0]
            area = shapely.Polygon(oriel.ring)
            assert not any(area.intersects(shapely.Polygon(o.ring)) for o in hidden)
            assert any(o.wall_y == oriel.y_range[0] for o in facade.openings)
    assert seen >= 3


def test_identifiers_count_storeys_from_the_ground_and_bays_from_the_left() -> None:
    for facade in facades():
        ids = [o.id for o in facade.openings]
        assert len(set(ids)) == len(ids) and all(i.startswith(f"{facade.id}/") for i in ids)
        for floor in {o.floor for o in facade.openings}:
            row = [o for o in facade.openings if o.floor == floor]
            x = [float(o.ring[:, 0].min() + o.ring[:, 0].max()) for o in sorted(row, key=lambda o: o.bay)]
            assert [o.bay for o in sorted(row, key=lambda o: o.bay)] == list(range(1, len(row) + 1))
            assert x == sorted(x)


def test_measures_stay_within_realistic_bounds() -> None:
    for o in openings():
        assert 0.05 <= o.depth <= 0.4 + 1e-9
        assert o.depth < o.glass_depth < o.depth + 0.065
        assert ring_area(o.ring) > 0
        for axis in ("vertical", "horizontal"):
            assert sum(b.axis == axis for b in o.bars) <= 4
    depths = np.array([o.depth for o in openings()])
    assert depths.min() < 0.09 and depths.max() > 0.25 and len(np.unique(depths.round(3))) > 40


def test_everything_that_was_asked_for_occurs() -> None:
    all_ = openings()
    kinds, shapes = Counter(o.kind for o in all_), Counter(o.shape for o in all_)
    assert set(kinds) == {"window", "door", "shopfront", "passage", "garage", "basement"}
    assert {"rectangle", "segmental", "round", "pointed"} <= set(shapes)
    assert {o.shutters for o in all_} == {"none", "open", "closed"}
    fixed = {p.kind for f in facades() for p in f.protrusions}
    assert {"balcony", "oriel", "cornice", "string", "plinth", "pilaster", "dormer"} <= fixed
    assert any(h.twin_of for h in houses())
    counts = {
        (sum(b.axis == "vertical" for b in o.bars), sum(b.axis == "horizontal" for b in o.bars)) for o in all_
    }
    assert len(counts) >= 10
    half = [
        b for o in all_ for b in o.bars if b.axis == "vertical" and b.extent[1] < o.ring[:, 1].max() - 0.3
    ]
    assert half  # T layouts: uprights that end at the transom


def test_leans_and_slopes_are_those_of_real_streets() -> None:
    lean = [np.degrees(np.arcsin(f.local_from_facade.R[2, 1])) for h in houses() for f in h.facades[:1]]
    assert (
        np.abs(lean).max() <= 0.5 + 1e-9 and np.abs(lean).max() > 0.3 and np.mean(np.abs(lean) < 1e-9) > 0.2
    )
    for scene in streets():
        rise = np.diff(scene.road[[0, -1]], axis=0)[0]
        assert 0.01 - 1e-9 <= abs(rise[2]) / np.hypot(*rise[:2]) <= 0.08 + 1e-9


def test_twins_are_alike_but_for_their_place() -> None:
    for scene in streets():
        by_id = {h.id: h for h in scene.houses}
        for twin in (h for h in scene.houses if h.twin_of):
            first = by_id[str(twin.twin_of)]
            for a, b in zip(first.facades, twin.facades, strict=True):
                assert len(a.openings) == len(b.openings)
                assert all(
                    np.array_equal(p.ring, q.ring) for p, q in zip(a.openings, b.openings, strict=True)
                )
            assert (
                np.linalg.norm(first.facades[0].local_from_facade.t - twin.facades[0].local_from_facade.t) > 3
            )


def test_neighbours_in_a_terrace_meet_and_detached_houses_do_not() -> None:
    for setting in ("terrace", "detached"):
        scene = build_street(SceneSpec(seed=3, houses=4, setting=setting, **BARE))  # type: ignore[arg-type]
        back = scene.local_from_street.inverse
        near = [h for h in scene.houses if h.side == 0]
        spans = [back.apply(np.column_stack([h.footprint, np.zeros(4)]))[:, 0] for h in near]
        gaps = np.array([b.min() - a.max() for a, b in pairwise(spans)])
        assert (np.abs(gaps) < 1e-9).all() if setting == "terrace" else (gaps > 2).all()
        assert setting == "terrace" or max(len(h.facades) for h in near) > 1


def test_triangular_heads_are_drawn_where_asked_for_only() -> None:
    assert not {"triangular", "circle"} & {o.shape for o in openings()}
    rises = []
    for seed in range(4):
        asked = {"seed": seed, "houses": 1, "opposite": False, "house": [{"shape": "triangular"}]}
        (house,) = build_street(SceneSpec.model_validate(asked)).houses
        upper = [o for o in house.facades[0].openings if o.shape == "triangular"]
        share = {round((o.ring[3, 1] - o.ring[2, 1]) / np.ptp(o.ring[:, 0]), 9) for o in upper}
        assert {len(o.ring) for o in upper} == {5} and len(share) == 1
        rises += share
    assert len(set(rises)) == 4 and min(rises) > 0.1 and max(rises) < 0.81


@pytest.mark.parametrize("shape", SHAPES)
def test_rings_follow_their_arcs_to_a_millimetre(shape: str) -> None:
    width, height = 1.2, 1.2 if shape == "circle" else 2.0
    ring = opening_ring(shape, 3.0, 1.0, width, height, rise=0.2)
    fine = _fine(shape, width, height)
    np.testing.assert_allclose(ring.min(0), [3.0, 1.0], atol=0.001)
    np.testing.assert_allclose(ring.max(0), [3.0 + width, 1.0 + height], atol=0.001)
    distance = shapely.hausdorff_distance(
        shapely.Polygon(ring).exterior, shapely.Polygon(fine).exterior, 0.01
    )
    assert distance < 0.001
    assert ring_area(ring) == pytest.approx(ring_area(fine), rel=0.002)


def _fine(shape: str, width: float, height: float) -> Float:
    """The same opening by its definition: points that satisfy the equation of its upper edge."""
    half, x = width / 2, np.linspace(-width / 2, width / 2, 4001)
    if shape == "circle":
        upper, lower = half + np.sqrt(half**2 - x**2), half - np.sqrt(half**2 - x**2)
    else:
        radius = (half**2 + 0.2**2) / 0.4
        arch = {
            "rectangle": np.zeros_like(x),
            "segmental": np.sqrt(radius**2 - x**2) - (radius - 0.2),
            "round": np.sqrt(half**2 - x**2),
            "pointed": np.sqrt(np.maximum(width**2 - (np.abs(x) + half) ** 2, 0)),
            "triangular": 0.2 * (1 - np.abs(x) / half),
        }[shape]
        upper, lower = height - arch.max() + arch, np.zeros_like(x)
    edge = np.vstack([np.column_stack([x, lower]), np.column_stack([x, upper])[::-1]])
    return edge + np.array([3.0 + half, 1.0])


def test_bars_divide_the_light_and_end_at_the_frame() -> None:
    ring = rectangle(0, 0, 1.2, 1.8)
    bars = plan_bars(ring, 0.1, BarLayout("grid", 1, 2))
    assert [(b.axis, round(b.position, 9)) for b in bars] == [
        ("vertical", 0.6), ("horizontal", round(0.1 + 1.6 / 3, 9)), ("horizontal", round(0.1 + 3.2 / 3, 9)),
    ]  # fmt: skip
    np.testing.assert_allclose([b.extent for b in bars], [(0.1, 1.7), (0.1, 1.1), (0.1, 1.1)])
    upright, transom = plan_bars(ring, 0.1, BarLayout("T", 1, 1))
    assert upright.extent[1] == transom.position == pytest.approx(0.1 + 1.6 * 0.68)
    (side,) = plan_bars(ring, 0.1, BarLayout("asymmetric", 1, 0))
    assert side.position == pytest.approx(0.1 + 1.0 / 3)


def test_bars_under_an_arch_end_at_its_curve() -> None:
    ring = opening_ring("round", 0, 0, 1.0, 2.0)
    light = shapely.Polygon(inset(ring, 0.05)).exterior
    for bar in plan_bars(ring, 0.05, BarLayout("grid", 3, 3)):
        for end in bar.extent:
            point = (bar.position, end) if bar.axis == "vertical" else (end, bar.position)
            assert light.distance(shapely.Point(point)) < 1e-9
