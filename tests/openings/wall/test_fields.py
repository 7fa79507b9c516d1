"""Where the highest beam of a station runs over a wall, fewer beams are due above than below."""

import numpy as np
import pytest

from frontage.openings.wall.beams import sort_beams
from frontage.openings.wall.evidence import weigh
from frontage.openings.wall.fields import fields_of_view, zones
from frontage.openings.wall.raster import WallRaster
from openings.boxes import scanned

NEAR, FAR = (4.0, -3.0, 1.6), (4.0, -9.0, 1.6)
LIMIT = np.sin(np.radians(45.0))  # of the near station: 3 m above it right in front


UPRIGHT = np.array([0.0, 0.0, 1.0])


def limited(axis):
    """A wall without the beams of the near station that lie more than LIMIT above the plane across `axis`."""
    facade, scan = scanned(eyes=(NEAR, FAR))
    beam = scan.xyz - scan.origins[scan.origin_index]
    too_high = (scan.origin_index == 0) & (beam @ axis > LIMIT * np.linalg.norm(beam, axis=1))
    old = np.flatnonzero(~too_high)
    number = np.full(len(scan), -1)
    number[old] = np.arange(len(old))
    support, inliers = (k[k >= 0] for k in (number[facade.support], number[facade.inliers]))
    return type(facade)(**{**facade.__dict__, "support": support, "inliers": inliers}), scan.take(old)


@pytest.fixture(scope="module")
def front():
    return limited(UPRIGHT)


def test_a_field_of_view_ends_at_the_highest_beam_of_its_station(front):
    near, far = fields_of_view(*front)
    assert near.eye == pytest.approx(NEAR) and far.eye == pytest.approx(FAR)
    assert near.highest == pytest.approx(LIMIT, abs=0.005)
    assert far.highest < LIMIT  # the eaves, which lie lower than the limit of the instrument
    found = zones((near, far), WallRaster((0.0, 0.0), 0.1, (90, 80)))
    assert (found[:44, 40] == 3).all() and (found[48:85, 40] == 2).all()
    assert (found[46, :20] == 3).all()  # the limit is a curve: it rises to both sides


@pytest.mark.parametrize("degrees", [-0.8, -0.3, 0.3, 0.8])
def test_a_tilted_station_looks_higher_to_one_side(degrees):
    axis = np.array([np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees))])
    near, _ = fields_of_view(*limited(axis))
    assert np.degrees(np.arccos(near.up @ axis)) < 0.2
    assert near.highest == pytest.approx(LIMIT, abs=0.003)


def test_beams_due_fall_at_once_where_the_field_of_a_station_ends(front):
    facade, scan = front
    evidence = weigh(facade, sort_beams(facade, scan))
    cell = evidence.raster.cell
    columns = slice(int(3.7 / cell), int(4.3 / cell))
    for low, high in ((4.2, 4.5), (4.7, 5.0)):
        rows = slice(int(low / cell), int(high / cell))
        due, come = (m[rows, columns].sum() for m in (evidence.expected, evidence.solid))
        assert due == pytest.approx(come, rel=0.15)


def test_a_vehicle_has_no_field_of_view(front):
    facade, scan = front
    count = 200
    index = (np.arange(len(scan)) % count).astype(np.int32)
    moving = type(scan)("drive", scan.xyz, scan.world, np.tile(NEAR, (count, 1)), index)
    assert fields_of_view(facade, moving) == ()
