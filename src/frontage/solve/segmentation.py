"""Finds the optimal change points of a multivariate signal by dynamic programming."""

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int


def change_points(
    signal: Float, penalty: float, min_bins: int, linear: Bool | None = None, weight: Float | None = None
) -> Int:
    """Returns the cuts (c,) that minimise the squared residuals within segments plus `penalty` per cut.

    A cut at i lies between bins i - 1 and i.

    signal    (n, p) float64 in units of its own noise, NaN = not measured
    min_bins  least length of a segment
    linear    (p,) bool, channels that may drift linearly within a segment (a line instead of the mean)
    weight    (n, p), of the square of each bin; 1 where the noise is the unit

    This is optimal partitioning (Jackson et al. 2005), pruned as in PELT (Killick, Fearnhead & Eckley 2012).
    It is exact, and O(n p) where the number of cuts grows with n.
    """
    n, p = signal.shape
    if n < 2 * min_bins:
        return np.empty(0, np.int64)
    sums = _prefix(signal, np.ones_like(signal) if weight is None else weight)
    drift = np.zeros(p, bool) if linear is None else np.asarray(linear, bool)
    best = np.full(n + 1, np.inf)
    best[0] = -penalty
    back = np.zeros(n + 1, np.int64)
    dead = np.full(n + 1, n + 1)  # the end from which on a start can no longer be optimal
    start = np.empty(0, np.int64)
    for end in range(min_bins, n + 1):
        start = np.append(start[dead[start] > end], end - min_bins)
        total = best[start] + _cost(sums[:, end, None] - sums[:, start], drift)
        least = int(np.argmin(total))
        back[end], best[end] = start[least], total[least] + penalty
        beaten = start[total >= best[end]]  # for these, a cut here is better as soon as it is allowed
        dead[beaten] = np.minimum(dead[beaten], end + min_bins)
    cuts, at = [], n
    while back[at] > 0:
        at = int(back[at])
        cuts.append(at)
    return np.array(cuts[::-1], np.int64)


def _prefix(signal: Float, weight: Float) -> Float:
    """Prefix sums (6, n + 1, p) of 1, y, y^2, x, x^2, xy over the measured bins, each times its weight."""
    known = np.isfinite(signal)
    w = np.where(known, weight, 0.0)
    y = np.where(known, signal, 0.0)
    x = np.where(known, np.arange(len(signal), dtype=np.float64)[:, None], 0.0)
    terms = np.stack([w, w * y, w * y * y, w * x, w * x * x, w * x * y])
    return np.concatenate([np.zeros((6, 1, signal.shape[1])), np.cumsum(terms, axis=1)], axis=1)


def _cost(sums: Float, drift: Bool) -> Float:
    """Residual sum of squares (k,) of segments with sums (6, k, p)."""
    n, y, yy, x, xx, xy = sums
    count = np.maximum(n, 1e-9)
    flat = yy - y * y / count
    sxx, sxy = xx - x * x / count, xy - x * y / count
    gain = np.where(drift & (sxx > 1e-9), sxy**2 / np.maximum(sxx, 1e-9), 0.0)
    return np.maximum(flat - gain, 0.0).sum(1)  # type: ignore[no-any-return]
