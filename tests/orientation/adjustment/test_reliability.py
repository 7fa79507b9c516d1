"""Blunders, variance components, detectable errors and check points."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.orientation.adjustment import AdjustmentOptions, adjust, check_points, split_control
from orientation.adjustment.blocks import SIGMA_CONTROL, SIGMA_PX, facade_block


@pytest.mark.parametrize("loss", ["cauchy", "huber", "none"])
def test_a_blunder_of_20_sigmas_is_removed_and_nothing_else(loss):
    network = facade_block(20).network
    row = 123
    pixels = network.images.pixels.copy()
    pixels[row] += [14.0 * SIGMA_PX, -14.0 * SIGMA_PX]
    found = adjust(
        replace(network, images=replace(network.images, pixels=pixels)), AdjustmentOptions(loss=loss)
    )
    np.testing.assert_array_equal(np.flatnonzero(found.rejected), [row])
    assert not found.surface_rejected.any() and not found.used[row] and np.isnan(found.redundancy[row]).all()
    assert np.linalg.norm(found.residuals[row]) == pytest.approx(20 * SIGMA_PX, rel=0.3)


def test_a_wrong_control_coordinate_is_removed():
    network = facade_block(21, control=15).network
    at = network.surfaces.at.copy()
    at[6] += 0.2 * network.surfaces.direction[6]
    found = adjust(replace(network, surfaces=replace(network.surfaces, at=at)))
    np.testing.assert_array_equal(np.flatnonzero(found.surface_rejected), [6])
    assert abs(found.surface_residuals[6]) == pytest.approx(0.2, abs=0.03)


def test_surfaces_may_be_the_only_observations_that_are_put_aside():
    network = facade_block(21, control=15, noise=0.2).network
    at = network.surfaces.at.copy()
    at[6] += 0.2 * network.surfaces.direction[6]
    # Standard errors are five times the noise, and stay so: no image point is far off.
    stated = AdjustmentOptions(variance_components=False)
    found = adjust(replace(network, surfaces=replace(network.surfaces, at=at)), stated)
    assert not found.rejected.any()
    np.testing.assert_array_equal(np.flatnonzero(found.surface_rejected), [6])


def test_five_percent_of_mismatches_are_removed():
    block = facade_block(22, photos=10, points=300)
    rng = np.random.default_rng(0)
    images = block.network.images
    wrong = rng.random(len(images)) < 0.05
    pixels = images.pixels + np.where(wrong[:, None], rng.uniform(-60, 60, images.pixels.shape), 0.0)
    found = adjust(replace(block.network, images=replace(images, pixels=pixels)))
    large = np.linalg.norm(pixels - images.pixels, axis=1) > 10 * SIGMA_PX
    assert found.used[large & wrong].mean() < 0.05
    judged = found.used | found.rejected
    assert found.rejected[judged & ~wrong].mean() < 0.005
    assert 0.85 < found.factors[0] < 1.15


@pytest.mark.parametrize("loss", ["cauchy", "none"])
def test_a_wrong_stated_sigma_is_recovered(loss):
    network = facade_block(23, photos=10, points=200, control=40, sigma_px=SIGMA_PX / 2).network
    found = adjust(network, AdjustmentOptions(loss=loss))
    assert np.sqrt(found.factors[0]) == pytest.approx(2.0, rel=0.1)
    assert np.sqrt(found.factors[1]) == pytest.approx(1.0, rel=0.25)
    assert found.sigma0 == pytest.approx(1.0, abs=0.05)
    assert found.rejected.sum() <= 2
    kept = adjust(network, AdjustmentOptions(variance_components=False, snooping=False, loss="none"))
    assert kept.sigma0 == pytest.approx(2.0, rel=0.1) and (kept.factors == 1).all()
    right = adjust(facade_block(23, photos=10, points=200, control=40).network)
    np.testing.assert_allclose(found.poses[0].sigma, right.poses[0].sigma, rtol=0.1)


def test_a_bias_of_the_detectable_size_is_mostly_found():
    network = facade_block(24).network
    clean = adjust(network)
    row = int(np.flatnonzero(clean.redundancy[:, 0] > 0.5)[3])
    found = 0
    for k in range(12):
        pixels = network.images.pixels.copy()
        pixels[row] = clean.residuals[row] + pixels[row]  # an observation without error
        pixels[row, 0] += (1.3 if k % 2 else -1.3) * clean.detectable_bias[row, 0]
        pixels[row] += 0.3 * SIGMA_PX * np.array([np.cos(k), np.sin(k)])
        found += adjust(replace(network, images=replace(network.images, pixels=pixels))).rejected[row]
    assert found >= 9
    assert (clean.detectable_bias[clean.used] >= 4.8 * SIGMA_PX * 0.9).all()


def test_robust_weights_can_be_kept():
    network = facade_block(25).network
    pixels = network.images.pixels.copy()
    pixels[10:20] += 40.0
    wrong = replace(network, images=replace(network.images, pixels=pixels))
    found = adjust(wrong, AdjustmentOptions(least_squares=False))
    clean = adjust(network)
    assert not found.rejected.any()
    moved = np.array([a.value.t - b.value.t for a, b in zip(found.poses, clean.poses, strict=True)])
    assert np.abs(moved / np.array([p.sigma[:3] for p in clean.poses])).max() < 1.0
    assert found.poses[0].sigma == pytest.approx(clean.poses[0].sigma, rel=0.35)


def test_losses_by_group():
    network = facade_block(26, control=15).network
    at = network.surfaces.at.copy()
    at[6] += 0.2 * network.surfaces.direction[6]
    wrong = replace(network, surfaces=replace(network.surfaces, at=at))
    options = AdjustmentOptions(losses={1: "none"}, snooping=False)
    assert not adjust(wrong, options).surface_rejected.any()
    assert options.loss_of(0) == "cauchy" and options.loss_of(1) == "none"


def test_check_points_agree_with_their_sigmas():
    squares, differences = [], []
    for seed in range(8):
        network = facade_block(seed + 40, control=30).network
        rest, left_out = split_control(network, 0.3, seed)
        assert len(left_out) == 27 and len(rest.surfaces) == 63
        checked = check_points(adjust(rest), left_out)
        assert len(checked.point) == 9 and checked.missing == 0
        squares.append(checked.squared_error)
        differences.append(checked.rmse)
    assert 0.75 < np.concatenate(squares).mean() / 3 < 1.3
    assert 0.003 < np.mean(differences) < 0.02 and SIGMA_CONTROL == 0.005
    assert checked.normalised == pytest.approx(checked.squared_error.mean() / 3)
    nothing = check_points(adjust(rest), left_out.take(np.zeros(27, bool)))
    assert np.isnan(nothing.normalised) and np.isnan(nothing.rmse).all()


def test_the_split_of_control_follows_its_seed():
    network = facade_block(27).network
    a, b, c = (split_control(network, 0.25, seed)[1].point for seed in (1, 1, 2))
    np.testing.assert_array_equal(a, b)
    assert len(a) == len(c) == 9 and set(a) != set(c)


def test_a_group_whose_standard_errors_are_known_keeps_them():
    network = facade_block(23).network
    group = int(network.surfaces.group[0])
    wide = replace(network, surfaces=replace(network.surfaces, sigma=5 * network.surfaces.sigma))
    estimated = adjust(wide, AdjustmentOptions(least_redundancy=5))
    known = adjust(wide, AdjustmentOptions(least_redundancy=5, known=frozenset({group})))
    assert estimated.factors[group] < 0.2
    assert known.factors[group] == 1.0
    assert known.factors[0] == pytest.approx(estimated.factors[0], rel=0.05)
