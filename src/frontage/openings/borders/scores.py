"""Scores the places of a border by the beams on both sides of it."""

from collections.abc import Sequence
from functools import lru_cache
from math import log

import numpy as np
from scipy.special import ndtr

from frontage.geometry.arrays import Bool, Float

STRAY = 0.01
"""Share of the beams that say the wrong thing."""


def side_scores(
    solid: Float, opened: Float, e: Float, blur: float, strays: tuple[float, float] = (STRAY, STRAY)
) -> Float:
    """Returns `blurred_scores` (k,) for a single blur m."""
    return np.asarray(blurred_scores(solid, opened, e, (blur,), strays)[0])


def blurred_scores(
    solid: Float, opened: Float, e: Float, blurs: Sequence[float], strays: tuple[float, float]
) -> Float:
    """Returns the log-likelihood (b, k) of borders at e (k,) m, which rise in equal steps, for every blur.

    solid   (n,) m, beams on the wall, below the border
    opened  (m,) m, beams through the opening, above it
    blurs   (b,) m, each one sigma of the footprint
    strays  shares of the solid and of the opened beams that are on the wrong side

    The sum over the beams of log(s + (1 - s) Phi(.)): every beam is on its own side, blurred, except for
    strays.
    """
    step, k = float(e[1] - e[0]), len(e)
    if not len(solid) + len(opened):
        return np.zeros((len(blurs), k))
    reaches = [int(6.0 * blur / step) + 1 for blur in blurs]
    n = max(reaches)
    bins = k + 2 * n + 2  # the first and the last bin hold everything further off
    u = (np.concatenate([solid, opened]) - float(e[0])) / step + (n + 1)
    bin_ = np.minimum(np.maximum(u, 0), bins - 1).astype(np.int64)
    bin_[len(solid) :] += bins
    count = np.bincount(bin_, minlength=2 * bins).astype(np.float64).reshape(2, bins)
    below = count.cumsum(1)[:, n : n + k]
    wrong = log(strays[0]) * (len(solid) - below[0]), log(strays[1]) * below[1]
    total = np.empty((len(blurs), k))
    for row, blur, m in zip(total, blurs, reaches, strict=True):
        near = count[:, n - m + 1 : n + m + k]
        first, second = (
            np.correlate(c, _near_border(side, m, step, blur, stray), "valid")
            for c, side, stray in zip(near, (-1.0, 1.0), strays, strict=True)
        )
        np.add(first + wrong[0], second + wrong[1], out=row)
    return total


@lru_cache(maxsize=256)
def _near_border(side: float, n: int, step: float, blur: float, stray: float) -> Float:
    """Returns the log-likelihood (2n,) of beams within n steps of a border, the lowest first.

    It is less that of beams that are on the wrong side for sure, which `blurred_scores` counts.
    """
    own, wrong = _own_side(side, n, step, blur)
    return np.asarray(np.log(stray + (1 - stray) * own) - log(stray) * wrong)


@lru_cache(maxsize=256)
def _own_side(side: float, n: int, step: float, blur: float) -> tuple[Float, Bool]:
    """Returns the probability (2n,) that beams within n steps of a border are seen on their side of it.

    It comes with whether the middles of their bins are on the other side.
    """
    lag = side * (np.arange(-n, n) + 0.5) * step  # m from the border to the centre of a bin
    return ndtr(lag / blur), lag < 0
