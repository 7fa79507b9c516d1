"""The profile of a front as channels with their own standard errors, bin by bin.

A scan thins out along a row: the same mean over ten leaves is worth less than over a hundred, and eaves seen
by few beams are known only to the distance between them.
"""

from collections.abc import Sequence

import numpy as np

from frontage.buildings.profile import BIN, Profile
from frontage.geometry.arrays import Bool, Float, Int

FLOOR = {"eaves": 0.1, "offset": 0.03, "rough": 0.01, "colour": 4.0, "bright": 0.1}
_LAG = 10  # bins (2.5 m): differences at this lag hold the windows' own rhythm as noise
_FEW = 8.0  # leaves from which the mean of a bin is as uncertain as bins differ within a house
_SHIFT = 6  # bins (1.5 m): how far a cut may be moved to where its step is sharpest
_WINDOW = 12  # bins (3 m) compared on either side of it
_CLIP = 5.0  # standard errors: more from one bin is an outlier
_GAIN = 5.0  # log-likelihood that a move must gain: the choice among 2 x _SHIFT + 1 places, twice


def signals(profile: Profile) -> tuple[Float, list[str]]:
    """The profile as one matrix (n, p) and the kind of every channel."""
    parts = [profile.top, profile.offset, profile.rough, *profile.colour.T, profile.bright]
    return np.column_stack(parts), ["eaves", "offset", "rough", *["colour"] * 6, "bright"]


def noise_of(signal: Float, kinds: list[str], count: Float) -> Float:
    """Spread (p,) within a building, of the better measured half of the bins: from differences at the lag
    of a window bay, whose median few cuts can move."""
    if len(signal) <= _LAG:
        return np.full(signal.shape[1], np.nan)
    difference = np.abs(signal[_LAG:] - signal[:-_LAG])
    worth = np.minimum(count[_LAG:], count[:-_LAG])
    difference[worth < np.median(worth)] = np.nan
    known = np.isfinite(difference).sum(0) >= 4
    spread = np.full(signal.shape[1], np.nan)
    if known.any():
        spread[known] = 1.4826 / np.sqrt(2) * np.nanmedian(difference[:, known], axis=0)
    return np.where(known, np.maximum(spread, [FLOOR[k] for k in kinds]), np.nan)


def sampling_of(profile: Profile, noise: Float, kinds: list[str]) -> Float:
    """Standard error (n, p) of a bin from its number of leaves alone; noise (p,) within a house.

    Means of k leaves: noise x sqrt(_FEW / k). Eaves: the topmost of k leaves over a wall of height H lies
    H / k below its top on average, and as much scatters.
    """
    k = np.maximum(profile.count, 1.0)[:, None]
    mean = noise * np.sqrt(_FEW / k)
    tall = profile.rows.shape[1] * BIN / k
    return np.where([kind == "eaves" for kind in kinds], tall, mean)


def sharpest(signal: Float, sigma: Float, cuts: Int, width: int, tells: Sequence[Bool] | None = None) -> Int:
    """Cuts moved to where the medians of their two sides explain the bins best; signal, sigma (n, p).

    `tells` (p,) for each cut: the channels that show it; by default those that step there.
    """
    out: list[int] = []
    edge = [0, *cuts.tolist(), len(signal)]
    for i, c in enumerate(edge[1:-1]):
        left = out[-1] if out else 0  # no house becomes narrower than one can be
        lo, hi = max(left + width, c - _SHIFT), min(edge[i + 2] - width, c + _SHIFT)
        a, b = max(edge[i], c - _SHIFT - _WINDOW), min(edge[i + 2], c + _SHIFT + _WINDOW)
        places = np.arange(min(lo, c), max(hi, c) + 1)
        use = _stepping(signal, sigma, (a, c, b)) if tells is None else tells[i]
        y, e = signal[:, use], sigma[:, use]
        cost = np.array([_misfit(y[a:p], e[a:p]) + _misfit(y[p:b], e[p:b]) for p in places])
        best = int(np.argmin(cost))
        out.append(int(places[best]) if cost[c - places[0]] - cost[best] > _GAIN else c)
    return np.array(out, np.int64)


def _stepping(signal: Float, sigma: Float, side: tuple[int, int, int]) -> Bool:
    """Channels (p,) whose medians on the two sides differ by more than a bin's error, all where none does.

    The others cannot tell where the step is.
    """
    a, c, b = side
    known = np.isfinite(signal[a:c]).any(0) & np.isfinite(signal[c:b]).any(0)
    out = np.zeros(signal.shape[1], bool)
    if known.any():
        step = np.nanmedian(signal[c:b, known], axis=0) - np.nanmedian(signal[a:c, known], axis=0)
        out[known] = np.abs(step) > np.median(sigma[a:b, known], axis=0)
    return out if out.any() else np.ones(len(out), bool)


def _misfit(signal: Float, sigma: Float) -> float:
    """Sum of the clipped distances from the median, in standard errors."""
    known = np.isfinite(signal).any(0)
    if not known.any():
        return 0.0
    part = signal[:, known]
    return float(np.nansum(np.minimum(np.abs(part - np.nanmedian(part, axis=0)) / sigma[:, known], _CLIP)))
