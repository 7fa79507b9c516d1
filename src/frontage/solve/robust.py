"""Robust linear fits: scale from the median absolute deviation (MAD), Tukey's biweight, IRLS."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float

_MAD_TO_SIGMA = 1.4826
_GROWTH = 1.5  # largest factor by which the scale may exceed its start
_INSIDE = 3.0  # sigmas; truncation there changes the MAD of a Gaussian by 0.3 %
TUKEY = 4.685  # 95 % efficiency for Gaussian residuals


def mad_sigma(residuals: Float) -> float:
    """Standard deviation of the Gaussian with the same MAD, in the same unit; NaN for no residuals."""
    if len(residuals) == 0:
        return float("nan")
    return float(_MAD_TO_SIGMA * np.median(np.abs(residuals - np.median(residuals))))


def tukey_weights(residuals: Float, sigma: float) -> Float:
    """Tukey's biweight (1 - (r / 4.685 sigma)^2)^2, zero outside, in the shape of `residuals`."""
    u = np.clip(np.abs(residuals) / (TUKEY * sigma), 0.0, 1.0)
    return np.asarray((1.0 - u * u) ** 2, np.float64)


def tukey_response(residuals: Float, sigma: float) -> Float:
    """Derivative of residual times weight: (1 - u^2) (1 - 5 u^2) with u = r / 4.685 sigma; zero outside."""
    u2 = np.clip(np.abs(residuals) / (TUKEY * sigma), 0.0, 1.0) ** 2
    return np.asarray((1.0 - u2) * (1.0 - 5.0 * u2), np.float64)


def weighted_fit(design: Float, observed: Float, weights: Float) -> Float:
    """Solves the weighted normal equations of design (n, p) for (p,); minimum norm when singular."""
    weighted = design * weights[:, None]
    return np.asarray(np.linalg.lstsq(weighted.T @ design, weighted.T @ observed, rcond=None)[0], np.float64)


@dataclass(frozen=True, eq=False)
class RobustFit:
    """The result of a robust fit: parameters (p,), robust sigma, final weights (n,), number of iterations."""

    parameters: Float
    sigma: float
    weights: Float
    iterations: int


def irls(
    design: Float,
    observed: Float,
    weights: Float,
    *,
    sigma_floor: float,
    start: Float,
    sigma_start: float,
    max_iterations: int = 20,
) -> RobustFit:
    """Fits by iteratively reweighted least squares with Tukey's biweight.

    The scale is the MAD of the residuals within three times the scale, so that a parallel surface farther
    away does not widen it; it stays between `sigma_floor` and 1.5 times `sigma_start`. The iteration starts
    from `start` (p,) and `sigma_start`, which must already isolate the wanted structure.
    """
    parameters, sigma = np.asarray(start, np.float64), max(sigma_start, sigma_floor)
    factor = np.zeros(len(observed))
    step = 0
    for step in range(1, max_iterations + 1):  # noqa: B007
        residuals = observed - design @ parameters
        factor = tukey_weights(residuals, sigma)
        if np.count_nonzero(factor) <= design.shape[1]:
            break
        updated = weighted_fit(design, observed, weights * factor)
        residuals = observed - design @ updated
        near = np.abs(residuals) < _INSIDE * sigma
        new_sigma = max(_MAD_TO_SIGMA * float(np.median(np.abs(residuals[near]))), sigma_floor)
        new_sigma = min(new_sigma, _GROWTH * max(sigma_start, sigma_floor))
        moved = float(np.max(np.abs(design[near] @ (updated - parameters)), initial=0.0))
        done = moved < 1e-3 * new_sigma and abs(new_sigma - sigma) < 1e-2 * sigma
        parameters, sigma = updated, new_sigma
        if done:
            break
    return RobustFit(parameters, sigma, weights * factor, step)
