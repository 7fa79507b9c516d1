"""Observations that were put aside, tested against what the others predict.

A residual may be large although the observation is good, because the others determine its point poorly. The
test therefore uses the variance of the difference: of the observation and of its prediction together.
"""

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int
from frontage.orientation.adjustment.covariance import image_variance
from frontage.orientation.adjustment.fit import Fit
from frontage.orientation.adjustment.layout import Layout, layout_of
from frontage.orientation.adjustment.linearise import linearise
from frontage.orientation.adjustment.network import Network
from frontage.orientation.adjustment.normal import inverse_blocks
from frontage.orientation.adjustment.robust import limit_2d, plain_weights


def agreeing(
    network: Network, fit: Fit, images: Bool, surfaces: Bool, factors: Float, limit: float
) -> tuple[Int, Int]:
    """The image rows and surface rows among those not in use that the others predict within `limit` sigmas.

    images (m,), surfaces (k,): which are in use; factors (g,) scale their variances. Rows of points
    that are not adjusted cannot be tested.
    """
    determined = np.zeros(len(network.points), bool)
    determined[fit.layout.points] = True
    seen = np.isfinite(fit.minimum.residuals.images).all(axis=1)
    away = layout_of(network, ~images & seen, ~surfaces, determined)
    place = np.zeros(len(network.points), np.int64)
    place[fit.layout.points] = np.arange(len(fit.layout.points))
    slots = place[away.points]
    weights = plain_weights(network, away, factors)
    rows = linearise(network, fit.minimum.state, away, weights, fit.minimum.residuals)
    points = fit.precision.points[slots]
    along = _coupled(fit, away, slots)
    total = np.eye(2) + image_variance(away, rows, fit.precision.wide, points, along)
    squares = np.einsum("mi,mij,mj->m", rows.miss, np.linalg.inv(total), rows.miss)
    spread = 1.0 + np.einsum("ki,kij,kj->k", rows.surface, points[away.surface_slot], rows.surface)
    good = squares <= limit_2d(limit) ** 2
    return away.rows[good], away.surface_rows[rows.surface_miss**2 <= limit**2 * spread]


def _coupled(fit: Fit, away: Layout, slots: Int) -> Float:
    """``Z Q`` of the points of the rows that are away, in the columns (r, 3, k) of their photos."""
    wanted, position = np.unique(away.slot, return_inverse=True)
    W = fit.equations.coupling(slots[wanted])
    inverse = inverse_blocks(fit.equations.V[slots[wanted]])
    Z = (inverse @ W).reshape(-1, fit.layout.columns)
    across = np.zeros((len(wanted), 3, fit.layout.columns + 1))
    across[:, :, :-1] = (Z @ fit.precision.wide).reshape(len(wanted), 3, fit.layout.columns)
    columns = away.photo_columns[away.photo]
    picked = across[position[:, None, None], np.arange(3)[:, None], columns[:, None, :]]
    return np.asarray(picked, np.float64)
