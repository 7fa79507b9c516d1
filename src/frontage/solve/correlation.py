"""Correlated residuals on a raster: autocovariance, effective sample size, covariance of a linear fit.

The residuals of a wall are mostly its own roughness, which is correlated over decimetres, so a million points
do not give an accuracy of micrometres. The empirical autocovariance c(h) of the gridded residuals (their
variogram is c(0) - c(h)) is propagated exactly through the fit by FFT:
``C = N^-1 (sum_ij a_i a_j^T c(i - j)) N^-1`` with ``N = sum_i a_i a_i^T``.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import fft

from frontage.geometry.arrays import Array, Bool, Float


@dataclass(frozen=True, eq=False)
class Correlation:
    """The isotropic autocovariance of gridded residuals.

    covariance  (k,) at distances 0, 1, 2, ... cells; zero from k on
    cell        m
    area        m2, integral of the correlation over the plane: the area that one independent value represents
    """

    covariance: Float
    cell: float
    area: float

    @property
    def length(self) -> float:
        """Correlation length in m: the side of the square that one independent value represents."""
        return float(np.sqrt(self.area))

    def raised(self, variance: float) -> "Correlation":
        """Adds `variance`, which a fit removed from the residuals, at every distance."""
        return replace(self, covariance=self.covariance + variance)


def _padded(shape: tuple[int, int], reach: int) -> tuple[int, int]:
    rows, columns = (int(fft.next_fast_len(s + reach, real=True)) for s in shape)
    return rows, columns


def _lag_radius(shape: tuple[int, int]) -> Array:
    """Distance (h, w) in cells, rounded, of every circular lag of a padded raster."""
    down, right = (np.minimum(np.arange(s), s - np.arange(s)) for s in shape)
    return np.rint(np.hypot(down[:, None], right[None, :])).astype(np.int64)


def residual_correlation(residual: Float, known: Bool, cell: float) -> Correlation:
    """Estimates the autocovariance of `residual` (h, w) where `known` (h, w) bool; cells are `cell` m wide.

    Distances go up to half of the shorter side, because walls bulge over metres. The table ends where the
    covariance first falls below twice its own sampling error, beyond which it is noise.
    """
    lags = max(min(residual.shape) // 2, 2)
    shape = _padded(residual.shape, lags)
    count = known.sum()
    values = np.where(known, residual - residual[known].mean(), 0.0)
    products = fft.irfft2(np.abs(fft.rfft2(values, shape)) ** 2, shape)
    pairs = fft.irfft2(np.abs(fft.rfft2(known.astype(np.float64), shape)) ** 2, shape)
    radius = _lag_radius(shape).ravel()
    use = radius <= lags
    summed = np.bincount(radius[use], products.ravel()[use], lags + 1)
    number = np.maximum(np.rint(np.bincount(radius[use], pairs.ravel()[use], lags + 1)), 1.0)
    covariance = summed / number
    # Each unordered pair of cells appears twice in `number`.
    noise = 2.0 * covariance[0] / np.sqrt(number / 2.0)
    below = np.flatnonzero(covariance[1:] < noise[1:])
    end = 1 + int(below[0]) if len(below) else lags + 1
    ring = np.bincount(radius[use], minlength=lags + 1)[:end]
    ratio = covariance[:end] / max(covariance[0], 1e-300)
    area = float(min((ring * ratio).sum(), count) * cell**2)
    return Correlation(np.ascontiguousarray(covariance[:end]), cell, max(area, cell**2))


def fit_covariance(design: Float, known: Bool, correlation: Correlation) -> Float:
    """Returns the covariance (p, p) of an unweighted linear fit to correlated values on a raster.

    design  (h, w, p), the row of the design matrix of every cell; used only where `known` (h, w)
    """
    rows, columns, p = design.shape
    table = correlation.covariance
    shape = _padded((rows, columns), len(table))
    radius = _lag_radius(shape)
    kernel = np.where(radius < len(table), np.append(table, 0.0)[np.minimum(radius, len(table))], 0.0)
    fields = [np.where(known, design[..., k], 0.0) for k in range(p)]
    spectrum = fft.rfft2(kernel, shape)
    smoothed = [fft.irfft2(fft.rfft2(f, shape) * spectrum, shape)[:rows, :columns] for f in fields]
    middle = np.array([[float((f * s).sum()) for s in smoothed] for f in fields])
    normal = np.array([[float((f * g).sum()) for g in fields] for f in fields])
    inverse = np.linalg.pinv(normal)
    # The truncated table may not be positive definite: the result is at least that of independent cells.
    covariance = inverse @ (0.5 * (middle + middle.T)) @ inverse
    return _at_least(covariance, table[0] * inverse)


def _at_least(covariance: Float, floor: Float) -> Float:
    """Raises `covariance` so that it is not smaller than `floor` in any direction."""
    values, vectors = np.linalg.eigh(floor)
    root = vectors * np.sqrt(np.maximum(values, 1e-300))
    back = (vectors / np.sqrt(np.maximum(values, 1e-300))).T
    spread, axes = np.linalg.eigh(back @ covariance @ back.T)
    turned = root @ axes
    return np.asarray((turned * np.maximum(spread, 1.0)) @ turned.T, np.float64)
