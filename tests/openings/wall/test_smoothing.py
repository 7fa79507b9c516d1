"""Walls so noisy that single points do not tell a closed leaf from the wall."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.openings import FoundOpenings, find_openings
from frontage.openings.wall.smoothing import smoothed
from fronts import EYE, box_of, scan_wall

LEAVES = np.array([(x, z, x + 1.2, z + 1.5) for x in (1.0, 3.4) for z in (1.2, 4.2)])
PANEL = (5.5, 1.7, 7.0, 2.8)  # of another size than the leaves, or it were a closed one of their kind


def noisy_wall(noise, rays, depth=0.12, spacing=0.05):
    """A wall with closed leaves `depth` m deep and a panel of 4 cm; all ranges have `noise` m."""
    facade, scan = scan_wall(LEAVES, size=(8.0, 7.0), depth=depth, spacing=spacing, rays=rays)
    x, _, z = scan.xyz.T
    x0, z0, x1, z1 = PANEL
    panel = (x > x0) & (x < x1) & (z > z0) & (z < z1)
    xyz = scan.xyz + np.outer(0.04 * panel, [0.0, 1.0, 0.0])
    way = xyz - EYE
    ranges = np.random.default_rng(3).normal(0.0, noise, len(x)) / np.linalg.norm(way, axis=1)
    return replace(facade, roughness=max(noise, 0.005)), replace(scan, xyz=xyz + way * ranges[:, None])


@pytest.mark.parametrize("rays", [True, False])
def test_closed_leaves_in_a_noisy_wall_are_found_and_a_panel_is_not(rays):
    found = find_openings(*noisy_wall(0.028, rays))
    assert isinstance(found, FoundOpenings)
    boxes = np.array(
        sorted((box_of(o).tolist() for o in found.openings), key=lambda b: np.round(b, 1).tolist())
    )
    assert boxes.shape == LEAVES.shape
    assert np.abs(boxes - LEAVES).max() < 0.03
    depths = [o.depth.value for o in found.openings if o.depth is not None]
    assert depths and np.abs(np.array(depths) - 0.12).max() < 0.03


def test_neighbours_bring_the_noise_down_to_what_tells_a_recess():
    facade, scan = noisy_wall(0.028, rays=True)
    calm, less = smoothed(facade, scan)
    x, y, z = less.xyz.T
    wall = (x < 0.8) & (z > 0.3) & (z < 6.7)
    assert 0.005 < y[wall].std() < 0.016
    assert calm.roughness < 0.6 * facade.roughness
    assert np.array_equal(less.xyz[:, [0, 2]], scan.xyz[:, [0, 2]])


@pytest.mark.parametrize("roughness", [0.028, 0.05])
def test_the_noise_left_is_that_of_the_points_not_the_unevenness_of_the_wall(roughness):
    facade, scan = noisy_wall(0.028, rays=True)
    calm, _ = smoothed(replace(facade, roughness=roughness), scan)
    assert 0.008 < calm.roughness < 0.012


def test_a_mirrored_cloud_is_smoothed_alike():
    facade, scan = noisy_wall(0.028, rays=False, spacing=0.04)
    assert len(scan) > 20_000
    mirror = np.array([-1.0, 1.0, 1.0])
    other = smoothed(facade, replace(scan, xyz=scan.xyz * mirror))[1]
    assert np.abs(other.xyz * mirror - smoothed(facade, scan)[1].xyz).max() < 1e-9


@pytest.mark.parametrize(("noise", "roughness"), [(0.008, 0.008), (0.004, 0.03)])
def test_a_quiet_cloud_stays_as_it_is_however_uneven_its_wall(noise, roughness):
    facade, scan = noisy_wall(noise, rays=True, spacing=0.08)
    uneven = replace(facade, roughness=roughness)
    assert smoothed(uneven, scan) == (uneven, scan)
