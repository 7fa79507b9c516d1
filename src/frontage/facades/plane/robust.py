"""Robust fit of a plane y = c + a x + b z to points that lie on several parallel layers."""

import numpy as np

from frontage.facades.plane.wall import INLIER_SIGMAS
from frontage.geometry.arrays import Float
from frontage.solve.robust import irls, mad_sigma, weighted_fit

_MOST_POINTS = 20_000  # thinned points of one fit
_LEAST_SIGMA_M = 0.0005  # m
_MOST_SIGMA_M = 0.033  # m: rougher surfaces are no wall
_WIDE_SHARES = (0.5, 0.3, 0.15, 0.0)  # shares of the inlier distance; ever closer points turn the plane
_CLOSE_SHARES = (0.15, 0.0)  # the same, starting from a plane that is nearly right
_HALF_QUARTER = 0.3186  # standard deviations: half the width of the middle quarter of a Gaussian


def densest_layer(offsets: Float, threshold: float, floor: float) -> tuple[float, float]:
    """Finds the centre and the robust sigma (m) of the densest layer of `offsets` (n,) within `threshold` m.

    The search starts from the shortest interval that holds a quarter of the offsets (Rousseeuw's shorth,
    for layers that hold a quarter). The window then shrinks to 3 sigma of its content until it settles.
    `floor` m is the least sigma.
    """
    near = np.sort(offsets[np.abs(offsets) < threshold])
    if len(near) < 8:
        return (float(np.median(near)) if len(near) else 0.0), threshold / INLIER_SIGMAS
    quarter = len(near) // 4
    length = near[quarter:] - near[:-quarter]
    best = int(np.argmin(length))
    centre = 0.5 * float(near[best] + near[best + quarter])
    sigma = max(0.5 * float(length[best]) / _HALF_QUARTER, floor)
    width = min(INLIER_SIGMAS * sigma, threshold)
    for _ in range(12):
        inside = offsets[np.abs(offsets - centre) < width]
        if len(inside) < 3:
            break
        centre = float(np.median(inside))
        # the MAD of a Gaussian truncated at 3 sigma equals the MAD itself to 0.3 %
        sigma = max(mad_sigma(inside), floor)
        new = min(max(INLIER_SIGMAS * sigma, 2.0 * floor), threshold)
        if abs(new - width) < 0.02 * width:
            break
        width = new
    return centre, sigma


def fit_thinned(q: Float, wide: Float, threshold: float, sharp: Float | None) -> tuple[Float, float]:
    """Fits a plane to thinned points, one per voxel, as a good start for the refinement.

    q          (n, 3) m, points near the plane that was found, in its frame
    wide       (m, 3) m, points in front of it and behind it as well
    threshold  m, inlier distance of the search
    sharp      (3,) the plane with the most points at the measured noise, or None

    Walls with many shallow layers draw a plane aslant through several of them. The fit is therefore tried
    three ways: freely, turned in plan before it may lean, and from `sharp`. The likeliest wins. Returns the
    plane (c, a, b) in m and rad, and sigma in m.
    """
    q, wide = (p[:: len(p) // _MOST_POINTS + 1] for p in (q, wide))
    weights = np.ones(len(q))
    starts = [(q, _straighten(q, weights, threshold, _WIDE_SHARES, columns=columns)) for columns in (2, 3)]
    if sharp is not None:
        starts.append((wide, sharp))
    fits = [robust_fit(p, np.ones(len(p)), threshold, start) for p, start in starts]
    return max(fits, key=lambda fit: _likelihood(wide, *fit))


def _likelihood(q: Float, fit: Float, sigma: float) -> float:
    """Log likelihood ratio of points (n, 3): Gaussian about a plane with `sigma` m, over uniform in 1 m."""
    inside = np.abs(q @ [-fit[1], 1.0, -fit[2]] - fit[0]) < INLIER_SIGMAS * sigma
    return float(np.count_nonzero(inside) * (np.log(1.0 / (np.sqrt(2.0 * np.pi) * sigma)) - 0.5))


def robust_fit(q: Float, weights: Float, threshold: float, start: Float) -> tuple[Float, float]:
    """Fits (c, a, b) to points (n, 3) m with `weights` (n,) by IRLS from the plane `start` (3,).

    Returns the plane and its sigma in m.
    """
    start = _straighten(q, weights, threshold, _CLOSE_SHARES, start=start)
    design = np.column_stack([np.ones(len(q)), q[:, 0], q[:, 2]])
    _, sigma = densest_layer(q[:, 1] - design @ start, threshold, _LEAST_SIGMA_M)
    sigma = natural_sigma(q[:, 1] - design @ start, sigma)
    result = irls(design, q[:, 1], weights, sigma_floor=_LEAST_SIGMA_M, start=start, sigma_start=sigma)
    return result.parameters, natural_sigma(q[:, 1] - design @ result.parameters, result.sigma)


def _straighten(
    q: Float,
    weights: Float,
    threshold: float,
    shares: tuple[float, ...],
    *,
    columns: int = 3,
    start: Float | None = None,
) -> Float:
    """Turns a plane (c, a, b) into the densest layer, with points that are ever closer to it.

    A direction that is off by a degree smears the layer, so the layer is looked for again after every turn.

    shares   of `threshold` m: how close the points must be at each turn
    columns  3, or 2 to keep the lean at its start
    """
    design = np.column_stack([np.ones(len(q)), q[:, 0], q[:, 2]])
    fit = np.zeros(3) if start is None else np.array(start)
    shift, sigma = densest_layer(q[:, 1] - design @ fit, threshold, _LEAST_SIGMA_M)
    fit[0] += shift
    for share in shares:
        residual = q[:, 1] - design @ fit
        near = np.abs(residual) < max(2.0 * sigma, share * threshold)
        if np.count_nonzero(near) < 10:
            break
        fit[:columns] += weighted_fit(design[near, :columns], residual[near], weights[near])
        shift, sigma = densest_layer(q[:, 1] - design @ fit, threshold, _LEAST_SIGMA_M)
        fit[0] += shift
    return fit


def natural_sigma(residuals: Float, sigma: float) -> float:
    """Finds the sigma (m) that equals the MAD of the residuals (n,) m within 3 sigma, growing from `sigma`.

    The sigma grows on a wall whose waves exceed its local roughness, but a separate parallel layer does not
    enter. A window as wide as Tukey's support would admit plinths and mouldings a few sigma away, one after
    the other.
    """
    for _ in range(20):
        inside = np.abs(residuals) < INLIER_SIGMAS * sigma
        scatter = mad_sigma(residuals[inside]) if inside.any() else _LEAST_SIGMA_M
        new = float(np.clip(scatter, _LEAST_SIGMA_M, _MOST_SIGMA_M))
        if abs(new - sigma) < 0.01 * sigma:
            return new
        sigma = new
    return sigma
