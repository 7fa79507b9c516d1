"""Gaps that a scan leaves in a solid wall are no openings, however much they look like holes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import expit

from frontage.model import Estimate
from frontage.openings import OpeningOptions, find_openings
from frontage.openings.borders.gaps import is_opening
from frontage.openings.borders.measure import measure
from frontage.openings.observe import observe_wall
from frontage.openings.wall.crossings import crossing_beams
from fronts import WINDOW, box_of, scan_wall

JOINT = (5.0, 1.2, 5.4, 3.4)
PANE = (5.0, 2.4, 5.4, 2.9)


def behind_a_pipe(seed):
    """Returns a wall with a window, and a joint 7 cm deep that a pipe along its left side hides in part.

    The pipe ends the wall sharply; on the other sides wall and joint show through each other over a few
    decimetres.
    """
    facade, scan = scan_wall([WINDOW], rays=False, seed=seed)
    rng, p = np.random.default_rng(seed), scan.xyz.copy()
    x0, z0, x1, z1 = JOINT
    outside = np.maximum(p[:, 0] - x1, np.abs(p[:, 2] - (z0 + z1) / 2) - (z1 - z0) / 2)
    gap = (p[:, 0] > x0) & (rng.random(len(p)) > expit(outside / 0.1))
    p[gap, 1] += 0.07
    p = p[~gap | (rng.random(len(p)) < 0.4)]
    index = np.arange(len(p))
    unknown = np.full(len(p), -1, np.int32)
    return replace(facade, support=index, inliers=index), replace(scan, xyz=p, origin_index=unknown)


@pytest.mark.parametrize("seed", range(3))
def test_a_joint_behind_a_pipe_is_no_opening(seed):
    (window,) = find_openings(*behind_a_pipe(seed)).openings
    assert np.abs(box_of(window) - WINDOW).max() < 0.02


@pytest.mark.parametrize("rays", [True, False])
def test_a_narrow_pane_is_an_opening(rays):
    found = find_openings(*scan_wall([WINDOW, PANE], depth=0.09, rays=rays, returned=0.5)).openings
    assert len(found) == 2
    assert np.abs(box_of(found[1]) - PANE).max() < 0.02


def test_what_shows_neither_a_border_nor_a_frame_is_no_opening():
    facade, scan = scan_wall([WINDOW], rays=False)
    wall = observe_wall(facade, scan, OpeningOptions())
    (seen,) = measure(crossing_beams(facade, scan, wall.beams), [WINDOW], 0.04, 0.02)
    bare = replace(seen, borders=tuple(replace(b, gain=0.0) for b in seen.borders), depth=None)
    assert is_opening(seen) and is_opening(replace(seen, depth=None))
    assert is_opening(replace(bare, depth=seen.depth))
    assert is_opening(replace(bare, borders=(seen.borders[0], *bare.borders[1:])))
    assert not is_opening(bare)


@pytest.mark.parametrize(
    ("shown", "deep", "kept"), [(0, True, False), (1, True, True), (2, False, False), (3, False, True)]
)
def test_a_small_outline_that_beams_went_through_shows_some_of_its_borders(shown, deep, kept):
    facade, scan = scan_wall([PANE], depth=0.09, rays=True)
    wall = observe_wall(facade, scan, OpeningOptions())
    (seen,) = measure(crossing_beams(facade, scan, wall.beams), [PANE], 0.04, 0.02)
    borders = tuple(b if k < shown else replace(b, gain=0.0) for k, b in enumerate(seen.borders))
    assert is_opening(replace(seen, borders=borders, depth=seen.depth if deep else None)) is kept


@pytest.mark.parametrize(
    ("rays", "depth", "kept"),
    [(False, 0.03, False), (False, 0.071, False), (False, 0.08, True), (True, 0.03, True)],
)
def test_a_small_recess_no_deeper_than_a_panel_is_an_ornament(rays, depth, kept):
    """Lines of sight that went through the wall prove an opening of any depth."""
    facade, scan = scan_wall([PANE], depth=0.08, rays=rays)
    wall = observe_wall(facade, scan, OpeningOptions())
    (seen,) = measure(crossing_beams(facade, scan, wall.beams), [PANE], 0.04, 0.02)
    sunk = replace(seen, depth=Estimate(depth, np.array([[1e-6]]), 20.0))
    assert is_opening(sunk) is kept


@pytest.mark.parametrize(("behind", "kept"), [(0.09, False), (0.2, True)])
def test_a_small_window_whose_frame_is_shallow_is_told_by_what_lies_behind_it(behind, kept):
    facade, scan = scan_wall([PANE], depth=0.05, rays=False)
    x0, z0, x1, z1 = PANE
    x, _, z = scan.xyz.T
    inner = (x > x0 + 0.05) & (x < x1 - 0.05) & (z > z0 + 0.05) & (z < z1 - 0.05)
    scan = replace(scan, xyz=scan.xyz + np.outer(inner, [0.0, behind - 0.05, 0.0]))
    wall = observe_wall(facade, scan, OpeningOptions())
    (seen,) = measure(crossing_beams(facade, scan, wall.beams), [PANE], 0.04, 0.02)
    assert is_opening(replace(seen, depth=Estimate(0.05, np.array([[1e-6]]), 20.0))) is kept


@pytest.mark.parametrize(("returned", "kept"), [(0.1, True), (0.9, False)])
def test_a_small_recess_that_returns_nothing_is_no_panel(returned, kept):
    facade, scan = scan_wall([PANE], depth=0.05, rays=False, returned=returned)
    wall = observe_wall(facade, scan, OpeningOptions())
    (seen,) = measure(crossing_beams(facade, scan, wall.beams), [PANE], 0.04, 0.02)
    assert is_opening(replace(seen, depth=Estimate(0.05, np.array([[1e-6]]), 20.0))) is kept


@pytest.mark.parametrize("rays", [True, False])
def test_a_small_gap_needs_a_frame_where_lines_of_sight_are_unknown(rays):
    facade, scan = scan_wall([PANE], depth=0.15, rays=rays)
    wall = observe_wall(facade, scan, OpeningOptions())
    (seen,) = measure(crossing_beams(facade, scan, wall.beams), [PANE], 0.04, 0.02)
    assert is_opening(seen)
    assert is_opening(replace(seen, depth=None)) is rays


@pytest.mark.parametrize(("shown", "kept"), [(4, True), (3, True), (2, False)])
def test_a_gap_of_middle_size_that_shows_nothing_behind_needs_most_of_its_borders(shown, kept):
    facade, scan = scan_wall([(5.0, 1.4, 5.8, 3.2)], depth=0.15, rays=False)
    wall = observe_wall(facade, scan, OpeningOptions())
    (seen,) = measure(crossing_beams(facade, scan, wall.beams), [(5.0, 1.4, 5.8, 3.2)], 0.04, 0.02)
    borders = tuple(b if k < shown else replace(b, gain=0.0) for k, b in enumerate(seen.borders))
    assert is_opening(replace(seen, borders=borders, depth=None)) is kept
