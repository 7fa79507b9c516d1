"""Whether a wall is bent along its length: the sagitta of a quadratic through the modes of its strips."""

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.solve.robust import irls, mad_sigma

_GROWTH_STEPS = 20  # of the parabola along a bent wall
_STRIP, _LEAST_STRIPS = 0.5, 12  # m, width of a strip, narrower on short walls
_ON_CURVE = 2 / 3  # share of the strips that a bent wall follows
_BENT = 1.3  # wall on the parabola over that on the plane, from which a wall is bent


def bend(x: Float, y: Float, threshold: float, reach: float) -> tuple[float, float]:
    """Sagitta of the wall along x and its sigma, m: a quadratic through the modal offset of every strip.

    x, y       (n,) m, facade coordinates of points near the plane; |y| <= `reach` are used
    threshold  m, width of the histogram's bins and of the mode

    Positive: the middle lies deeper than the ends. (0, inf) with too few strips, or when the quadratic
    misses a third of them or is no better than `threshold` (pilasters, a recessed middle).
    """
    keep = np.abs(y) <= reach
    x, y = x[keep], y[keep]
    if len(x) == 0 or np.ptp(x) < _LEAST_STRIPS * threshold:
        return 0.0, float("inf")
    strip = min(_STRIP, float(np.ptp(x)) / _LEAST_STRIPS)
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
    if 2 * good.sum() < _LEAST_STRIPS:
        return 0.0, float("inf")
    return _sagitta((np.arange(number)[good] + 0.5) * strip, np.asarray(height[good], np.float64), threshold)


def _sagitta(x: Array, y: Array, threshold: float) -> tuple[float, float]:
    half = 0.5 * float(np.ptp(x))
    u = (x - x.min() - half) / half
    design = np.column_stack([np.ones(len(u)), u, u * u])
    start = np.linalg.lstsq(design, y, rcond=None)[0]
    sigma = max(mad_sigma(y - design @ start), threshold / 3)
    fit = irls(design, y, np.ones(len(u)), sigma_floor=0.0005, start=start, sigma_start=sigma)
    if np.count_nonzero(fit.weights) < _ON_CURVE * len(u) or fit.sigma > threshold:
        return 0.0, float("inf")
    inverse = np.linalg.pinv((design * fit.weights[:, None]).T @ design)
    # neighbouring strips share a house's roughness: count every second one
    return -float(fit.parameters[2]), float(fit.sigma * np.sqrt(2.0 * inverse[2, 2]))


def level(x: Float, y: Float, threshold: float) -> tuple[float, float]:
    """Offset c m and slope a of the line y = c + a x touching a bent wall at its middle; (0, 0): it is flat.

    x, y       (n,) m, coordinates about a plane that lies on some part of the wall, points of equal area
    threshold  m, half thickness of the wall

    A plane that maximises its inliers touches a bent wall anywhere: a parabola that starts from it as
    a plane and takes in what is near grows along the wall to its ends.
    """
    near = np.abs(y) < threshold
    if np.count_nonzero(near) < 10:
        return 0.0, 0.0
    on_plane = int(np.count_nonzero(near))
    fit: Float = np.zeros(3)
    for _ in range(_GROWTH_STEPS):
        fit = np.polyfit(x[near], y[near], 2)
        grown = np.abs(y - np.polyval(fit, x)) < threshold
        if np.count_nonzero(grown) <= np.count_nonzero(near):
            break
        near = grown
    if np.count_nonzero(near) < _BENT * on_plane:
        return 0.0, 0.0
    low, high = np.quantile(x[near], [0.01, 0.99])
    slope = float(fit[0] * (low + high) + fit[1])
    return float(np.polyval(fit, 0.5 * (low + high)) - 0.5 * slope * (low + high)), slope
