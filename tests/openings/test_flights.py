"""Flights of steps before a wall, and the doors that they lead up to."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.model import DOORS
from frontage.openings import find_openings
from frontage.openings.flights import top_of_flight
from fronts import box_of, scan_wall

DOOR = (3.0, 2.0, 4.2, 4.4)
TOP = 1.9  # m, of the steps before it


def flight(rng, *, x=(2.8, 4.4), top=TOP, count=400):
    """Points (n, 3) m of a landing and of treads and risers of 18 on 28 cm that lead up to a wall."""
    y = rng.uniform(-2.0, -0.3, count)
    step = np.floor(np.maximum(-y - 0.6, 0.0) / 0.28)
    z = top - 0.18 * step - rng.uniform(0.0, 0.1, count)
    return np.column_stack([rng.uniform(*x, count), y, z])


def sorted_by_x(points):
    return points[np.argsort(points[:, 0])]


@pytest.mark.parametrize("seed", range(3))
def test_steps_end_where_their_highest_tread_is(seed):
    before = sorted_by_x(flight(np.random.default_rng(seed)))
    assert top_of_flight(before, DOOR, 0.0) == pytest.approx(TOP, abs=0.06)


@pytest.mark.parametrize(
    "low, high",
    [
        ((2.8, -1.9, 0.4), (4.4, -0.4, 1.6)),  # a car
        ((2.8, -0.7, 0.4), (4.4, -0.6, 2.0)),  # a fence
        ((3.0, -1.9, 0.4), (3.4, -0.4, 0.8)),  # a bin at one side
    ],
)
def test_what_does_not_rise_towards_the_wall_is_no_flight(low, high):
    points = np.random.default_rng(0).uniform(low, high, (400, 3))
    assert top_of_flight(sorted_by_x(points), DOOR, 0.0) is None


@pytest.mark.parametrize(
    ("wide", "fall", "found"), [(0.2, 0.64, True), (0.9, 0.64, False), (0.2, 0.1, False)]
)
def test_the_cheek_of_a_flight_tells_where_its_steps_end(wide, fall, found):
    """It is narrow, unlike a bush, and rises like stairs, unlike a garden wall."""
    rng = np.random.default_rng(0)
    x, y = rng.uniform(3.0, 3.0 + wide, 800), rng.uniform(-2.0, -0.05, 800)
    z = rng.uniform(0.4, 2.2 + fall * y)
    top = top_of_flight(sorted_by_x(np.column_stack([x, y, z])), DOOR, 0.0)
    assert top == (pytest.approx(2.0, abs=0.15) if found else None)


def test_steps_beside_a_door_do_not_lead_up_to_it():
    beside = sorted_by_x(flight(np.random.default_rng(0), x=(4.0, 6.0)))
    assert top_of_flight(beside, DOOR, 0.0) is None


@pytest.mark.parametrize("seed", range(2))
def test_the_foot_of_a_door_above_steps_is_where_they_end(seed):
    rng = np.random.default_rng(seed)
    facade, scan = scan_wall([DOOR], spacing=0.04, rays=False, seed=seed)
    x, _, z = scan.xyz.T
    shadow = (x > 2.6) & (x < 4.6) & (z < DOOR[1] + 0.5)  # of the steps and their walls
    points = np.vstack([scan.xyz[~shadow], flight(rng)])
    scan = replace(scan, xyz=points, origin_index=np.full(len(points), -1, np.int32))
    on_wall = np.arange(int((~shadow).sum()))
    (door,) = find_openings(replace(facade, support=on_wall, inliers=on_wall), scan).openings
    assert door.kind in DOORS
    assert np.abs(box_of(door) - DOOR)[[0, 2, 3]].max() < 0.05
    assert box_of(door)[1] == pytest.approx(DOOR[1], abs=0.2)
