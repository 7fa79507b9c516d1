"""Blocks reach up to the measured fronts of storeys that jut out over their ground plans."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely.geometry import Polygon, box

from frontage.model import Surface
from frontage.solids.brep import volume6
from frontage.solids.coarse.extrude import ground_block
from frontage.solids.coarse.host import Host
from frontage.solids.coarse.overhangs import Storey, storeys_over
from frontage.solids.coarse.plan_facade import PlanFacade, lower_border
from frontage.solids.options import BuildOptions
from frontage.validation import validate
from solids.facades import WORLD

HOUSE = box(0.0, 0.0, 12.0, 9.0)
INWARD = np.array([0.0, 1.0])  # the street lies at negative y
HIGH = 12.0


def _front(y: float, left: float = 0.0, right: float = 12.0) -> PlanFacade:
    """Returns a facade along the street, y m behind the front of the house, without openings."""
    return PlanFacade(np.array([[left, y], [right, y]]), INWARD, 0.0, HIGH)


def _with_openings(facade: PlanFacade, foot: float = 0.0) -> PlanFacade:
    """Adds openings to a facade whose lower border is at a height (m)."""
    facade.held = (0.5, foot + 0.8, facade.length - 0.5, facade.high - 1.0)
    facade.foot = foot
    return facade


def _storeys(plan: Polygon, *facades: PlanFacade, **more) -> tuple[Storey, ...]:
    return storeys_over(plan, 0.0, facades, BuildOptions(), **more)


def _plan(plan: Polygon, *facades: PlanFacade) -> Polygon:
    """Returns the plan of a block of one storey."""
    (only,) = _storeys(plan, *facades)
    return only.plan


def _ground(plan: Polygon) -> Surface:
    ring = np.array(shapely.orient_polygons(plan).exterior.coords)[:-1]
    return Surface(np.insert(ring[::-1], 2, 0.0, axis=1), "GroundSurface")


def _block(plan: Polygon, *facades: PlanFacade) -> Host:
    """Returns the valid block of a plan and facades."""
    made = ground_block("B", [_ground(plan)], WORLD, HIGH, fronts=facades, options=BuildOptions())
    assert isinstance(made, Host), made
    assert not validate(made.solid)
    return made


@pytest.mark.parametrize("off", [-0.2, 0.0, 0.15])
@pytest.mark.parametrize("deep", [1.5, 3.0])
def test_a_deep_entrance_is_closed_along_the_wall_beside_it(off: float, deep: float) -> None:
    plan = HOUSE - box(7.0, 0.0, 10.0, deep)
    assert _plan(plan, _front(off)).symmetric_difference(HOUSE).area < 0.01


@pytest.mark.parametrize("deep", [0.08, 0.12])
def test_a_notch_of_a_few_centimetres_is_closed_so_that_no_opening_falls_into_two_walls(deep: float) -> None:
    plan = HOUSE - box(7.0, 0.0, 8.0, deep)
    assert _plan(plan, _front(0.05)).symmetric_difference(HOUSE).area < 0.01
    _block(plan, _front(0.05))


def test_the_wall_above_a_passage_is_built_with_the_yard_behind_it() -> None:
    passage = box(4.0, 0.0, 7.0, 8.0)
    found = _plan(HOUSE - passage, _front(0.1))
    assert found.covers(box(0.01, 0.01, 11.99, 3.9))
    assert found.area < HOUSE.area - 10.0  # the far end of the passage stays open


def test_a_front_turned_against_the_plan_keeps_the_line_of_the_plan() -> None:
    front = PlanFacade(np.array([[0.0, 0.0], [12.0, 0.1]]), INWARD)
    found = _plan(HOUSE - box(7.0, 0.0, 10.0, 2.0), front)
    assert found.symmetric_difference(HOUSE).area < 0.01


@pytest.mark.parametrize("y", [-0.4, 0.0, 0.4])
def test_a_plan_without_overhangs_stays_as_it_is(y: float) -> None:
    assert _plan(HOUSE, _with_openings(_front(y))) is HOUSE


def test_a_front_without_openings_that_no_wall_of_the_plan_belongs_to_changes_nothing() -> None:
    assert _plan(HOUSE, _front(-1.7)) is HOUSE


def test_a_front_of_another_side_does_not_fill_what_lies_beside_it() -> None:
    plan = Polygon([(0, 0), (12, 0), (12, 4), (6, 4), (6, 9), (0, 9)])
    assert _plan(plan, _front(0.0)) is plan


@pytest.mark.parametrize("y", [-1.2, -1.9, -3.5])
def test_a_front_on_piers_is_built_down_to_the_ground(y: float) -> None:
    found = _plan(HOUSE, _with_openings(_front(y)))
    assert found.symmetric_difference(box(0.0, y, 12.0, 9.0)).area < 0.01


@pytest.mark.parametrize("foot", [2.4, 3.3])
def test_a_storey_in_the_air_has_a_soffit_at_its_foot(foot: float) -> None:
    made = _block(HOUSE, _with_openings(_front(-1.5), foot))
    soffits = [f for f in made.solid.faces if f.semantics == "OuterCeilingSurface"]
    heights = made.solid.vertices[list(soffits[0].ring)][:, 2] / 1e4
    assert len(soffits) == 1 and np.allclose(heights, foot)
    volume = HOUSE.area * HIGH + 12.0 * 1.5 * (HIGH - foot)
    assert volume6(made.solid) / 6e12 == pytest.approx(volume, abs=0.01)
    assert any("jut out over its ground polygon from" in note for note in made.notes)


def test_storeys_may_jut_out_one_over_another() -> None:
    lower, upper = _with_openings(_front(-0.9 - 0.6), 3.0), _with_openings(_front(-2.2), 6.0)
    lower.high = 6.0
    feet = [s.foot for s in _storeys(HOUSE, lower, upper)]
    assert feet == [0.0, 3.0, 6.0]
    _block(HOUSE, lower, upper)


def test_storeys_that_jut_out_on_two_sides_meet_at_the_corner() -> None:
    side = PlanFacade(np.array([[13.6, -1.5], [13.6, 9.0]]), np.array([-1.0, 0.0]), 3.0, HIGH)
    fronts = (_with_openings(_front(-1.5, 0.0, 13.6), 3.0), _with_openings(side, 3.1))
    ground, upper = _storeys(HOUSE, *fronts)
    assert ground.plan is HOUSE
    assert upper.plan.symmetric_difference(box(0.0, -1.5, 13.6, 9.0)).area < 0.01
    _block(HOUSE, *fronts)


def test_a_front_reaches_beyond_the_corner_of_the_plan_as_far_as_its_openings() -> None:
    front = _with_openings(_front(-1.5, 6.0, 15.0))
    found = _plan(HOUSE, front)
    assert found.covers(box(6.0, -1.49, 14.5, -0.01))
    assert found.bounds[2] < 15.0


def test_what_other_facades_were_measured_behind_is_no_wall() -> None:
    curtain, wall = _with_openings(_front(-1.6)), _with_openings(_front(0.0))
    assert _plan(HOUSE, curtain, wall) is HOUSE


def test_a_wall_behind_an_arcade_gives_way_to_the_front() -> None:
    front, behind = _with_openings(_front(-2.0)), _with_openings(_front(0.05))
    behind.high = 3.0
    assert _plan(HOUSE, front, behind).bounds[1] == pytest.approx(-2.0, abs=0.01)


def test_other_parts_of_the_building_stay_free() -> None:
    part = box(0.0, -4.0, 5.0, 0.0)
    only = _storeys(HOUSE, _with_openings(_front(-2.0)), beside=part)[0].plan
    assert only.intersection(part).area < 0.01
    assert only.covers(box(5.1, -1.9, 11.9, 0.0))


def test_grounds_that_touch_are_one_block() -> None:
    parts = [_ground(box(0.0, 0.0, 7.0, 9.0)), _ground(box(7.0, 0.0, 12.0, 9.0))]
    made = ground_block("B", parts, WORLD, HIGH)
    assert isinstance(made, Host) and not validate(made.solid)
    assert volume6(made.solid) / 6e12 == pytest.approx(HOUSE.area * HIGH, rel=1e-3)


def test_the_lower_border_of_an_outline_is_the_ceiling_between_its_piers() -> None:
    piers = box(0.0, 0.0, 1.0, 3.0) | box(9.0, 0.0, 10.0, 3.0) | box(4.5, 0.0, 5.5, 3.0)
    outline = np.array((piers | box(0.0, 3.0, 10.0, 9.0)).exterior.coords)[:-1]
    assert lower_border(outline) == pytest.approx(3.0)


def test_undersides_of_balconies_are_no_ground() -> None:
    balcony = _ground(box(4.0, -1.0, 6.0, 0.0))
    high = Surface(balcony.ring + np.array([0.0, 0.0, 3.0]), "GroundSurface")
    made = ground_block("B", [_ground(HOUSE), high], WORLD, HIGH)
    assert isinstance(made, Host)
    assert volume6(made.solid) == volume6(_block(HOUSE).solid)


@pytest.mark.parametrize(("lowest", "foot"), [(2.5, 3.2 + 0.115), (3.4, 3.4)], ids=["low opening", "none"])
def test_a_soffit_lies_above_the_openings_that_were_seen_under_it(lowest: float, foot: float) -> None:
    # an opening of the front reaches below the front's own border; those of the wall behind reach to 3.2 m
    front = _with_openings(_front(-1.5), 3.6)
    front.held = (0.5, lowest, 11.5, HIGH - 1.0)
    behind = replace(_front(0.0), high=3.5, held=(0.5, 0.9, 11.5, 3.2))
    ground, upper = _storeys(HOUSE, front, behind)
    assert ground.plan.equals(HOUSE)
    assert upper.foot == pytest.approx(foot)
