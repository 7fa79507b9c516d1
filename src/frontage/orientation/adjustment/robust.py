"""The weights of the first, robust phase: Huber and Cauchy losses at a scale taken from the residuals."""

import numpy as np
from scipy.special import ndtr

from frontage.geometry.arrays import Bool, Float
from frontage.orientation.adjustment.layout import Layout
from frontage.orientation.adjustment.linearise import Residuals, Weights
from frontage.orientation.adjustment.minimise import Reweight, squared
from frontage.orientation.adjustment.network import Network
from frontage.orientation.adjustment.options import AdjustmentOptions

_HUBER, _CAUCHY = 1.345, 2.385  # 95 % efficiency for Gaussian residuals
_MEDIAN_2D, _MEDIAN_1D = 1.1774, 0.6745  # medians of the length of a Gaussian vector and of a |Gaussian|
_ENOUGH = 20  # observations from which a robust scale is estimated
_LEAST_FACTOR = 1e-8  # of a variance, for data without noise


def plain_weights(network: Network, layout: Layout, factors: Float) -> Weights:
    """Weights of least squares for the rows of a layout; `factors` (g,) scale the variances of the groups."""
    root = np.sqrt(factors)
    images, surfaces = np.zeros(len(network.images)), np.zeros(len(network.surfaces))
    rows, others = layout.rows, layout.surface_rows
    images[rows] = 1.0 / (network.images.sigma[rows] * root[network.images.group[rows]])
    surfaces[others] = 1.0 / (network.surfaces.sigma[others] * root[network.surfaces.group[others]])
    return Weights(images, surfaces)


def least_squares(layout: Layout, weights: Weights) -> Reweight:
    """Weights that stay as they are."""
    return lambda at: (weights, float(squared(layout, at, weights).sum()))


def robust(network: Network, layout: Layout, factors: Float, options: AdjustmentOptions) -> Reweight:
    """Weights that follow the losses of the groups, scaled by the square roots of `factors` (g,)."""
    base = plain_weights(network, layout, factors)
    group = np.concatenate([network.images.group[layout.rows], network.surfaces.group[layout.surface_rows]])
    losses = {
        loss: np.isin(group, [g for g in range(network.groups) if options.loss_of(g) == loss])
        for loss in ("huber", "cauchy")
    }

    def reweight(at: Residuals) -> tuple[Weights, float]:
        z = squared(layout, at, base)
        weight, cost = np.ones(len(z)), z.copy()
        for loss, mine in losses.items():
            weight[mine], cost[mine] = _loss(loss, z[mine])
        images, surfaces = base.images.copy(), base.surfaces.copy()
        images[layout.rows] *= np.sqrt(weight[: len(layout.rows)])
        surfaces[layout.surface_rows] *= np.sqrt(weight[len(layout.rows) :])
        return Weights(images, surfaces), float(cost.sum())

    return reweight


def _loss(loss: str, z: Float) -> tuple[Float, Float]:
    """Weights and costs of squared residuals in sigmas."""
    if loss == "cauchy":
        return 1.0 / (1.0 + z / _CAUCHY**2), _CAUCHY**2 * np.log1p(z / _CAUCHY**2)
    length = np.sqrt(np.maximum(z, 1e-300))
    far = length > _HUBER
    return np.where(far, _HUBER / length, 1.0), np.where(far, 2 * _HUBER * length - _HUBER**2, z)


def scales(network: Network, layout: Layout, at: Residuals, options: AdjustmentOptions) -> Float:
    """Variance factors (g,) of the groups from the medians of their residuals.

    Where variances are not to be estimated, and in small groups, a factor is at least one: it only widens
    the loss while the approximate values are poor.
    """
    z = np.sqrt(squared(layout, at, plain_weights(network, layout, np.ones(network.groups))))
    count = len(layout.rows)
    rows = 2 * count + len(layout.surface_rows)
    # Residuals are smaller than errors by the share of the redundancy.
    share = max(1.0 - (layout.columns + 3 * len(layout.points)) / max(rows, 1), 0.05)
    factors, estimated = np.ones(network.groups), options.estimates(network.groups)
    parts = (
        (network.images.group[layout.rows], z[:count], _MEDIAN_2D, share),
        (network.surfaces.group[layout.surface_rows], z[count:], _MEDIAN_1D, 1.0),
    )
    for groups, lengths, median, redundancy in parts:
        for group in np.unique(groups):
            mine = lengths[groups == group]
            factor = float(np.median(mine) / median) ** 2 / redundancy
            trusted = estimated[group] and len(mine) >= _ENOUGH and median == _MEDIAN_2D
            factors[group] = max(factor, _LEAST_FACTOR if trusted else 1.0)
    return factors


def within(network: Network, at: Residuals, factors: Float, limit: float) -> tuple[Bool, Bool]:
    """Which observations (m,), (k,) lie within `limit` sigmas of a single normal variable; unseen do not."""
    root = np.sqrt(factors)
    sigma = network.images.sigma * root[network.images.group]
    with np.errstate(invalid="ignore"):
        images = (at.images**2).sum(axis=1) <= (limit_2d(limit) * sigma) ** 2
    surfaces = np.abs(at.surfaces) <= limit * network.surfaces.sigma * root[network.surfaces.group]
    return images, surfaces


def limit_2d(limit: float) -> float:
    """The length of a Gaussian vector of two components that is exceeded as rarely as `limit` by one."""
    # The square of the length is exponentially distributed with mean 2.
    return float(np.sqrt(-2.0 * np.log(2.0 * ndtr(-limit))))
