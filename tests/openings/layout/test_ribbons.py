"""Ribbon windows run along a storey between bands of wall, longer than any other opening."""

import numpy as np
import pytest

from frontage.openings import OpeningOptions, find_openings
from fronts import box_of, scan_wall

RIBBON = (2.0, 2.0, 14.0, 3.5)
OPTIONS = OpeningOptions(ground_z=-5.0)


def found(hole, *, rays, returned=0.2):
    """Returns the boxes of what is found in a wall 16 m long whose hole returns a share of the beams."""
    facade, scan = scan_wall([hole], spacing=0.03, depth=0.1, rays=rays, returned=returned, size=(16.0, 5.0))
    openings = find_openings(facade, scan, OPTIONS).elements.openings
    return [box_of(o) for o in openings]


@pytest.mark.parametrize("rays", [True, False])
def test_a_ribbon_window_is_one_opening(rays):
    (box,) = found(RIBBON, rays=rays)
    np.testing.assert_allclose(box, RIBBON, atol=0.04)


@pytest.mark.parametrize("rays", [True, False])
def test_a_ribbon_window_may_go_on_round_the_corner_of_the_house(rays):
    (box,) = found((2.0, 2.0, 20.0, 3.5), rays=rays)
    np.testing.assert_allclose(box[[0, 1, 3]], np.array(RIBBON)[[0, 1, 3]], atol=0.04)
    assert box[2] > 15.5


def test_a_long_strip_that_returns_nothing_is_none_where_lines_of_sight_are_unknown():
    assert found(RIBBON, rays=False, returned=0.0) == []


@pytest.mark.parametrize("rays", [True, False])
def test_a_strip_from_end_to_end_of_a_wall_is_none(rays):
    """A scan that thins out leaves such strips."""
    assert found((-1.0, 2.0, 20.0, 3.5), rays=rays) == []


@pytest.mark.parametrize("rays", [True, False])
def test_a_gap_in_the_wall_that_touches_a_ribbon_window_does_not_hide_it(rays):
    facade, scan = scan_wall(
        [RIBBON, (6.0, 3.5, 6.9, 4.4)], spacing=0.03, depth=0.1, rays=rays, returned=0.2, size=(16.0, 5.0)
    )
    boxes = [box_of(o) for o in find_openings(facade, scan, OPTIONS).elements.openings]
    assert any(np.abs(box - RIBBON).max() < 0.04 for box in boxes)


@pytest.mark.parametrize("rays", [True, False])
@pytest.mark.parametrize("hole", [(6.0, 2.0, 10.2, 2.5), (6.0, 0.4, 6.5, 4.6)])
def test_a_long_window_may_be_low_or_narrow(hole, rays):
    (box,) = found(hole, rays=rays, returned=0.5)
    np.testing.assert_allclose(box, hole, atol=0.04)
