"""Ground plans reach up to the measured fronts of storeys that jut out over them."""

import numpy as np
import pytest
from shapely.geometry import Polygon, box

from frontage.solids.coarse.overhangs import with_overhangs
from frontage.solids.coarse.plan_facade import PlanFacade
from frontage.solids.options import BuildOptions

HOUSE = box(0.0, 0.0, 12.0, 9.0)
INWARD = np.array([0.0, 1.0])  # the street lies at negative y


def _front(y: float, left: float = 0.0, right: float = 12.0) -> PlanFacade:
    """Returns a facade along the street, y m behind the front of the house."""
    return PlanFacade(np.array([[left, y], [right, y]]), INWARD)


@pytest.mark.parametrize("off", [-0.2, 0.0, 0.15])
@pytest.mark.parametrize("deep", [1.5, 3.0])
def test_a_deep_entrance_is_closed_along_the_wall_beside_it(off: float, deep: float) -> None:
    plan = HOUSE - box(7.0, 0.0, 10.0, deep)
    found = with_overhangs(plan, [_front(off)], BuildOptions())
    assert found.symmetric_difference(HOUSE).area < 0.01


def test_the_wall_above_a_passage_is_built_with_the_yard_behind_it() -> None:
    passage = box(4.0, 0.0, 7.0, 8.0)
    found = with_overhangs(HOUSE - passage, [_front(0.1)], BuildOptions())
    assert found.covers(box(0.01, 0.01, 11.99, 3.9))
    assert found.area < HOUSE.area - 10.0  # the far end of the passage stays open


def test_a_front_turned_against_the_plan_keeps_the_line_of_the_plan() -> None:
    front = PlanFacade(np.array([[0.0, 0.0], [12.0, 0.1]]), INWARD)
    found = with_overhangs(HOUSE - box(7.0, 0.0, 10.0, 2.0), [front], BuildOptions())
    assert found.symmetric_difference(HOUSE).area < 0.01


@pytest.mark.parametrize("y", [-0.4, 0.0, 0.4])
def test_a_plan_without_overhangs_stays_as_it_is(y: float) -> None:
    assert with_overhangs(HOUSE, [_front(y)], BuildOptions()) is HOUSE


def test_a_front_that_no_wall_of_the_plan_belongs_to_changes_nothing() -> None:
    assert with_overhangs(HOUSE, [_front(-1.7)], BuildOptions()) is HOUSE


def test_a_front_of_another_side_does_not_fill_what_lies_beside_it() -> None:
    plan = Polygon([(0, 0), (12, 0), (12, 4), (6, 4), (6, 9), (0, 9)])
    assert with_overhangs(plan, [_front(0.0)], BuildOptions()) is plan
