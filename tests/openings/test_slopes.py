"""Strips of roof between dormers are no openings; blinds, ceilings and rooms behind windows are no roofs."""

import numpy as np
import pytest

from frontage.openings.slopes import are_roofs

PLACE = (2.0, 7.0, 3.5, 9.0)


def surface(depth, low=7.0):
    """Points on a surface behind a place, at the depth (m) that a function of the height z m tells."""
    rng = np.random.default_rng(0)
    x, z = rng.uniform(2.0, 3.5, 8000), rng.uniform(low, 9.0, 8000)
    return np.column_stack([x, depth(z) + rng.normal(0.0, 0.004, len(z)), z])


@pytest.mark.parametrize("pitch", [35.0, 50.0, 70.0])
def test_a_roof_that_begins_at_the_wall_is_one(pitch):
    roof = surface(lambda z: (z - 7.0) / np.tan(np.radians(pitch)))
    assert are_roofs([PLACE, (5.0, 7.0, 6.5, 9.0)], roof, 0.02) == [True, False]


def test_the_sides_of_dormers_beside_a_roof_do_not_hide_it():
    """They are seen along the roof, so that they hold most of the points in little of the width."""
    roof = surface(lambda z: z - 7.0)
    rng = np.random.default_rng(2)
    z = rng.uniform(7.0, 9.0, 20000)
    side = np.column_stack([rng.choice([2.02, 3.48], len(z)), rng.uniform(0.0, 1.0, len(z)) * (z - 7.0), z])
    assert are_roofs([PLACE], np.vstack([roof, side]), 0.015) == [True]


@pytest.mark.parametrize("depth", [lambda z: np.full(len(z), 0.2), lambda z: 0.3 - (z - 7.0) * 0.5])
def test_blinds_and_what_leans_to_the_street_are_none(depth):
    assert are_roofs([PLACE], surface(depth), 0.02) == [False]


def test_a_ceiling_and_the_frame_before_it_are_none():
    ceiling = np.random.default_rng(1).uniform((2.0, 0.2, 8.95), (3.5, 3.0, 9.0), (8000, 3))
    assert are_roofs([PLACE], ceiling, 0.02) == [False]


def test_a_roof_behind_the_lowest_part_of_a_place_does_not_fill_it():
    low = surface(lambda z: (z - 7.0) * 0.4)
    assert are_roofs([(2.0, 5.0, 3.5, 9.5)], low[low[:, 2] < 8.0], 0.02) == [False]
