"""Scores the places of a border by the beams on both sides of it."""

from collections.abc import Sequence
from functools import lru_cache
from math import log

import cv2
import numpy as np
from scipy.special import ndtr

from frontage.geometry.arrays import Bool, Float

STRAY = 0.01
"""Share of the beams that say the wrong thing."""

_SHORT = 32  # places of a kernel from which numpy correlates as fast as OpenCV


def side_scores(
    solid: Float, opened: Float, e: Float, blur: float, strays: tuple[float, float] = (STRAY, STRAY)
) -> Float:
    """Returns `blurred_scores` (k,) for a single pair and a single blur m."""
    return np.asarray(blurred_scores([(solid, opened)], e, (blur,), strays)[0, 0])


def blurred_scores(
    pairs: Sequence[tuple[Float, Float]], e: Float, blurs: Sequence[float], strays: tuple[float, float]
) -> Float:
    """Returns the log-likelihood (b, p, k) of borders at e (k,) m, which rise in equal steps, for every blur.

    pairs   p times the beams on the wall, below the border, and those through the opening, above it, (n,) m
    blurs   (b,) m, each one sigma of the footprint
    strays  shares of the solid and of the opened beams that are on the wrong side

    The sum over the beams of log(s + (1 - s) Phi(.)): every beam is on its own side, blurred, except for
    strays.
    """
    step, k = float(e[1] - e[0]), len(e)
    reaches = [int(6.0 * blur / step) + 1 for blur in blurs]
    n = max(reaches)
    bins = k + 2 * n + 2  # the first and the last bin hold everything further off
    told = [number for number, pair in enumerate(pairs) if len(pair[0]) + len(pair[1])]
    total = np.zeros((len(blurs), len(pairs), k))
    if not told:
        return total
    beams = [u for number in told for u in pairs[number]]
    held = np.array([len(u) for u in beams])
    u = (np.concatenate(beams) - float(e[0])) / step + (n + 1)
    bin_ = np.minimum(np.maximum(u, 0), bins - 1).astype(np.int64)
    bin_ += np.repeat(np.arange(len(beams)) * bins, held)
    count = np.bincount(bin_, minlength=len(beams) * bins).astype(np.float64).reshape(-1, 2, bins)
    solid, opened = count.cumsum(2)[:, :, n : n + k].transpose(1, 0, 2)
    wrong = log(strays[0]) * (held[::2, None] - solid), log(strays[1]) * opened
    for row, (blur, m) in enumerate(zip(blurs, reaches, strict=True)):
        near = count[:, :, n - m + 1 : n + m + k]
        first, second = (
            correlated(near[:, side], _near_border(sign, m, step, blur, strays[side]))
            for side, sign in enumerate((-1.0, 1.0))
        )
        total[row, told] = (first + wrong[0]) + (second + wrong[1])
    return total


def correlated(rows: Float, kernel: Float) -> Float:
    """Correlates rows (p, n) with a kernel (m,) where it lies within them; returns (p, n - m + 1).

    The rows are correlated as one, and the places where the kernel lies across two of them are left out. For
    short kernels OpenCV is faster.
    """
    after = len(kernel) - 1
    if len(kernel) < _SHORT:
        found = cv2.sepFilter2D(rows, -1, kernel, np.ones(1), anchor=(0, 0), borderType=cv2.BORDER_CONSTANT)
        return np.asarray(found[:, : rows.shape[1] - after])
    whole = np.correlate(rows.ravel(), kernel, "full")[after:]
    return whole.reshape(rows.shape)[:, : rows.shape[1] - after]


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
