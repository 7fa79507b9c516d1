"""Refinement: robust fit y = c + a x + b z on equal areas, its covariance, the lean's prior."""

from dataclasses import dataclass

import numpy as np

from frontage.facades.cells import CellMap
from frontage.facades.cloud import Cloud, Slab
from frontage.facades.means import cell_means, passes, station_covariance
from frontage.facades.options import FacadeOptions
from frontage.geometry.arrays import Float, Int
from frontage.geometry.plane import facade_axes
from frontage.model.scan import Scan
from frontage.solve.robust import TUKEY, irls, mad_sigma, tukey_response, tukey_weights, weighted_fit

_MOST = 20_000  # points that tell direction and scale; the last step takes all
_FLOOR = 0.0005  # m, least sigma
_WIDE, _CLOSE = (
    (0.5, 0.3, 0.15, 0.0),
    (0.15, 0.0),
)  # of the inlier distance: how near points straighten a plane
_SIGMAS = 3.0  # inliers lie within
_QUARTER = 0.3186  # half the width, in sigmas, of the middle quarter of a Gaussian


@dataclass(frozen=True, eq=False)
class Wall:
    """A wall plane, sketched (its covariance is NaN) or measured.

    normal, point  unit normal (3,), barycentre of the inliers (3,) m local, on the plane
    sigma          m, robust spread of the inliers; threshold m, 3 sigma
    covariance     (3, 3) of offset (m), slope along x (rad), slope along z (rad) at `point`
    inliers        (k,) int64 into Cloud.xyz
    dof            effective redundancy of the fit
    """

    normal: Float
    point: Float
    sigma: float
    threshold: float
    covariance: Float
    inliers: Int
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
            self.dof,
        )


def start_sigma(offsets: Float, threshold: float, floor: float) -> tuple[float, float]:
    """Centre and robust sigma in m of the densest layer of `offsets` (n,) within `threshold`.

    It starts from the shortest interval that holds a quarter of them (Rousseeuw's shorth, for layers that
    hold a quarter); the window shrinks to 3 sigma of what is inside until it settles.
    """
    near = np.sort(offsets[np.abs(offsets) < threshold])
    if len(near) < 8:
        return (float(np.median(near)) if len(near) else 0.0), threshold / _SIGMAS
    quarter = len(near) // 4
    length = near[quarter:] - near[:-quarter]
    best = int(np.argmin(length))
    centre = 0.5 * float(near[best] + near[best + quarter])
    sigma = max(0.5 * float(length[best]) / _QUARTER, floor)
    width = min(_SIGMAS * sigma, threshold)
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


def sketch_wall(slab: Slab, region: CellMap, sigma: float) -> Wall | None:
    """The plane of `slab` as a wall without covariance: its inliers within `region`, their barycentre."""
    near = np.flatnonzero(np.abs(slab.q[:, 1]) < _SIGMAS * sigma)
    q = slab.at(near)
    on = region.within(q[:, 0], q[:, 2])
    if np.count_nonzero(on) < 10:
        return None
    x, z = float(q[on, 0].mean()), float(q[on, 2].mean())
    return Wall(
        slab.axes[:, 1],
        slab.point + slab.axes @ np.array([x, 0.0, z]),
        sigma,
        _SIGMAS * sigma,
        np.full((3, 3), np.nan),
        slab.rows[near[on]],
        0.0,
    )


def refine_wall(
    slab: Slab,
    region: CellMap,
    cloud: Cloud,
    scan: Scan,
    options: FacadeOptions,
    rng: np.random.Generator,
) -> Wall | None:
    """Fit the wall to all points of `slab` near its plane and within `region` (in the slab's frame).

    Direction and scale come from a sample; the last step is least squares on the means of all inliers
    per cell, so that equal areas count equally, whatever the density. None when fewer than ten remain.
    """
    near = np.abs(slab.q[:, 1]) < max(2.0 * cloud.threshold, 0.10)
    near &= region.within(slab.q[:, 0], slab.q[:, 2])
    candidates = np.flatnonzero(near)
    if len(candidates) < 10:
        return None
    q = slab.at(candidates)
    picked = q if len(q) <= _MOST else q[rng.integers(0, len(q), _MOST)]
    weights = 1.0 / _cell_count(picked[:, 0], picked[:, 2], cloud.raster)
    fit, sigma = robust_fit(picked, weights, cloud.threshold, np.zeros(3))
    residual = q[:, 1] - (fit[0] + fit[1] * q[:, 0] + fit[2] * q[:, 2])
    return _finish(slab, fit, sigma, q, residual, candidates, cloud, scan, options)


def refine_thin(q: Float, wide: Float, cloud: Cloud, sharp: Float | None) -> tuple[Float, float]:
    """The fit (3,) = (c, a, b) and sigma m of thinned points, one per voxel: a good start.

    q (n, 3) near the plane that was found; wide (m, 3) also in front of it and behind; sharp (3,) the plane
    with the most points at the measured noise, or None.

    Walls in many shallow layers draw a plane aslant through several. So the fit is tried free, straightened
    in plan before it may lean, and from `sharp`; the likeliest wins.
    """
    q, wide = (p[:: len(p) // _MOST + 1] for p in (q, wide))
    weights = np.ones(len(q))
    starts = [(q, _straighten(q, weights, cloud.threshold, _WIDE, columns)) for columns in (2, 3)]
    if sharp is not None:
        starts.append((wide, sharp))
    fits = [robust_fit(p, np.ones(len(p)), cloud.threshold, start) for p, start in starts]
    return max(fits, key=lambda fit: _likelihood(wide, *fit))


def _likelihood(q: Float, fit: Float, sigma: float) -> float:
    """Log likelihood of points (n, 3), Gaussian about a plane with `sigma` m, over uniform in a metre."""
    inside = np.abs(q @ [-fit[1], 1.0, -fit[2]] - fit[0]) < _SIGMAS * sigma
    return float(np.count_nonzero(inside) * (np.log(1.0 / (np.sqrt(2.0 * np.pi) * sigma)) - 0.5))


def robust_fit(q: Float, weights: Float, threshold: float, start: Float) -> tuple[Float, float]:
    """IRLS on points (n, 3) with `weights` (n,) from the plane `start` = (c, a, b): the fit and sigma m."""
    start = _straighten(q, weights, threshold, _CLOSE, 3, start)
    design = np.column_stack([np.ones(len(q)), q[:, 0], q[:, 2]])
    _, sigma = start_sigma(q[:, 1] - design @ start, threshold, _FLOOR)
    sigma = natural_sigma(q[:, 1] - design @ start, sigma, _FLOOR)
    result = irls(design, q[:, 1], weights, sigma_floor=_FLOOR, start=start, sigma_start=sigma)
    return result.parameters, natural_sigma(q[:, 1] - design @ result.parameters, result.sigma, _FLOOR)


def _straighten(
    q: Float,
    weights: Float,
    threshold: float,
    shares: tuple[float, ...],
    columns: int,
    start: Float | None = None,
) -> Float:
    """The plane (c, a, b) of the densest layer, its direction fitted to what is ever closer to it.

    A first direction that is off by a degree smears the layer. shares: of `threshold` m, how close;
    columns: 2 leaves the lean at zero.
    """
    design = np.column_stack([np.ones(len(q)), q[:, 0], q[:, 2]])
    fit = np.zeros(3) if start is None else np.array(start)
    shift, sigma = start_sigma(q[:, 1] - design @ fit, threshold, _FLOOR)
    fit[0] += shift
    for share in shares:
        residual = q[:, 1] - design @ fit
        near = np.abs(residual) < max(2.0 * sigma, share * threshold)
        if np.count_nonzero(near) < 10:
            break
        fit[:columns] += weighted_fit(design[near, :columns], residual[near], weights[near])
        shift, sigma = start_sigma(q[:, 1] - design @ fit, threshold, _FLOOR)
        fit[0] += shift
    return fit


def natural_sigma(residuals: Float, sigma: float, floor: float, most: float = 0.033) -> float:
    """Sigma in m at which the MAD of what lies within 3 sigma is that sigma, found from below.

    A wall that waves more than its local roughness widens; a separate parallel layer does not enter: in a
    window as wide as Tukey's support, plinths and mouldings of a few sigma let in one another.
    """
    for _ in range(20):
        inside = np.abs(residuals) < _SIGMAS * sigma
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
    slab: Slab,
    fit: Float,
    sigma: float,
    q: Float,
    residual: Float,
    candidates: Int,
    cloud: Cloud,
    scan: Scan,
    options: FacadeOptions,
) -> Wall | None:
    """One step on the cell means of all points, covariance at the barycentre, the lean's prior, the plane."""
    near = np.flatnonzero(np.abs(residual) < TUKEY * sigma)
    if len(near) < 10:
        return None
    x, z, r = q[near, 0], q[near, 2], residual[near]
    weights, gain = _newton(r, sigma)
    means = cell_means(x, z, gain * r, weights, cloud.raster)
    step = means.fit()
    fit, r = fit + step, r - (step[0] + step[1] * x + step[2] * z)
    on = np.abs(r) < _SIGMAS * sigma
    if np.count_nonzero(on) < 10:
        return None
    bx, bz = float(x[on].mean()), float(z[on].mean())
    means = means.centred(step, bx, bz)
    covariance, dof = means.covariance()
    stations = passes(scan, cloud.index[slab.rows[candidates[near]]])
    covariance = covariance + station_covariance(means, stations, weights, r, covariance)
    fit[0] += fit[1] * bx + fit[2] * bz
    if options.levelled:
        fit, covariance = _lean_prior(slab.axes, fit, covariance, np.radians(options.lean_sigma))
    normal = slab.axes @ np.array([-fit[1], 1.0, -fit[2]])
    return Wall(
        normal / np.linalg.norm(normal),
        slab.point + slab.axes @ np.array([bx, fit[0], bz]),
        sigma,
        _SIGMAS * sigma,
        covariance,
        slab.rows[candidates[near[on]]],
        dof,
    )


def _newton(r: Float, sigma: float) -> tuple[Float, float]:
    """Tukey's weights (n,) of residuals (n,) m, and what the step they give falls short of Newton's.

    Re-weighting moves by the mean of r w over that of w, Newton's step by that over the mean of (r w)'.
    """
    weights = tukey_weights(r, sigma)
    return weights, float(weights.sum() / max(tukey_response(r, sigma).sum(), 0.5 * weights.sum()))


def _lean_prior(axes: Float, fit: Float, covariance: Float, sigma: float) -> tuple[Float, Float]:
    """One pseudo-observation 'the wall is upright' with its sigma rad, as a Kalman update."""
    upright = axes[2, 1] / max(axes[2, 2], 1e-6)  # the slope b for which the normal is horizontal
    gain = covariance[:, 2] / (covariance[2, 2] + sigma**2)
    return fit + gain * (upright - fit[2]), covariance - np.outer(gain, covariance[2])
