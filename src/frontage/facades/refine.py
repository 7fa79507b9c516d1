"""Refinement: robust fit y = c + a x + b z, covariance of correlated residuals, lean prior, bend test."""

from dataclasses import dataclass

import numpy as np

from frontage.facades.cells import CellMap
from frontage.facades.cloud import Cloud
from frontage.facades.options import FacadeOptions
from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.geometry.plane import facade_axes
from frontage.solve.correlation import Correlation, fit_covariance, residual_correlation
from frontage.solve.robust import TUKEY, irls, mad_sigma, tukey_weights, weighted_fit

_MOST = 150_000  # points in one fit: their mean is known to 15 um at 5 mm noise, the wall itself is not
_MOST_CELLS = 120_000  # of the residual raster
_SIGMAS = 3.0  # inliers lie within


@dataclass(frozen=True, eq=False)
class Wall:
    """A refined wall plane.

    normal, point  unit normal (3,), barycentre of the inliers (3,) m local, on the plane
    sigma          m, robust spread of the inliers; threshold m, 3 sigma
    covariance     (3, 3) of offset (m), slope along x (rad), slope along z (rad) at `point`
    inliers        (k,) int64 into Cloud.xyz
    correlation    of the residuals; dof: effective redundancy
    """

    normal: Float
    point: Float
    sigma: float
    threshold: float
    covariance: Float
    inliers: Int
    correlation: Correlation
    dof: float

    @property
    def axes(self) -> Float:
        """(3, 3), columns x, y, z: the facade frame if `normal` points into the building."""
        return facade_axes(self.normal)

    def coordinates(self, xyz: Float) -> Float:
        """Facade coordinates (n, 3) m of local points (n, 3)."""
        return np.asarray((xyz - self.point) @ self.axes, np.float64)

    def flipped(self) -> "Wall":
        """The same plane with the opposite normal."""
        sign = np.diag(
            [-1.0, 1.0, -1.0]
        )  # offset and lean change sign with y; x flips as well, so a x does not
        return Wall(
            -self.normal,
            self.point,
            self.sigma,
            self.threshold,
            sign @ self.covariance @ sign,
            self.inliers,
            self.correlation,
            self.dof,
        )


def start_sigma(offsets: Float, threshold: float, floor: float) -> tuple[float, float]:
    """Centre and robust sigma in m of the densest layer of `offsets` (n,) within `threshold`.

    The window shrinks to 3 sigma of what is inside until it settles, so parallel layers drop out.
    """
    centre, width = 0.0, threshold
    sigma = threshold / _SIGMAS
    for _ in range(12):
        inside = offsets[np.abs(offsets - centre) < width]
        if len(inside) < 3:
            break
        centre = float(np.median(inside))
        # the MAD of a Gaussian cut at 3 sigma is the MAD itself to 0.3 %
        sigma = max(mad_sigma(inside), floor)
        new = min(max(_SIGMAS * sigma, 2.0 * floor), threshold)
        if abs(new - width) < 0.02 * width:
            break
        width = new
    return centre, sigma


def refine_wall(
    cloud: Cloud,
    normal: Float,
    point: Float,
    region: CellMap | None,
    options: FacadeOptions,
    rng: np.random.Generator,
) -> Wall | None:
    """Fit the wall near the plane (normal, point) to all points within `region` (in that plane's frame).

    Returns None when fewer than ten points remain.
    """
    axes = facade_axes(normal)
    offsets = cloud.xyz @ axes[:, 1] - point @ axes[:, 1]
    reach = max(2.0 * cloud.threshold, 0.10)
    candidates = np.flatnonzero(np.abs(offsets) < reach)
    q = (cloud.xyz[candidates] - point) @ axes
    if region is not None:
        inside = region.within(q[:, 0], q[:, 2])
        candidates, q = candidates[inside], q[inside]
    if len(candidates) < 10:
        return None
    picked = q if len(q) <= _MOST else q[np.sort(rng.choice(len(q), _MOST, replace=False))]
    fit, sigma = _robust_fit(picked, cloud, cell=cloud.cell)
    residual = q[:, 1] - fit[0] - fit[1] * q[:, 0] - fit[2] * q[:, 2]
    if len(picked) < len(q):  # one last step on all points: the covariance speaks of all of them
        design = np.column_stack([np.ones(len(q)), q[:, 0], q[:, 2]])
        weights = tukey_weights(residual, sigma) / _cell_count(q[:, 0], q[:, 2], cloud.cell)
        step = weighted_fit(design, residual, weights)
        fit, residual = fit + step, residual - design @ step
    near = np.abs(residual) < _SIGMAS * sigma
    if near.sum() < 10:
        return None
    return _finish(axes, point, fit, sigma, q, residual, near, candidates, cloud, options)


def _robust_fit(q: Float, cloud: Cloud, cell: float) -> tuple[Float, float]:
    """IRLS on area-weighted points (n, 3): (c, a, b) and sigma m."""
    floor = 0.0005
    weights = 1.0 / _cell_count(q[:, 0], q[:, 2], cell)
    centre, sigma = start_sigma(q[:, 1], cloud.threshold, floor)
    fit = np.array([centre, 0.0, 0.0])
    design = np.column_stack([np.ones(len(q)), q[:, 0], q[:, 2]])
    for _ in range(
        3
    ):  # a first direction that is off by a degree smears the layer: straighten, then measure anew
        residual = q[:, 1] - design @ fit
        near = np.abs(residual) < max(2.0 * sigma, 0.5 * cloud.threshold)
        if near.sum() < 10:
            break
        fit = weighted_fit(design[near], q[near, 1], weights[near])
        shift, sigma = start_sigma(q[:, 1] - design @ fit, cloud.threshold, floor)
        fit = fit + np.array([shift, 0.0, 0.0])
    sigma = natural_sigma(q[:, 1] - design @ fit, sigma, floor)
    result = irls(design, q[:, 1], weights, floor, fit, sigma)
    return result.parameters, natural_sigma(q[:, 1] - design @ result.parameters, result.sigma, floor)


def natural_sigma(residuals: Float, sigma: float, floor: float, most: float = 0.033) -> float:
    """Sigma in m at which the MAD of what lies within Tukey's support of it is that sigma, found from below.

    A wall that waves more than its local roughness widens; a separate parallel layer does not enter.
    """
    for _ in range(20):
        inside = np.abs(residuals) < TUKEY * sigma
        new = float(np.clip(mad_sigma(residuals[inside]) if inside.any() else floor, floor, most))
        if abs(new - sigma) < 0.01 * sigma:
            return new
        sigma = new
    return sigma


def _cell_count(x: Float, z: Float, cell: float) -> Float:
    """Number (n,) of points in each point's own cell."""
    column = ((x - x.min()) / cell).astype(np.int64)
    row = ((z - z.min()) / cell).astype(np.int64)
    flat = row * (int(column.max()) + 1) + column
    return np.asarray(np.bincount(flat)[flat], np.float64)


def _finish(
    axes: Float,
    point: Float,
    fit: Float,
    sigma: float,
    q: Float,
    residual: Float,
    near: Bool,
    candidates: Int,
    cloud: Cloud,
    options: FacadeOptions,
) -> Wall:
    """Covariance at the barycentre, the lean's prior, the plane in local coordinates."""
    x, z, r = q[near, 0], q[near, 2], residual[near]
    bx, bz = float(x.mean()), float(z.mean())
    covariance, correlation, dof = _covariance(x - bx, z - bz, r, cloud)
    fit = np.array([fit[0] + fit[1] * bx + fit[2] * bz, fit[1], fit[2]])
    if options.levelled:
        fit, covariance = _lean_prior(axes, fit, covariance, np.radians(options.lean_sigma))
    barycentre = point + axes @ np.array([bx, fit[0], bz])
    normal = axes @ np.array([-fit[1], 1.0, -fit[2]])
    normal /= np.linalg.norm(normal)
    return Wall(normal, barycentre, sigma, _SIGMAS * sigma, covariance, candidates[near], correlation, dof)


def _lean_prior(axes: Float, fit: Float, covariance: Float, sigma: float) -> tuple[Float, Float]:
    """One pseudo-observation 'the wall is upright' with its sigma rad, as a Kalman update."""
    upright = axes[2, 1] / max(axes[2, 2], 1e-6)  # the slope b for which the normal is horizontal
    gain = covariance[:, 2] / (covariance[2, 2] + sigma**2)
    return fit + gain * (upright - fit[2]), covariance - np.outer(gain, covariance[2])


def _covariance(x: Float, z: Float, r: Float, cloud: Cloud) -> tuple[Float, Correlation, float]:
    """Covariance (3, 3) of (c, a, b) from residuals r (n,) at (x, z), on a raster of cell means."""
    cell = cloud.cell
    while (np.ptp(x) / cell + 1) * (np.ptp(z) / cell + 1) > _MOST_CELLS:
        cell *= 2.0
    column, row = ((v - v.min()) / cell for v in (x, z))
    h, w = int(row.max()) + 1, int(column.max()) + 1
    flat = row.astype(np.int64) * w + column.astype(np.int64)
    count: Array = np.bincount(flat, minlength=h * w).reshape(h, w)
    mean = np.bincount(flat, r, minlength=h * w).reshape(h, w) / np.maximum(count, 1)
    known = count > 0
    correlation = residual_correlation(mean, known, cell)
    design = np.ones((h, w, 3))
    design[..., 1] = x.min() + (np.arange(w) + 0.5) * cell
    design[..., 2] = (z.min() + (np.arange(h) + 0.5) * cell)[:, None]
    covariance = fit_covariance(design, known, correlation)
    effective = float(np.var(mean[known]) / max(covariance[0, 0], 1e-300))
    return covariance, correlation, max(effective - 3.0, 1.0)


def bend(x: Float, y: Float, threshold: float, reach: float, strip: float = 0.5) -> tuple[float, float]:
    """Sagitta of the wall along x and its sigma, m: a quadratic through the modal offset of every strip.

    x, y       (n,) m, facade coordinates of points near the plane; |y| <= `reach` are used
    threshold  m, width of the histogram's bins and of the mode

    Positive: the middle lies deeper than the ends. (0, inf) with fewer than six strips.
    """
    keep = np.abs(y) <= reach
    x, y = x[keep], y[keep]
    if len(x) == 0 or np.ptp(x) < 6 * strip:
        return 0.0, float("inf")
    number = int(np.ceil(np.ptp(x) / strip))
    column = np.minimum(((x - x.min()) / strip).astype(np.int64), number - 1)
    bins = int(np.ceil(2 * reach / threshold))
    level = np.clip(((y + reach) / threshold).astype(np.int64), 0, bins - 1)
    count = np.bincount(column * bins + level, minlength=number * bins).reshape(number, bins)
    pooled = count + np.pad(count, ((0, 0), (1, 0)))[:, :-1] + np.pad(count, ((0, 0), (0, 1)))[:, 1:]
    mode = pooled.argmax(1)
    on_mode = np.abs(level - mode[column]) <= 1
    held = np.bincount(column[on_mode], minlength=number).astype(np.float64)
    height: Float = np.bincount(column[on_mode], y[on_mode], minlength=number) / np.maximum(held, 1.0)
    good = held >= max(10.0, 0.2 * float(np.median(held)))
    if good.sum() < 6:
        return 0.0, float("inf")
    return _sagitta((np.arange(number)[good] + 0.5) * strip, np.asarray(height[good], np.float64), threshold)


def _sagitta(x: Array, y: Array, threshold: float) -> tuple[float, float]:
    half = 0.5 * float(np.ptp(x))
    u = (x - x.min() - half) / half
    design = np.column_stack([np.ones(len(u)), u, u * u])
    start = np.linalg.lstsq(design, y, rcond=None)[0]
    fit = irls(design, y, np.ones(len(u)), 0.0005, start, max(mad_sigma(y - design @ start), threshold / 3))
    inverse = np.linalg.pinv((design * fit.weights[:, None]).T @ design)
    # neighbouring strips share a house's roughness: count every second one
    return -float(fit.parameters[2]), float(fit.sigma * np.sqrt(2.0 * inverse[2, 2]))
