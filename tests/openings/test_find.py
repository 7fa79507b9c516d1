"""Openings of small walls: found in their places, none on a bare wall, honest about the unknown."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.model.estimate import Failed
from frontage.model.facade import Facade
from frontage.model.scan import Scan
from frontage.openings import FoundOpenings, find_openings
from frontage.openings.kinds import in_reading_order
from frontage.openings.layout.selection import CellBox, best_layout
from frontage.openings.options import OpeningOptions
from fronts import DOOR, WINDOW, box_of, scan_wall


def found_in(*args, **kwargs):
    result = find_openings(*scan_wall(*args, **kwargs))
    assert isinstance(result, FoundOpenings)
    return result.openings


@pytest.mark.parametrize("rays", [True, False])
@pytest.mark.parametrize("spacing", [0.01, 0.02, 0.04])
def test_borders_and_depth(rays, spacing):
    door, window = found_in([WINDOW, DOOR], rays=rays, spacing=spacing)
    assert (door.kind, window.kind) == ("door", "window")
    assert np.abs(box_of(window) - WINDOW).max() < 0.4 * spacing + 0.003
    assert np.abs(box_of(door) - DOOR)[[0, 2, 3]].max() < 0.4 * spacing + 0.003
    assert window.depth is not None and abs(window.depth.value - 0.15) < 0.01
    assert in_reading_order((window, door)) == (door, window)  # the row below first


def test_panes_that_return_nothing():
    (window,) = found_in([WINDOW], returned=0.0)
    assert np.abs(box_of(window) - WINDOW).max() < 0.015
    assert window.depth is None


def test_a_bare_wall_has_no_openings():
    assert found_in([]) == ()


def test_one_window_is_not_two_and_two_are_not_one():
    pair = [(1.0, 2.0, 1.8, 3.4), (1.95, 2.0, 2.75, 3.4)]
    openings = found_in(pair)
    assert len(openings) == 2
    assert all(np.abs(box_of(o) - p).max() < 0.012 for o, p in zip(openings, pair, strict=True))


def test_what_was_not_scanned_is_no_opening():
    facade, scan = scan_wall([WINDOW])
    x, z = scan.xyz[:, 0], scan.xyz[:, 2]
    kept = np.flatnonzero(~((x > 3.0) & (z > 1.0)))  # a corner of the front that no beam reached
    facade = Facade(**{**facade.__dict__, "support": np.arange(len(kept)), "inliers": np.arange(len(kept))})
    result = find_openings(facade, scan.take(kept))
    assert [o.kind for o in result.openings] == ["window"]
    assert any("not seen" in note for note in result.notes)


def test_a_room_behind_the_wall_is_no_opening():
    facade, scan = scan_wall([WINDOW], rays=False)
    room = scan.xyz[::2] + np.array([0.0, 0.4, 0.0])  # the inner face of the wall, scanned from inside
    cloud = Scan("wall", np.vstack([scan.xyz, room]), scan.world)
    index = np.arange(len(cloud))
    (window,) = find_openings(
        Facade(**{**facade.__dict__, "support": index, "inliers": facade.inliers}), cloud
    ).openings
    assert np.abs(box_of(window) - WINDOW).max() < 0.015


def test_thirty_points_fail_with_a_sentence():
    facade, scan = scan_wall([WINDOW], spacing=1.0)
    result = find_openings(facade, scan)
    assert isinstance(result, Failed) and "points" in result.message


def test_the_same_input_gives_the_same_result():
    first, second = (found_in([WINDOW, DOOR]) for _ in range(2))
    assert [o.ring.tobytes() for o in first] == [o.ring.tobytes() for o in second]


@pytest.mark.parametrize("rays", [True, False])
def test_neither_order_nor_handedness_changes_the_openings(rays):
    facade, scan = scan_wall([WINDOW, DOOR, (5.6, 2.6, 6.4, 4.1)], rays=rays)
    openings = [box_of(o) for o in find_openings(facade, scan).openings]
    order = np.random.default_rng(8).permutation(len(scan))
    shuffled = [box_of(o) for o in find_openings(facade, scan.take(order)).openings]
    assert np.abs(np.subtract(openings, shuffled)).max() < 1e-6
    side = np.array([-1.0, 1.0, 1.0])
    mirror = replace(scan, xyz=scan.xyz * side, origins=scan.origins * side)
    other = find_openings(replace(facade, outline=facade.outline[::-1] * side[:2]), mirror).openings
    mirrored = [box_of(o)[[2, 1, 0, 3]] * [-1, 1, -1, 1] for o in other]
    assert np.abs(np.sort(openings, axis=0) - np.sort(mirrored, axis=0)).max() < 1e-6


def test_sigmas_are_honest():
    errors = []
    for seed in range(6):
        (window,) = found_in([WINDOW], seed=seed, spacing=0.04)
        sigma = np.sqrt(np.diag(window.ring_covariance))[[0, 1, 4, 5]]
        errors.append((box_of(window) - WINDOW) / sigma)
    assert 0.2 < np.sqrt(np.mean(np.square(errors))) < 1.6


def test_layout_prefers_the_pair_that_is_worth_more():
    whole, left, right = CellBox(0, 0, 10, 20, 50.0), CellBox(0, 0, 10, 9, 30.0), CellBox(0, 11, 10, 20, 30.0)
    assert best_layout([[whole, left, right]]) == [left, right]
    assert best_layout([[CellBox(0, 0, 10, 20, 70.0), left, right]])[0].worth == 70.0


def test_least_size():
    options = OpeningOptions(min_width=2.0)
    assert find_openings(*scan_wall([WINDOW]), options).openings == ()
