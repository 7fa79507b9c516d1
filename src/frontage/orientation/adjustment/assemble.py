"""Puts the result of an adjustment together from its last minimisation."""

from typing import Any

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.model.estimate import Estimate
from frontage.model.photo import Camera
from frontage.orientation.adjustment.fit import Fit
from frontage.orientation.adjustment.network import Network
from frontage.orientation.adjustment.options import AdjustmentOptions
from frontage.orientation.adjustment.reliability import detectable_bias, group_redundancies
from frontage.orientation.adjustment.result import Adjustment


def assemble(
    network: Network,
    fit: Fit,
    images: Bool,
    surfaces: Bool,
    iterations: int,
    rounds: int,
    options: AdjustmentOptions,
) -> Adjustment:
    """The result; `images` (m,) and `surfaces` (k,) are the observations that were not removed."""
    layout, at = fit.layout, fit.minimum.residuals
    determined = _marked(layout.points, len(network.points))
    observed = np.zeros(len(network.points), bool)
    observed[network.images.point] = True
    observed[network.surfaces.point] = True
    seen = np.isfinite(at.images).all(axis=1)
    covariance = np.full((len(network.points), 3, 3), np.nan)
    covariance[layout.points] = fit.precision.points
    return Adjustment(
        poses=_poses(network, fit),
        cameras=_cameras(network, fit),
        mounts=_mounts(network, fit),
        photos=network.photos,
        points=fit.minimum.state.points,
        point_covariance=covariance,
        determined=determined,
        covariance=fit.precision.wide,
        residuals=at.images,
        surface_residuals=at.surfaces,
        used=_marked(layout.rows, len(network.images)),
        surface_used=_marked(layout.surface_rows, len(network.surfaces)),
        rejected=~images & seen,
        surface_rejected=~surfaces,
        factors=fit.factors,
        group_redundancy=group_redundancies(network, layout, fit.precision),
        sigma0=float(np.sqrt(fit.minimum.cost / fit.dof)) if fit.dof > 0 else float("nan"),
        dof=fit.dof,
        datum_defect=fit.datum.defect,
        unseen=int((~seen).sum()),
        dropped=int((observed & ~determined).sum()),
        iterations=iterations,
        rounds=rounds,
        reason=fit.minimum.reason,
        cost=fit.minimum.cost,
        **_reliability(network, fit, options),
    )


def _reliability(network: Network, fit: Fit, options: AdjustmentOptions) -> dict[str, Any]:
    """Redundancies and detectable biases of all observations and priors; NaN where not used."""
    root = np.sqrt(fit.factors)
    images = np.full((len(network.images), 2), np.nan)
    images[fit.layout.rows] = np.einsum("mii->mi", fit.precision.images)
    surfaces = np.full(len(network.surfaces), np.nan)
    surfaces[fit.layout.surface_rows] = fit.precision.surfaces
    image_sigma = (network.images.sigma * root[network.images.group])[:, None]
    surface_sigma = network.surfaces.sigma * root[network.surfaces.group]
    return {
        "redundancy": images,
        "surface_redundancy": surfaces,
        "prior_redundancy": fit.precision.priors,
        "camera_redundancy": fit.precision.cameras,
        "mount_redundancy": fit.precision.mounts,
        "detectable_bias": _bias(images, image_sigma, options),
        "surface_detectable_bias": _bias(surfaces, surface_sigma, options),
    }


def _marked(numbers: Int, count: int) -> Bool:
    marks = np.zeros(count, bool)
    marks[numbers] = True
    return marks


def _bias(redundancy: Float, sigma: Float, options: AdjustmentOptions) -> Float:
    bias = detectable_bias(redundancy, sigma, options.critical)
    return np.where(np.isnan(redundancy), np.nan, bias)


def _poses(network: Network, fit: Fit) -> tuple[Estimate[Rigid3], ...]:
    blocks = [slice(6 * b, 6 * b + 6) for b in range(len(network.poses))]
    return tuple(
        Estimate(fit.minimum.state.pose(b, like), fit.precision.wide[blocks[b], blocks[b]], fit.dof)
        for b, like in enumerate(network.poses)
    )


def _cameras(network: Network, fit: Fit) -> tuple[Estimate[Camera], ...]:
    estimates = []
    for index, camera in enumerate(fit.minimum.state.cameras):
        covariance = np.zeros((len(camera.params), len(camera.params)))
        free, columns = fit.layout.free[index], fit.layout.camera_columns(index)
        covariance[np.ix_(free, free)] = fit.precision.wide[columns, columns]
        estimates.append(Estimate(camera, covariance, fit.dof))
    return tuple(estimates)


def _mounts(network: Network, fit: Fit) -> tuple[Estimate[Rigid3], ...]:
    estimates = []
    for index, given in enumerate(network.photos.mounts):
        covariance = np.zeros((6, 6))
        free, columns = fit.layout.mounted[index], fit.layout.mount_columns(index)
        covariance[np.ix_(free, free)] = fit.precision.wide[columns, columns]
        estimates.append(Estimate(fit.minimum.state.mount(index, given.value), covariance, fit.dof))
    return tuple(estimates)
