"""What stands before a wall may hide it, but not where the wall returns its beams all the same."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.openings import OpeningOptions, find_openings
from frontage.openings.observe import observe_wall
from fronts import scan_wall

DOOR = (3.0, 0.2, 4.6, 2.4)


def with_points(facade, scan, more):
    """Returns the facade and its scan with more points (n, 3) m."""
    p = np.concatenate([scan.xyz, more])
    index, unknown = np.arange(len(p)), np.full(len(p), -1, np.int32)
    return replace(facade, support=index, inliers=index), replace(scan, xyz=p, origin_index=unknown)


def block(seed, x, y, z, n=20000):
    """Returns points (n, 3) m in a block between pairs of coordinates, as of plants."""
    return np.random.default_rng(seed).uniform([x[0], y[0], z[0]], [x[1], y[1], z[1]], (n, 3))


def due(facade, scan, box):
    """Returns the beams that are due in a box x0, z0, x1, z1 m, as a share of those due without obstacles."""
    evidence = observe_wall(facade, scan, OpeningOptions()).evidence
    x, z = evidence.raster.middles(np.ones(evidence.raster.shape, np.bool_)).T
    within = (x > box[0]) & (x < box[2]) & (z > box[1]) & (z < box[3])
    return evidence.expected.ravel()[within].sum() / evidence.expected_free.ravel()[within].sum()


@pytest.mark.parametrize("seed", range(3))
def test_plants_do_not_hide_a_door_beside_wall_that_shows_behind_them(seed):
    facade, scan = scan_wall([DOOR], rays=False, returned=0.0, seed=seed)
    plants = block(seed, (1.4, 3.7), (-1.0, -0.6), (0.1, 1.4))
    assert due(*with_points(facade, scan, plants), DOOR) > 0.99


@pytest.mark.parametrize("seed", range(3))
def test_wall_that_an_awning_hides_is_no_opening(seed):
    facade, scan = scan_wall([], rays=False, seed=seed)
    x, _, z = scan.xyz.T
    hidden = (x > 2.0) & (x < 4.0) & (z > 1.4) & (z < 2.6)
    scan = replace(scan, xyz=scan.xyz[~hidden], origin_index=scan.origin_index[~hidden])
    awning = block(seed, (2.0, 4.0), (-1.1, -0.4), (2.5, 2.6))
    seen = with_points(facade, scan, awning)
    assert due(*seen, (2.1, 1.5, 3.9, 2.4)) < 0.05
    assert find_openings(*seen).openings == ()
