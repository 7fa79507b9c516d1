"""The channels of a front's profile, with their standard errors bin by bin.

A scan thins out along a row: a mean over ten leaves is worth less than one over a hundred, and eaves that few
beams hit are known only to the distance between these beams.
"""

from collections.abc import Sequence

import numpy as np

from frontage.buildings.fronts.profile import BIN_M, FrontProfile
from frontage.geometry.arrays import Bool, Float, Int

# least spread of each kind of channel within a house: m, m, m, Delta E (Lab), log intensity
FLOOR = {"eaves": 0.1, "offset": 0.03, "rough": 0.01, "colour": 4.0, "bright": 0.1}
_LAG_BINS = 10  # bins (2.5 m): differences at this lag contain the rhythm of the windows as noise
_FEW_LEAVES = 8.0  # leaves from which the mean of a bin is as uncertain as bins differ within a house
_SHIFT_BINS = 6  # bins (1.5 m): how far a cut may be moved to where its step is sharpest
_WINDOW_BINS = 12  # bins (3 m) compared on either side of it
_CLIP_SIGMAS = 5.0  # standard errors; more from one bin is an outlier
_LEAST_GAIN = 5.0  # log likelihood that a move must gain: the choice among 13 places, twice


def channels(profile: FrontProfile) -> tuple[Float, list[str]]:
    """Returns the profile as one matrix (n, p) and the kind of every channel (p,)."""
    parts = [profile.top, _straightened(profile.offset), profile.rough, *profile.colour.T, profile.bright]
    return np.column_stack(parts), ["eaves", "offset", "rough", *["colour"] * 6, "bright"]


def _straightened(offset: Float) -> Float:
    """Returns the offsets (n,) m of a front without the slant of its line against its walls.

    The line is fitted to walls at several offsets, and may run askew through them. The median of differences
    at the lag of a window bay tells its slope. Steps between houses hardly change this median.
    """
    apart = offset[_LAG_BINS:] - offset[:-_LAG_BINS]
    if not np.isfinite(apart).any():
        return offset
    return np.asarray(offset - float(np.nanmedian(apart)) / _LAG_BINS * np.arange(len(offset)))


def noise_of(signal: Float, kinds: list[str], count: Float) -> Float:
    """Returns the spread (p,) of each channel within a building, from the better measured half of the bins.

    It is taken from differences at the lag of a window bay, whose median a few cuts cannot move.

    signal  (n, p); `kinds` (p,) of channels
    count   (n,) leaves of each bin
    """
    if len(signal) <= _LAG_BINS:
        return np.full(signal.shape[1], np.nan)
    difference = np.abs(signal[_LAG_BINS:] - signal[:-_LAG_BINS])
    worth = np.minimum(count[_LAG_BINS:], count[:-_LAG_BINS])
    difference[worth < np.median(worth)] = np.nan
    known = np.isfinite(difference).sum(0) >= 4
    spread = np.full(signal.shape[1], np.nan)
    if known.any():
        spread[known] = 1.4826 / np.sqrt(2) * np.nanmedian(difference[:, known], axis=0)
    return np.where(known, np.maximum(spread, [FLOOR[k] for k in kinds]), np.nan)


def sampling_of(profile: FrontProfile, noise: Float, kinds: list[str]) -> Float:
    """Returns the standard error (n, p) of a bin that follows from its number of leaves alone.

    `noise` (p,) is the spread within a house. A mean of k leaves has noise x sqrt(_FEW_LEAVES / k). The
    topmost of k leaves on a wall of height H lies H / k below its top on average, and scatters as much.
    """
    k = np.maximum(profile.count, 1.0)[:, None]
    mean = noise * np.sqrt(_FEW_LEAVES / k)
    tall = profile.rows.shape[1] * BIN_M / k
    return np.where([kind == "eaves" for kind in kinds], tall, mean)


def sharpest(signal: Float, sigma: Float, cuts: Int, width: int, tells: Sequence[Bool] | None = None) -> Int:
    """Moves each cut to where the medians of its two sides explain the bins best.

    signal, sigma  (n, p)
    cuts           (c,) bins; `width` bins, least width of a piece
    tells          for each cut the channels (p,) that show it; by default those that step there
    """
    out: list[int] = []
    edge = [0, *cuts.tolist(), len(signal)]
    for i, c in enumerate(edge[1:-1]):
        left = out[-1] if out else 0  # no house may become narrower than `width`
        lo, hi = max(left + width, c - _SHIFT_BINS), min(edge[i + 2] - width, c + _SHIFT_BINS)
        a, b = max(edge[i], c - _SHIFT_BINS - _WINDOW_BINS), min(edge[i + 2], c + _SHIFT_BINS + _WINDOW_BINS)
        places = np.arange(min(lo, c), max(hi, c) + 1)
        use = _stepping(signal, sigma, (a, c, b)) if tells is None else tells[i]
        y, e = signal[:, use], sigma[:, use]
        cost = np.array([_misfit(y[a:p], e[a:p]) + _misfit(y[p:b], e[p:b]) for p in places])
        best = int(np.argmin(cost))
        out.append(int(places[best]) if cost[c - places[0]] - cost[best] > _LEAST_GAIN else c)
    return np.array(out, np.int64)


def _stepping(signal: Float, sigma: Float, side: tuple[int, int, int]) -> Bool:
    """Returns the channels (p,) that step by more than a bin's error, or all channels if none does.

    The others cannot tell where the step is. `side` gives the first, the middle and the end bin.
    """
    a, c, b = side
    known = np.isfinite(signal[a:c]).any(0) & np.isfinite(signal[c:b]).any(0)
    out = np.zeros(signal.shape[1], bool)
    if known.any():
        step = np.nanmedian(signal[c:b, known], axis=0) - np.nanmedian(signal[a:c, known], axis=0)
        out[known] = np.abs(step) > np.median(sigma[a:b, known], axis=0)
    return out if out.any() else np.ones(len(out), bool)


def _misfit(signal: Float, sigma: Float) -> float:
    """Sums the clipped distances from the median, in standard errors."""
    known = np.isfinite(signal).any(0)
    if not known.any():
        return 0.0
    part = signal[:, known]
    return float(
        np.nansum(np.minimum(np.abs(part - np.nanmedian(part, axis=0)) / sigma[:, known], _CLIP_SIGMAS))
    )
