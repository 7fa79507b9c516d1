"""Derivatives of the projection and of the whole network against differences."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3
from frontage.model.estimate import Estimate
from frontage.model.photo import Camera
from frontage.orientation.adjustment.derivatives import by_parameters, by_point
from frontage.orientation.adjustment.layout import layout_of
from frontage.orientation.adjustment.linearise import Weights, linearise, residuals
from frontage.orientation.adjustment.network import Network
from frontage.orientation.adjustment.state import State
from orientation.adjustment.blocks import rig_block

CAMERAS = {
    "SIMPLE_PINHOLE": [1500.0, 800.0, 600.0],
    "PINHOLE": [1500.0, 1510.0, 800.0, 600.0],
    "SIMPLE_RADIAL": [1500.0, 800.0, 600.0, -0.05],
    "RADIAL": [1500.0, 800.0, 600.0, -0.05, 0.02],
    "OPENCV": [1500.0, 1510.0, 800.0, 600.0, -0.05, 0.02, 0.001, -0.002],
    "FULL_OPENCV": [1500.0, 1510.0, 800.0, 600.0, -0.05, 0.02, 0.001, -0.002, 0.01, 0.02, 0.01, 0.0],
    "OPENCV_FISHEYE": [700.0, 710.0, 800.0, 600.0, 0.02, -0.01, 0.002, 0.001],
    "THIN_PRISM_FISHEYE": [700.0, 710.0, 800.0, 600.0, 0.02, -0.01, 1e-3, 2e-3, 1e-3, 0.0, 1e-3, 2e-3],
    "FOV": [700.0, 710.0, 800.0, 600.0, 0.9],
    "SIMPLE_DIVISION": [1500.0, 800.0, 600.0, -0.05],
}


def _difference(function, x, step):
    """Richardson's extrapolation of central differences: fourth order."""

    def central(h):
        return np.stack([(function(x + h * e) - function(x - h * e)) / (2 * h) for e in np.eye(len(x))], -1)

    return (4 * central(step) - central(2 * step)) / 3


@pytest.mark.parametrize("model", CAMERAS)
def test_derivatives_of_the_projection(model):
    rng = np.random.default_rng(1)
    camera = Camera(model, 1600, 1200, np.array(CAMERAS[model]))
    xyz = rng.uniform([-2.0, -1.5, 4.0], [2.0, 1.5, 8.0], (20, 3))
    for point, found in zip(xyz, by_point(camera, xyz), strict=True):
        expected = _difference(lambda x: camera.project(x[None])[0], point, 1e-3)
        assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()
    free = np.arange(len(camera.params))
    size = np.where(np.abs(camera.params) > 10, 1.0, 1e-2)

    def scaled(shift):
        return Camera(model, 1600, 1200, camera.params + shift * size).project(xyz)

    expected = _difference(scaled, np.zeros(len(free)), 0.1) / size
    found = by_parameters(camera, xyz, free)
    assert np.abs(found - expected).max(axis=(0, 1)) == pytest.approx(0, abs=1e-6 * np.abs(expected).max())
    few = by_parameters(camera, xyz, free[[2, 0]])
    np.testing.assert_array_equal(few, found[:, :, [2, 0]])


def test_derivatives_of_a_network_with_rigs_priors_and_free_cameras():
    block = rig_block(seed=3)
    prior = Estimate(Rigid3("local", "body", np.eye(3), np.ones(3)), np.eye(6), 1.0)
    photos, some = block.network.photos, np.diag([0.0, 0.0, 0.0, 1.0, np.inf, 4.0])
    loose = (
        photos.mounts[0],
        replace(photos.mounts[1], covariance=np.eye(6) + 0.1),
        replace(photos.mounts[2], covariance=some),
    )
    network = Network(
        block.network.poses,
        block.network.cameras,
        replace(photos, mounts=loose),
        block.network.points,
        block.network.images,
        block.network.surfaces,
        tuple(prior if i == 1 else None for i in range(len(block.network.poses))),
        tuple(np.full(len(c.params), 0.1) for c in block.network.cameras),
    )
    state = State.of(network)
    everything = (np.ones(len(network.images), bool), np.ones(len(network.surfaces), bool))
    layout = layout_of(network, *everything, np.ones(len(network.points), bool))
    weights = Weights(np.ones(len(network.images)), np.ones(len(network.surfaces)))
    rows = linearise(network, state, layout, weights, residuals(network, state))
    rng = np.random.default_rng(0)
    wide = rng.standard_normal(layout.columns)
    shift = rng.standard_normal((len(layout.points), 3))
    parameters = [np.zeros(len(c.params)) for c in network.cameras]
    for i, own in enumerate(parameters):
        own[layout.free[i]] = wide[layout.camera_columns(i)]

    mounts = np.zeros((3, 6))
    for i, own in enumerate(mounts):
        own[layout.mounted[i]] = wide[layout.mount_columns(i)]

    def moved(h):
        bodies = h * wide[: 6 * layout.bodies].reshape(-1, 6)
        new = state.moved(bodies, tuple(h * p for p in parameters), h * mounts, layout.points, h * shift)
        fresh = linearise(network, new, layout, weights, residuals(network, new))
        priors = (fresh.priors[1][1], fresh.camera_miss, fresh.mount_miss)
        return np.concatenate([fresh.miss.ravel(), fresh.surface_miss, *priors])

    padded = np.append(wide, 0.0)[layout.photo_columns[layout.photo]]
    images = np.einsum("mik,mk->mi", rows.wide, padded)
    images += np.einsum("mij,mj->mi", rows.point, shift[layout.slot])
    surfaces = np.einsum("ki,ki->k", rows.surface, shift[layout.surface_slot])
    predicted = np.concatenate(
        [
            images.ravel(),
            surfaces,
            rows.priors[1][0] @ wide[6:12],
            rows.cameras * wide[layout.all_cameras],
            rows.mounts @ wide[layout.all_mounts],
        ]
    )
    expected = (moved(1e-6) - moved(-1e-6)) / 2e-6
    np.testing.assert_allclose(predicted, expected, rtol=1e-5, atol=1e-5 * np.abs(expected).max())
