"""Windows of one type: which they are, and the depth behind the wall at which their frames stand.

Builders set the frames of one type at one depth. Each window tells it with an error of one to three
centimetres, now and then of more where a curtain close behind the glass has stronger edges than the frame.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.crossbars.observe import Sight
from frontage.geometry.arrays import Float
from frontage.model import Estimate

_SIZE_M = 0.04  # by which windows of one type may differ in width and height
_SET_M = 0.006  # by which their frames are set differently at least; more where the wall is not plane
_TOGETHER = 0.3  # share of the variance of a depth that windows of one facade have in common: poses, wall
_QUARTILE = 0.6745  # of a standard normal: median of its absolute value
_SAME = 3.0  # standard errors of their difference within which two depths are the same


def types(sights: Sequence[Sight]) -> list[list[int]]:
    """Returns the numbers of windows of one shape and of one size, that of the first of each group."""
    groups: list[list[int]] = []
    shape = [sight.window.opening.shape for sight in sights]
    size = [np.ptp(sight.window.ring, axis=0) for sight in sights]
    for k in range(len(sights)):
        like = (g for g in groups if shape[g[0]] == shape[k] and abs(size[g[0]] - size[k]).max() <= _SIZE_M)
        group = next(like, None)
        if group is None:
            groups.append([k])
        else:
            group.append(k)
    return groups


def with_one_depth(sights: Sequence[Sight]) -> list[Sight]:
    """Returns the windows with depths of their frames that also draw on the other windows of their type.

    A frame that stands clearly elsewhere keeps its depth. Windows that only the scan shows keep theirs, too.
    """
    found = list(sights)
    for group in types(sights):
        told = [k for k in group if sights[k].depth is not None and sights[k].views]
        depths = [depth for k in told if (depth := sights[k].depth) is not None]
        at = np.array([float(d.value) for d in depths])
        sigma = np.array([float(d.sigma[0]) for d in depths])
        spread = _spread(at, sigma**2)
        for n, (k, own) in enumerate(zip(told, depths, strict=True)):
            value, variance = _contributed(n, at, sigma**2, spread)
            shared = Estimate(value, np.array([[variance]]), own.dof, own.provenance)
            found[k] = replace(sights[k], depth=shared)
    return found


def _spread(at: Float, variance: Float) -> float:
    """Returns the variance m2 of the true depths of frames, from depths (n,) and their variances."""
    if len(at) < 2:
        return _SET_M**2
    away = np.median(np.abs(at - np.median(at))) / _QUARTILE
    return float(max(away**2 - np.median(variance), _SET_M**2))


def _contributed(own: int, at: Float, variance: Float, spread: float) -> tuple[float, float]:
    """Returns the depth of a frame and its variance from the depths (n,) of all frames of its type."""
    same = (at - at[own]) ** 2 <= _SAME**2 * (variance + variance[own])
    apart = np.where(np.arange(len(at)) == own, 0.0, 2 * spread)
    weight = same / ((1 - _TOGETHER) * variance + apart)
    share = weight / weight.sum()
    return float(share @ at), float(1.0 / weight.sum() + _TOGETHER * (share @ variance))
