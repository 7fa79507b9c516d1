"""The estimators: LO-RANSAC, IRLS, covariance of correlated residuals."""

import numpy as np
import pytest
from scipy import ndimage

from frontage.facades.build import pose_covariance
from frontage.facades.plane.robust import densest_layer
from frontage.facades.plane.search import FreeWalls, UprightWalls
from frontage.geometry.plane import facade_axes, fit_plane
from frontage.solve.correlation import fit_covariance, residual_correlation
from frontage.solve.ransac import lo_ransac, needed_hypotheses
from frontage.solve.robust import irls, mad_sigma, tukey_response, tukey_weights
from proofs import assert_invariant, assert_jacobian


def test_needed_hypotheses_are_the_textbook_numbers():
    assert needed_hypotheses(0.3, 2, 0.99) == pytest.approx(49, abs=1)
    assert needed_hypotheses(0.1, 3, 0.99) == pytest.approx(4603, abs=2)


@pytest.mark.parametrize("upright", [True, False])
def test_lo_ransac_finds_a_plane_among_outliers(upright):
    rng = np.random.default_rng(0)
    wall = np.column_stack([rng.uniform(-5, 5, 600), rng.normal(2, 0.005, 600), rng.uniform(0, 6, 600)])
    xyz = np.vstack([wall, rng.uniform([-5, -5, 0], [5, 5, 6], (900, 3))])
    walls = UprightWalls(xyz, np.ones(len(xyz))) if upright else FreeWalls(xyz, 0.2)
    found = lo_ransac(walls, 0.02, rng)
    assert found is not None
    assert abs(found.model[1]) > 0.9999 and abs(abs(found.model[3]) - 2) < 0.002
    assert 0.38 < found.share < 0.45


def test_irls_ignores_a_parallel_layer():
    rng = np.random.default_rng(1)
    x = rng.uniform(-5, 5, 3000)
    y = 0.1 + 0.02 * x + rng.normal(0, 0.005, 3000)
    y[:1000] += 0.05
    design = np.column_stack([np.ones(3000), x])
    fit = irls(design, y, np.ones(3000), sigma_floor=1e-4, start=np.array([0.1, 0.02]), sigma_start=0.006)
    assert np.abs(fit.parameters - [0.1, 0.02]).max() < 0.0006
    assert 0.0045 < fit.sigma < 0.0056


def test_mad_sigma_of_nothing_is_nan():
    assert np.isnan(mad_sigma(np.empty(0)))


@pytest.mark.parametrize("length", [0.0, 3.0])
def test_covariance_of_the_mean_matches_its_scatter(length):
    means, told = [], []
    for seed in range(60):
        field = np.random.default_rng(seed).normal(0, 1, (90, 120))
        field = ndimage.gaussian_filter(field, length, mode="wrap") if length else field
        known = np.ones(field.shape, bool)
        correlation = residual_correlation(field, known, 0.1)
        design = np.ones((*field.shape, 1))
        means.append(field.mean())
        told.append(fit_covariance(design, known, correlation)[0, 0])
    assert 0.5 < np.mean(np.square(means)) / np.mean(told) < 2.0


def test_correlation_is_measured_up_to_half_of_the_wall():
    """Bulges correlated over 1.5 m on a wall of 6 x 6 m: a quarter of its side holds half of their reach."""
    field = ndimage.gaussian_filter(np.random.default_rng(1).normal(0, 1, (60, 60)), 7.5)
    correlation = residual_correlation(field, np.ones(field.shape, bool), 0.1)
    assert 15 < len(correlation.covariance) <= 31
    assert correlation.length > 1.5


def test_facade_axes_follow_the_paper():
    phi, psi = 2.1, 1.5
    y = np.array([np.cos(phi) * np.sin(psi), np.sin(phi) * np.sin(psi), np.cos(psi)])
    X, Y, Z = facade_axes(y).T
    assert np.allclose(X, [np.sin(phi), -np.cos(phi), 0]) and np.allclose(Y, y)
    assert np.allclose(Z, [-np.cos(phi) * np.cos(psi), -np.sin(phi) * np.cos(psi), np.sin(psi)])


def test_a_horizontal_plane_has_no_facade_axes():
    with pytest.raises(ValueError, match="horizontal"):
        facade_axes(np.array([0.0, 0.0, 1.0]))


def test_plane_thickness_does_not_depend_on_the_world():
    xyz = np.random.default_rng(0).normal(0, [3, 0.01, 2], (500, 3))
    assert_invariant(lambda p: fit_plane(p)[2], xyz, 1e-8)


def test_pose_covariance_has_the_right_signs():
    def normal(turn):  # Y of the frame after small turns about X and Z, by its slopes a = -Y_x, b = -Y_z
        wx, wz = turn
        return np.array([wz, -wx])  # y = c + a x + b z

    assert_jacobian(normal, np.array([[0.0, 1.0], [-1.0, 0.0]]), np.zeros(2))
    plane = np.diag([1.0, 4.0, 9.0]) + 0.5
    pose = pose_covariance(plane)
    assert pose[1, 1] == 1.5 and pose[5, 5] == 4.5 and pose[3, 3] == 9.5 and pose[3, 5] == -0.5


def test_tukey_response_is_the_derivative_of_the_influence():
    r = np.linspace(-0.03, 0.03, 7)
    assert_jacobian(lambda v: v * tukey_weights(v, 0.005), np.diag(tukey_response(r, 0.005)), r)


def test_start_is_the_densest_layer_not_the_middle_of_two():
    rng = np.random.default_rng(0)
    offsets = np.concatenate([rng.normal(-0.03, 0.003, 6000), rng.normal(0.03, 0.003, 4000)])
    centre, sigma = densest_layer(offsets, 0.1, 0.0005)
    assert abs(centre + 0.03) < 0.001 and 0.0025 < sigma < 0.0035
