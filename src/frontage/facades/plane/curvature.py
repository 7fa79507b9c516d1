"""Measure whether a wall is curved in plan, from the modal offsets of strips along it."""

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.solve.robust import irls, mad_sigma

_GROWTH_STEPS = 20  # steps in which the parabola grows along a curved wall
_STRIP_M = 0.5  # m, width of a strip; narrower on short walls
_FEWEST_STRIPS = 12  # strips of a wall, at least
_ON_CURVE = 2 / 3  # share of the strips that must follow the curve
_CURVED = 1.3  # a wall is curved when the parabola holds this many times the points of the plane
_NOISE_FLOOR_M = 0.0005  # m, least sigma of a strip's offset


def wall_sagitta(x: Float, y: Float, threshold: float, reach: float) -> tuple[float, float]:
    """Fits a quadratic to the modal offset of every strip along x and returns its sagitta and sigma, m.

    x, y       (n,) m, facade coordinates of points near the plane; those with |y| <= `reach` m are used
    threshold  m, width of the histogram's bins and half width of the mode

    A positive sagitta says that the middle lies deeper than the ends. Returns (0, inf) when there are too few
    strips, when the quadratic misses a third of them, or when their scatter about it exceeds `threshold`
    (pilasters, a recessed middle).
    """
    keep = np.abs(y) <= reach
    x, y = x[keep], y[keep]
    if len(x) == 0 or np.ptp(x) < _FEWEST_STRIPS * threshold:
        return 0.0, float("inf")
    strip = min(_STRIP_M, float(np.ptp(x)) / _FEWEST_STRIPS)
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
    if 2 * good.sum() < _FEWEST_STRIPS:
        return 0.0, float("inf")
    return _sagitta((np.arange(number)[good] + 0.5) * strip, np.asarray(height[good], np.float64), threshold)


def _sagitta(x: Array, y: Array, threshold: float) -> tuple[float, float]:
    """Sagitta and sigma (m) of a robust quadratic through offsets y (k,) m of strips at x (k,) m."""
    half = 0.5 * float(np.ptp(x))
    u = (x - x.min() - half) / half
    design = np.column_stack([np.ones(len(u)), u, u * u])
    start = np.linalg.lstsq(design, y, rcond=None)[0]
    scale = max(mad_sigma(y - design @ start), threshold / 3)
    fit = irls(design, y, np.ones(len(u)), sigma_floor=_NOISE_FLOOR_M, start=start, sigma_start=scale)
    if np.count_nonzero(fit.weights) < _ON_CURVE * len(u) or fit.sigma > threshold:
        return 0.0, float("inf")
    inverse = np.linalg.pinv((design * fit.weights[:, None]).T @ design)
    # neighbouring strips share a house's roughness, so every second one counts
    return -float(fit.parameters[2]), float(fit.sigma * np.sqrt(2.0 * inverse[2, 2]))


def tangent_at_middle(x: Float, y: Float, threshold: float) -> tuple[float, float]:
    """Finds the line y = c + a x that touches a curved wall at its middle; returns c (m) and a (rad).

    x, y       (n,) m, coordinates about a plane that lies on some part of the wall, points of equal area
    threshold  m, half thickness of the wall

    A plane that maximises its inliers touches a curved wall anywhere. A parabola that starts from that plane
    and takes in what is near it grows along the wall to its ends. Returns (0, 0) for a flat wall.
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
    if np.count_nonzero(near) < _CURVED * on_plane:
        return 0.0, 0.0
    low, high = np.quantile(x[near], [0.01, 0.99])
    slope = float(fit[0] * (low + high) + fit[1])
    return float(np.polyval(fit, 0.5 * (low + high)) - 0.5 * slope * (low + high)), slope
