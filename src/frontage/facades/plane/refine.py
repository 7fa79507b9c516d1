"""Refine a wall plane on all points near it, and estimate its covariance."""

from dataclasses import dataclass

import numpy as np

from frontage.facades.cells import CellMap
from frontage.facades.cloud import Slab
from frontage.facades.plane.means import cell_means, measuring_station, station_covariance
from frontage.facades.plane.robust import robust_fit
from frontage.facades.plane.wall import INLIER_SIGMAS, WallPlane
from frontage.facades.scene import FacadeScene
from frontage.geometry.arrays import Float, Int
from frontage.solve.robust import TUKEY, tukey_response, tukey_weights

_MOST_SAMPLED = 20_000  # points that determine direction and scale; the last step takes all
_FEWEST = 10  # points of a wall
_LEAST_REACH_M = 0.10  # m from the plane within which points take part


@dataclass(frozen=True, eq=False)
class _RobustFit:
    """A robust fit in the frame of a slab, with the points that took part.

    plane     (3,) = (c, a, b) of y = c + a x + b z, m and rad
    sigma     m
    places    (n,) int64 into Slab.rows
    q         (n, 3) m, coordinates of these points; `residual` (n,) m about the plane
    """

    plane: Float
    sigma: float
    places: Int
    q: Float
    residual: Float


def refine_wall(
    slab: Slab, region: CellMap, scene: FacadeScene, rng: np.random.Generator
) -> WallPlane | None:
    """Fits a wall to all points of `slab` near its plane and within `region` (in the slab's frame).

    A sample determines direction and scale. The last step is least squares on the means of all inliers per
    cell, so that equal areas count equally at any density. Returns None when fewer than ten points remain.
    """
    cloud = scene.cloud
    near = np.abs(slab.q[:, 1]) < max(2.0 * cloud.threshold, _LEAST_REACH_M)
    near &= region.within(slab.q[:, 0], slab.q[:, 2])
    places = np.flatnonzero(near)
    if len(places) < _FEWEST:
        return None
    q = slab.at(places)
    sample = q if len(q) <= _MOST_SAMPLED else q[rng.integers(0, len(q), _MOST_SAMPLED)]
    weights = 1.0 / _points_in_cell(sample[:, 0], sample[:, 2], cloud.raster)
    plane, sigma = robust_fit(sample, weights, cloud.threshold, np.zeros(3))
    residual = q[:, 1] - (plane[0] + plane[1] * q[:, 0] + plane[2] * q[:, 2])
    return _last_step(slab, _RobustFit(plane, sigma, places, q, residual), scene)


def _points_in_cell(x: Float, z: Float, cell: float) -> Float:
    """Returns how many points (n,) share each point's cell of `cell` m."""
    column = ((x - x.min()) / cell).astype(np.int64)
    row = ((z - z.min()) / cell).astype(np.int64)
    flat = row * (int(column.max()) + 1) + column
    return np.asarray(np.bincount(flat)[flat], np.float64)


def _last_step(slab: Slab, start: _RobustFit, scene: FacadeScene) -> WallPlane | None:
    """Takes one step on the cell means of all points, then estimates covariance and applies the lean's prior.

    The covariance refers to the barycentre of the inliers, the origin of the facade frame (paper A, 2.2).
    """
    near = np.flatnonzero(np.abs(start.residual) < TUKEY * start.sigma)
    if len(near) < _FEWEST:
        return None
    x, z, r = start.q[near, 0], start.q[near, 2], start.residual[near]
    weights, gain = _newton(r, start.sigma)
    means = cell_means(x, z, gain * r, weights, scene.cloud.raster)
    step = means.fit()
    fit, r = start.plane + step, r - (step[0] + step[1] * x + step[2] * z)
    on = np.abs(r) < INLIER_SIGMAS * start.sigma
    if np.count_nonzero(on) < _FEWEST:
        return None
    bx, bz = float(x[on].mean()), float(z[on].mean())
    means = means.centred(step, bx, bz)
    covariance, dof = means.covariance()
    stations = measuring_station(scene.scan, scene.cloud.index[slab.rows[start.places[near]]])
    covariance = covariance + station_covariance(means, stations, weights, r, covariance)
    fit[0] += fit[1] * bx + fit[2] * bz
    if scene.options.levelled:
        fit, covariance = _lean_prior(slab.axes, fit, covariance, np.radians(scene.options.lean_sigma))
    normal = slab.axes @ np.array([-fit[1], 1.0, -fit[2]])
    return WallPlane(
        normal / np.linalg.norm(normal),
        slab.point + slab.axes @ np.array([bx, fit[0], bz]),
        start.sigma,
        INLIER_SIGMAS * start.sigma,
        covariance,
        slab.rows[start.places[near[on]]],
        dof,
    )


def _newton(r: Float, sigma: float) -> tuple[Float, float]:
    """Returns Tukey's weights (n,) of residuals (n,) m, and the factor from their step to Newton's.

    Re-weighting moves the plane by the mean of r w over the mean of w; Newton's step divides by the mean of
    (r w)' instead.
    """
    weights = tukey_weights(r, sigma)
    return weights, float(weights.sum() / max(tukey_response(r, sigma).sum(), 0.5 * weights.sum()))


def _lean_prior(axes: Float, fit: Float, covariance: Float, sigma: float) -> tuple[Float, Float]:
    """Adds the pseudo-observation that the wall is upright, with `sigma` rad, as a Kalman update."""
    upright = axes[2, 1] / max(axes[2, 2], 1e-6)  # the slope b for which the normal is horizontal
    gain = covariance[:, 2] / (covariance[2, 2] + sigma**2)
    return fit + gain * (upright - fit[2]), covariance - np.outer(gain, covariance[2])
