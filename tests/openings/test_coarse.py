"""Openings in coarse clouds, and in clouds that do not know where they were measured from."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.model.scan import Scan
from frontage.openings import FoundOpenings, find_openings
from fronts import WINDOW, box_of, scan_wall


def boxes_in(facade, scan):
    found = find_openings(facade, scan)
    assert isinstance(found, FoundOpenings)
    return np.array(
        sorted((box_of(o).tolist() for o in found.openings), key=lambda b: (round(b[0]), b[1]))
    ).reshape(-1, 4)


@pytest.mark.parametrize("rays", [True, False])
def test_windows_of_few_cells_are_found_whole(rays):
    holes = np.array([(x, z, x + 1.1, z + 1.4) for x in (1.0, 3.1, 5.2, 7.3) for z in (1.0, 3.9, 6.8)])
    found = boxes_in(*scan_wall(holes, spacing=0.08, returned=0.1, rays=rays, size=(9.5, 9.0)))
    assert found.shape == holes.shape
    assert np.abs(found - holes).max() < 0.12


@pytest.mark.parametrize("rays", [True, False])
@pytest.mark.parametrize("depth", [0.025, 0.06])
def test_a_panel_under_a_window_is_wall(depth, rays):
    window, panel = (2.0, 2.0, 3.4, 3.8), (2.0, 0.9, 3.4, 1.8)
    facade, scan = scan_wall([window], returned=0.2, rays=rays)
    x, _, z = scan.xyz.T
    back = (x > panel[0]) & (x < panel[2]) & (z > panel[1]) & (z < panel[3])
    recessed = replace(scan, xyz=scan.xyz + np.outer(back * depth, [0.0, 1.0, 0.0]))
    found = boxes_in(facade, recessed)
    assert len(found) == 1 and np.abs(found[0] - window).max() < 0.03


@pytest.mark.parametrize("rays", [True, False])
def test_a_shallow_door_on_the_ground_is_no_panel(rays):
    door = (3.0, 0.1, 4.1, 2.3)
    found = boxes_in(*scan_wall([door], depth=0.06, rays=rays))
    assert len(found) == 1 and np.abs(found[0] - door).max() < 0.03


def test_wall_in_sight_above_and_below_ledges_frames_a_window():
    window = (2.0, 2.0, 3.4, 3.4)
    facade, scan = scan_wall([window], returned=0.2, rays=False)
    x, z = np.meshgrid(np.arange(1.5, 4.0, 0.02), np.arange(0.0, 0.06, 0.02))
    ledges = [np.column_stack([x.ravel(), np.full(x.size, -0.6), z.ravel() + at]) for at in (1.75, 3.65)]
    xyz = np.concatenate([scan.xyz, *ledges])
    some = np.arange(len(xyz))
    with_ledges = replace(facade, support=some, inliers=some), Scan("wall", xyz, scan.world)
    found = boxes_in(*with_ledges)
    assert len(found) == 1 and np.abs(found[0] - window).max() < 0.03


def test_shadows_of_leaves_on_a_wall_are_no_windows():
    facade, scan = scan_wall([WINDOW], returned=0.1, rays=False, size=(7.0, 5.0))
    rng = np.random.default_rng(2)
    leaves, reach = rng.uniform([3.2, 0.6], [6.6, 4.4], (150, 2)), rng.lognormal(np.log(0.12), 0.4, 150)
    away = np.linalg.norm(scan.xyz[:, None, [0, 2]] - leaves, axis=2)
    seen = np.flatnonzero((away > reach).all(1))
    found = boxes_in(
        *(replace(facade, support=np.arange(len(seen)), inliers=np.arange(len(seen))), scan.take(seen))
    )
    assert len(found) == 1 and np.abs(found[0] - WINDOW).max() < 0.03


def test_a_small_window_that_shows_little_of_its_depth_is_found_by_its_sharp_borders():
    small = (2.0, 2.5, 2.4, 3.1)
    found = boxes_in(*scan_wall([small], returned=0.12, rays=False))
    assert len(found) == 1 and np.abs(found[0] - small).max() < 0.03


def test_a_wide_mullion_behind_the_wall_parts_no_window():
    wide = (2.0, 1.5, 4.3, 3.3)
    facade, scan = scan_wall([wide], returned=0.0, rays=False, size=(7.0, 5.0))
    x, z = np.meshgrid(np.arange(3.05, 3.25, 0.02), np.arange(1.51, 3.29, 0.02))
    mullion = np.column_stack([x.ravel(), np.full(x.size, 0.055), z.ravel()])
    mullion[:, 1] += np.random.default_rng(3).normal(0, 0.003, len(mullion))
    xyz = np.vstack([scan.xyz, mullion])
    index = np.arange(len(xyz))
    rough = replace(facade, support=index, inliers=index, roughness=0.02)
    found = boxes_in(rough, replace(scan, xyz=xyz, origin_index=np.full(len(xyz), -1, np.int32)))
    assert len(found) == 1 and np.abs(found[0] - wide).max() < 0.03
