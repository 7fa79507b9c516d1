"""Railings of high balconies: their floors hide the wall from a scanner in the street, and its beams tell."""

import numpy as np
import pytest

import ortho_wall as wall
from frontage.model import Scan
from frontage.ortho import OrthoOptions
from frontage.ortho.occluders import find_occluders
from frontage.ortho.standing.find import find_standing
from ortho_wall import grid

OUT, FLOOR, HIGH = 1.0, 3.0, 1.0  # m, of both balconies
STATION = np.array([0.0, -8.0, -3.3])
LEFT, RIGHT = (-3.0, -1.0), (1.0, 3.0)  # a railing, and a parapet


def within(at, low_high):
    return (at > low_high[0]) & (at < low_high[1])


def seen(front, bars):
    """Which points (n, 3) of the wall beams from the station reach."""
    ray = front - STATION
    with np.errstate(divide="ignore", invalid="ignore"):
        floor = STATION + ray * ((FLOOR - STATION[2]) / ray[:, 2])[:, None]
    before = STATION + ray * ((-OUT - STATION[1]) / ray[:, 1])[:, None]
    hidden = np.zeros(len(front), bool)
    for wide in (LEFT, RIGHT):
        hidden |= within(floor[:, 0], wide) & within(floor[:, 1], (-OUT, 0.0)) & (front[:, 2] > FLOOR)
    tall = within(before[:, 2], (FLOOR, FLOOR + HIGH))
    hidden |= tall & within(before[:, 0], RIGHT)
    hidden |= tall & within(before[:, 0], LEFT) & (np.abs(before[:, :1] - bars).min(axis=1) < 0.01)
    return ~hidden


@pytest.fixture(scope="module")
def street():
    facade = wall.facade(8.0, 11.0, spacing=0.03)
    places = np.arange(*LEFT, 0.12)
    bars = np.concatenate([grid(float(x), -OUT, (FLOOR, FLOOR + HIGH), 0.02) for x in places])
    rails = grid(LEFT, -OUT, FLOOR + HIGH, 0.02)
    parapet = grid(RIGHT, -OUT, (FLOOR, FLOOR + HIGH))
    floors = np.concatenate([grid(wide, (-OUT, 0.0), FLOOR) for wide in (LEFT, RIGHT)])
    front = grid((-4.0, 4.0), 0.0, (-5.0, 5.5))
    ground = grid((-4.0, 4.0), (-8.0, 0.0), -5.0, 0.1)
    xyz = np.concatenate([bars, rails, parapet, floors, front[seen(front, places)], ground])
    index = np.zeros(len(xyz), np.int32)
    origins = facade.frame.apply(STATION[None])
    return facade, Scan("street", facade.frame.apply(xyz), facade.world, origins, index)


def test_beams_that_reach_the_wall_tell_a_railing_from_a_parapet(street):
    facade, scan = street
    xyz = facade.frame.inverse.apply(scan.xyz)
    standing, options = find_standing(facade, scan), OrthoOptions()
    x, y, z = find_occluders(facade, xyz, standing, None, options, scan).part[0].T
    out = (y < -OUT + 0.1) & within(z, (FLOOR + 0.15, FLOOR + HIGH - 0.1))
    assert (out & (x < 0.0)).sum() < 20, "the railing"
    assert (out & (x > 0.0)).sum() > 500, "the parapet"
    floor = within(y, (-OUT + 0.1, -0.2)) & (np.abs(z - FLOOR) < 0.05)
    assert (floor & (x < 0.0)).sum() > 500, "the floor behind the railing"


def test_without_the_places_of_the_scanner_the_railing_may_be_a_parapet(street):
    facade, scan = street
    xyz = facade.frame.inverse.apply(scan.xyz)
    x, y, z = find_occluders(facade, xyz, find_standing(facade, scan), None, OrthoOptions()).part[0].T
    assert ((x < 0.0) & (y < -OUT + 0.1) & (z > FLOOR + 0.15)).sum() > 200


def test_beams_along_the_wall_tell_nothing(street):
    """They would meet the plane of the wall far away, and a grid up to there would fill the memory."""
    facade, scan = street
    station = facade.frame.apply(np.array([[-60.0, -OUT - 1e-4, FLOOR]]))
    along = Scan("along", scan.xyz, facade.world, station, scan.origin_index)
    xyz = facade.frame.inverse.apply(along.xyz)
    cloud = find_occluders(facade, xyz, find_standing(facade, along), None, OrthoOptions(), along)
    x, y, z = cloud.part[0].T
    assert ((x < 0.0) & (y < -OUT + 0.1) & (z > FLOOR + 0.15)).sum() > 200
