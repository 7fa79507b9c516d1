"""The adjustment against Ceres: the same solution and the same marginal covariances."""

import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3, quaternion_from_rotation, rotation_from_quaternion
from frontage.orientation.adjustment import AdjustmentOptions, adjust
from orientation.adjustment.blocks import SIGMA_CONTROL, facade_block, pose_error

pyceres = pytest.importorskip("pyceres")
pycolmap = pytest.importorskip("pycolmap")

PLAIN = AdjustmentOptions(loss="none", snooping=False, variance_components=False)


def _ceres_pose(pose):
    """The seven parameters (x, y, z, w, t) of camera_from_local for a pose local_from_camera."""
    inverse = pose.inverse
    w, x, y, z = quaternion_from_rotation(inverse.R)
    return np.array([x, y, z, w, *inverse.t])


def _own_pose(parameters):
    x, y, z, w = parameters[:4]
    R = rotation_from_quaternion(np.array([w, x, y, z]))
    return Rigid3("camera", "local", R, parameters[4:]).inverse


class UnitQuaternion(pyceres.CostFunction):
    """Holds the length of the quaternion, since the binding has no manifold for a whole pose."""

    def __init__(self):
        super().__init__()
        self.set_num_residuals(1)
        self.set_parameter_block_sizes([7])

    def Evaluate(self, parameters, residuals, jacobians):
        q = parameters[0][:4]
        residuals[0] = 1e7 * (q @ q - 1.0)
        if jacobians is not None:
            jacobians[0][:] = 2e7 * np.array([*q, 0.0, 0.0, 0.0])
        return True


def _problem(network, poses, points, params):
    from pycolmap.cost_functions import ReprojErrorCost

    problem = pyceres.Problem()
    images, model = network.images, getattr(pycolmap.CameraModelId, network.cameras[0].model)
    for photo, point, pixel, sigma in zip(
        images.photo, images.point, images.pixels, images.sigma, strict=True
    ):
        cost = ReprojErrorCost(model, np.eye(2) * sigma**2, pixel)
        problem.add_residual_block(cost, None, [points[point], poses[photo], params])
    for pose in poses:
        problem.add_residual_block(UnitQuaternion(), None, [pose])
    control = network.surfaces
    for point in np.unique(control.point):
        mine = control.point == point
        prior = pyceres.factors.NormalPrior(control.at[mine][0], np.eye(3) * SIGMA_CONTROL**2)
        problem.add_residual_block(prior, None, [points[point]])
    return problem


@pytest.mark.parametrize("calibrated", [True, False])
def test_solution_and_marginal_covariances_are_those_of_ceres(calibrated):
    sigmas = () if calibrated else (np.full(4, np.inf),)
    network = facade_block(seed=4, photos=6, points=60, control=12, share=1.0, camera_sigmas=sigmas).network
    found = adjust(network, PLAIN)
    # Ceres starts from our solution so that the gauge of the quaternions is exact there.
    poses = [_ceres_pose(p.value) for p in found.poses]
    points, params = [p.copy() for p in found.points], found.cameras[0].value.params.copy()
    problem = _problem(network, poses, points, params)
    if calibrated:
        problem.set_parameter_block_constant(params)
    options, summary = pyceres.SolverOptions(), pyceres.SolverSummary()
    options.max_num_iterations, options.function_tolerance = 50, 1e-14
    options.logging_type = pyceres.LoggingType.SILENT
    pyceres.solve(options, problem, summary)
    for pose, own in zip(poses, found.poses, strict=True):
        assert np.abs(pose_error(_own_pose(pose), own.value) / own.sigma).max() < 1e-4
    assert np.abs((np.array(points) - found.points) / found.sigma_points).max() < 1e-4

    covariance = pyceres.Covariance(pyceres.CovarianceOptions())
    own_params = [] if calibrated else [params]
    blocks = [*poses, *points, *own_params]
    assert covariance.compute([(b, b) for b in blocks], problem)
    for pose, own in zip(poses, found.poses, strict=True):
        change = np.stack(
            [
                (pose_error(_own_pose(pose + h), own.value) - pose_error(_own_pose(pose - h), own.value))
                / 2e-6
                for h in 1e-6 * np.eye(7)
            ],
            -1,
        )
        expected = change @ covariance.get_covariance_block(pose, pose) @ change.T
        scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        assert np.abs((own.covariance - expected) / scale).max() < 1e-4
    for point, own in zip(points, found.point_covariance, strict=True):
        expected = covariance.get_covariance_block(point, point)
        assert np.abs(own - expected).max() < 1e-4 * np.abs(expected).max()
    if not calibrated:
        expected = covariance.get_covariance_block(params, params)
        np.testing.assert_allclose(found.cameras[0].covariance, expected, rtol=1e-4, atol=1e-4)
