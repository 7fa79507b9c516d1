"""Frames and bars of windows: closed solids in their openings, from random and from careless layouts."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

from facade_fakes import WORLD
from frontage.geometry.ring import rectangle
from frontage.model import FRAME_THICKNESS_M, Bar, Elements, Estimate, Glazing, Opening
from frontage.solids import BuildOptions, WindowFrame
from frontage.solids.brep import GRID_PER_M, newell_normal, unmatched_edges, volume6
from frontage.solids.curves import arch_ring, circle_ring
from frontage.solids.frames.area import frame_areas
from frontage.solids.frames.extrude import extruded
from frontage.solids.frames.plan import DEPTHS_M, HORIZONTAL, VERTICAL, WindowPlan
from frontage.validation import validate
from opening_fakes import opening
from solids.facades import frame
from solids.test_assemble import house, protrusion, wall, window

GAP = 200.0  # 0.1 mm
BOX = (-3.0, -1.0, -1.8, 0.6)  # m: 1.2 x 1.6


def measured(value: float) -> Estimate[float]:
    return Estimate(value, np.eye(1) * 1e-5, 10.0)


def glazed(*bars: Bar, width: float | None = 0.06, ring: np.ndarray | None = None, **about) -> Opening:
    own = window("B01/F1/W1-1", BOX)
    shape = own.ring if ring is None else ring
    glazing = Glazing(True, bars, None if width is None else measured(width), measured(0.12), 0.9, ("a",))
    return replace(
        own, ring=shape, ring_covariance=np.eye(2 * len(shape)) * 1e-5, glazing=replace(glazing, **about)
    )


def upright(x: float, low: float = BOX[1] + 0.06, high: float = BOX[3] - 0.06, width: float = 0.04) -> Bar:
    return Bar("vertical", x, (low, high), width, 0.003, 0.002)


def level(z: float, left: float = BOX[0] + 0.06, right: float = BOX[2] - 0.06, width: float = 0.04) -> Bar:
    return Bar("horizontal", z, (left, right), width, 0.003, 0.002)


def frames_of(one: Opening, turn: float = 0.7, **options) -> tuple[WindowFrame, ...]:
    return house(wall(turn=turn), Elements("B01/F1", (one,)), **options).frames


def area_of(one: WindowFrame) -> float:
    return volume6(one.solid) / 6 / GRID_PER_M**3 / FRAME_THICKNESS_M


def test_a_grid_is_one_solid_of_exact_volume() -> None:
    (one,) = frames_of(glazed(upright(-2.6), upright(-2.2), level(0.1)), turn=np.pi / 2)
    panes = (1.08 - 2 * 0.04) * (1.48 - 0.04)
    assert area_of(one) == pytest.approx(1.2 * 1.6 - panes, abs=1e-9)
    front, back, *sides = one.solid.faces
    assert len(front.holes) == len(back.holes) == 6 and len(sides) == 4 + 6 * 4
    assert unmatched_edges(one.solid.faces) == [] and validate(one.solid) == ()
    assert {f.semantics for f in one.solid.faces} == {""} and one.around


def test_it_stands_in_the_opening_as_deep_as_its_surface() -> None:
    (one,) = frames_of(glazed(upright(-2.4)))
    xyz = wall().frame.inverse.apply(one.solid.vertices / GRID_PER_M)
    assert sorted(set(np.round(xyz[:, 1], 3).tolist())) == [0.119, 0.184]
    assert (xyz[:, 0].min(), xyz[:, 0].max()) == pytest.approx((BOX[0], BOX[2]), abs=2e-4)
    bar = np.abs(xyz[:, 0] + 2.4) < 0.1
    assert sorted(set(np.round(xyz[bar, 0], 3).tolist())) == [-2.42, -2.38]
    out = newell_normal(one.solid.vertices[list(one.solid.faces[0].ring)].astype(float))
    assert out @ wall().frame.R[:, 1] == pytest.approx(-1, abs=1e-4)


def test_the_shell_does_not_change_and_the_switch_leaves_the_geometry_out() -> None:
    elements = Elements("B01/F1", (glazed(upright(-2.4)),))
    with_bars, without = (house(wall(), elements, bars=b) for b in (True, False))
    assert len(with_bars.frames) == 1 and without.frames == ()
    one, other = with_bars.built[0].solid, without.built[0].solid
    assert one.faces == other.faces and np.array_equal(one.vertices, other.vertices)
    assert house(wall(), elements, depth=False).frames == ()


def test_an_arched_head_keeps_the_width_of_its_frame() -> None:
    ring = arch_ring(-3.0, -1.8, -1.0, spring=0.2, rise=0.6, chord_error=0.004)
    (one,) = frames_of(glazed(upright(-2.4, high=0.74), level(0.2), ring=ring))
    front = one.solid.faces[0]
    flat = wall().frame.inverse.apply(one.solid.vertices / GRID_PER_M)[:, [0, 2]]
    outer = shapely.Polygon(flat[list(front.ring)])
    holes = [shapely.Polygon(flat[list(h)]) for h in front.holes]
    assert len(holes) == 4
    away = [shapely.Point(p).distance(outer.boundary) for h in holes for p in h.exterior.coords]
    assert min(away) == pytest.approx(0.06, abs=1e-3)
    left, right = (h for h in holes if h.bounds[1] > 0.2)
    assert left.area == pytest.approx(right.area, rel=2e-3), "both corners of the bar meet the arch"


def test_bars_end_at_bars_and_frames_that_they_almost_reach() -> None:
    (one,) = frames_of(glazed(level(0.1), upright(-2.4, low=-0.93, high=0.07)))
    assert len(one.solid.faces[0].holes) == 3, "a T: two panes below, one above"


def test_bars_without_a_measured_frame_stand_alone() -> None:
    (one,) = frames_of(glazed(upright(-2.4), level(0.1), width=None))
    assert not one.around and area_of(one) == pytest.approx((1.48 + 1.08) * 0.04 - 0.04**2, abs=3e-4)


def test_bars_that_do_not_hang_together_are_several_solids() -> None:
    found = frames_of(glazed(upright(-2.7), upright(-2.1), width=None))
    assert [f.id for f in found] == ["B01/F1/W1-1/frame", "B01/F1/W1-1/frame-2"]


def test_an_opening_of_which_nothing_is_known_has_no_frame() -> None:
    assert frames_of(replace(window("B01/F1/W1-1", BOX), glazing=None)) == ()
    assert frames_of(glazed(width=None)) == ()
    assert len(frames_of(glazed(resolved=False))) == 1, "the frame was measured, although its bars were not"


def test_the_depth_of_the_frame_replaces_one_that_the_scan_did_not_give() -> None:
    made = house(wall(), Elements("B01/F1", (replace(glazed(upright(-2.4)), depth=None),)))
    solid = made.built[0].solid
    (face,) = (f for f in solid.faces if f.opening)
    y = wall().frame.inverse.apply(solid.vertices[list(face.ring)] / GRID_PER_M)[:, 1]
    assert y == pytest.approx(0.12, abs=1e-3)


def test_frames_on_an_oriel_stand_in_its_front() -> None:
    bay = protrusion("oriel", (-4, -2, 0, 2), -0.8)
    (one,) = house(wall(), Elements("B01/F1", (glazed(upright(-2.4)),), (bay,))).frames
    y = wall().frame.inverse.apply(one.solid.vertices / GRID_PER_M)[:, 1]
    assert y.min() == pytest.approx(-0.8 + 0.12 - 0.001, abs=2e-4)


def test_careless_bars_are_clipped() -> None:
    bars = (
        upright(-2.4, low=-9, high=9),
        upright(-2.39, low=-9, high=9),  # overlaps the first
        upright(7.0),  # outside
        level(0.1, width=0.001),  # no bar
        level(0.2, left=5, right=-5),
    )
    (one,) = frames_of(glazed(*bars))
    assert validate(one.solid) == () and len(one.solid.faces[0].holes) == 4


def random_plan(rng: np.random.Generator, pose) -> WindowPlan:
    wide, high = rng.uniform(0.3, 2.5, 2)
    rings = [
        rectangle(0, 0, wide, high),
        arch_ring(0, wide, 0, spring=high * 0.6, rise=wide * rng.choice([0.1, 0.5, 0.8]), chord_error=0.003),
        circle_ring(wide / 2, wide / 2, wide / 2, 0.004),
        np.array([[0, 0], [wide, 0], [wide * rng.uniform(0.5, 1), high], [wide * 0.2, high * 0.8]]),
    ]
    bars = []
    for _ in range(int(rng.integers(0, 9))):
        axis = int(rng.integers(2))
        span, along = ((wide, high), (high, wide))[axis]
        position = rng.uniform(-0.1, 1.1) * span
        random = rng.random() < 0.5
        ends = np.sort(rng.uniform(-0.2, 1.2, 2) * along) if random else np.array([0.06, along - 0.06])
        bars.append((axis, position, *ends, rng.uniform(0.005, 0.12)))
        if rng.random() < 0.3:
            bars.append((axis, position + rng.normal() * 0.02, *ends, 0.03))
    table = np.array(bars).reshape(-1, 5) * ([1] + [GRID_PER_M] * 4)
    outline = shapely.Polygon(np.rint(rings[int(rng.choice(4, p=[0.4, 0.2, 0.2, 0.2]))] * GRID_PER_M))
    width = float(rng.choice([0.045, 0.05, 0.07, 0.2])) * GRID_PER_M
    return WindowPlan(pose, outline, width, table[:, 0].astype(int), table[:, 1], table[:, 2:4], table[:, 4])


@pytest.mark.parametrize(("turn", "lean"), [(np.pi / 2, 0.0), (0.83, 0.05), (2.1, -0.02)])
def test_random_layouts_are_valid_and_have_their_volume(turn: float, lean: float) -> None:
    rng, pose = np.random.default_rng(11), frame(turn, lean)
    plans = [random_plan(rng, pose) for _ in range(40)]
    found = frame_areas(plans, GAP)
    assert sum(complete for _, complete in found) >= 38
    for plan, (polygons, _) in zip(plans, found, strict=True):
        assert len(polygons) and shapely.union_all(polygons).difference(plan.outline).area == 0
        for polygon in polygons:
            solid = extruded("W", polygon, pose, DEPTHS_M, WORLD.origin)
            assert unmatched_edges(solid.faces) == [] and validate(solid) == ()
            volume = polygon.area / GRID_PER_M**2 * FRAME_THICKNESS_M
            error = 1e-4 * (polygon.length / GRID_PER_M * FRAME_THICKNESS_M + 2 * volume / FRAME_THICKNESS_M)
            exact = (turn, lean) == (np.pi / 2, 0.0)
            assert volume6(solid) / 6 / GRID_PER_M**3 == pytest.approx(volume, abs=1e-9 if exact else error)


def test_narrow_panes_are_filled_and_wider_ones_stay() -> None:
    outline, pose = shapely.box(0, 0, 10_000, 10_000), frame(0.3)
    ends = np.tile([500.0, 9500.0], (2, 1))
    for between, panes in ((190.0, 2), (220.0, 3)):
        position = np.array([5000.0, 5000 + 400 + between])
        plan = WindowPlan(pose, outline, 500.0, np.full(2, VERTICAL), position, ends, np.full(2, 400.0))
        ((polygons, _),) = frame_areas([plan], GAP)
        assert len(polygons[0].interiors) == panes


def test_a_window_that_its_frame_fills_has_no_pane() -> None:
    pose, outline = frame(0.3), shapely.box(0, 0, 10_000, 1100)
    plan = WindowPlan(pose, outline, 500.0, np.zeros(0, int), np.zeros(0), np.zeros((0, 2)), np.zeros(0))
    ((polygons, complete),) = frame_areas([plan], GAP)
    assert complete and polygons[0].equals(outline)


def test_two_bars_that_meet_in_a_point_are_joined() -> None:
    pose, outline = frame(0.3), shapely.box(0, 0, 10_000, 10_000)
    axis = np.array([VERTICAL, HORIZONTAL])
    ends = np.array([[500.0, 4700.0], [5200.0, 9500.0]])  # end to end at a corner, so that two panes touch
    plan = WindowPlan(pose, outline, 500.0, axis, np.array([5000.0, 4900]), ends, np.full(2, 400.0))
    ((polygons, complete),) = frame_areas([plan], 10.0)
    assert complete and len(polygons) == 1
    assert validate(extruded("W", polygons[0], pose, DEPTHS_M, WORLD.origin)) == ()


def test_the_default_draws_bars() -> None:
    assert BuildOptions().bars and opening().bars
    assert np.array_equal(WORLD.origin, frames_of(opening())[0].solid.origin)
