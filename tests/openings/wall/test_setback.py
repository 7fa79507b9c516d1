"""Storeys and dormers set back by a hand's breadth; panes, curtains and leaning walls are none."""

import numpy as np
import pytest

from frontage.openings.wall.raster import TILE, WallRaster
from frontage.openings.wall.surface import value_at, wall_depth

PARAPET, TOP = 5.0, 8.0  # m, where the nearer wall ends and where the set-back one does
BACK, PANE = 0.14, 0.2  # m behind the nearer wall
WINDOWS = ((1.6, 3.0), (3.6, 5.0))


def front(wide, piers=None, seed=0):
    """Points of a wall 8 m wide and of what stands on its parapet between two places, with two windows.

    piers  m, depth of the wall on both sides of what is set back; None = nothing stands there
    """
    rng = np.random.default_rng(seed)
    below = rng.uniform((0.0, -0.004, 0.0), (8.0, 0.004, PARAPET), (40_000, 3))
    above = rng.uniform((0.0, -0.004, PARAPET), (8.0, 0.004, TOP), (24_000, 3))
    x, _, z = above.T
    glass = np.any([(x > a) & (x < b) for a, b in WINDOWS], axis=0) & (z > 5.2) & (z < 6.7)
    inside = (x > wide[0]) & (x < wide[1])
    above[inside, 1] += np.where(glass, PANE, BACK)[inside]
    if piers is None:
        above = above[inside]
    else:
        above[~inside, 1] += piers
    return np.vstack([below, above])


def depths(points, x, z, rays):
    raster = WallRaster((0.0, 0.0), TILE, (round(TOP / TILE), 32))
    return value_at(wall_depth(points, raster, 0.004, rays), raster, np.array(x), np.full(len(x), z))


@pytest.mark.parametrize("rays", [True, False])
@pytest.mark.parametrize("wide", [(1.0, 5.5), (0.0, 8.0)])
def test_what_stands_back_above_a_parapet_has_its_own_depth_down_to_it(wide, rays):
    points = front(wide)
    at = (1.3, 3.3, 5.3)  # between and beside the windows
    for z in (5.4, 6.0, 6.6, 7.4):
        assert np.abs(depths(points, at, z, rays) - BACK).max() < 0.02
    assert np.abs(depths(points, at, PARAPET - 0.4, rays)).max() < 0.02


def test_panes_that_the_nearer_wall_bounds_are_no_wall():
    """A window that reaches the top of what was scanned stands between the jambs of the nearer wall."""
    points = front((2.0, 5.0), piers=0.0)
    assert np.abs(depths(points, (1.0, 2.5, 4.5, 6.0), 6.0, rays=False)).max() < 0.02


def test_a_roof_above_the_wall_is_none():
    points = front((0.0, 8.0))
    on = points[:, 2] > PARAPET
    points[on, 1] = points[on, 2] - PARAPET
    assert np.abs(depths(points, (1.0, 4.0, 7.0), PARAPET + 0.1, rays=False)).max() < 0.1


def test_a_wall_that_leans_back_keeps_its_depth():
    points = front((0.0, 8.0))
    points[:, 1] = 0.02 * points[:, 2] + np.random.default_rng(1).normal(0.0, 0.004, len(points))
    for z in (1.0, 4.0, 7.0):
        assert np.abs(depths(points, (1.0, 4.0, 7.0), z, rays=False) - 0.02 * z).max() < 0.02
