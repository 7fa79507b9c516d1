"""What the cuts of a front are judged by: its channels, their sampling errors and its open gaps."""

from dataclasses import dataclass

import numpy as np

from frontage.buildings.fronts.profile import FrontProfile
from frontage.geometry.arrays import Float

REACH_BINS = 24  # bins (6 m): how far from a cut its two sides are compared
NEAR_BINS = 8  # bins (2 m): the same for eaves and offset, which drift
MAD_TO_SIGMA = 1.4826  # standard deviation of a Gaussian over its median absolute deviation

BinRange = tuple[int, int]  # bins [first, end) of a front


@dataclass(frozen=True, eq=False)
class SplitEvidence:
    """What the cuts of a front are judged by.

    signal    (n, p) channels of the profile, bin by bin; `kinds` (p,) of them
    sampling  (n, p) standard error that the number of leaves in a bin leaves open
    gaps      open gaps, as ranges of bins
    cell      m, how finely heights are known
    """

    profile: FrontProfile
    signal: Float
    kinds: list[str]
    sampling: Float
    gaps: list[BinRange]
    cell: float

    def sides(self, cuts: list[int], i: int) -> tuple[BinRange, BinRange]:
        """Returns the bins to the left and to the right of cut i, up to its neighbours."""
        return (
            (cuts[i - 1] if i else 0, cuts[i]),
            (cuts[i], cuts[i + 1] if i + 1 < len(cuts) else len(self.profile)),
        )


def spread_within(evidence: SplitEvidence, cuts: list[int]) -> Float:
    """Returns the robust spread (p,) of each channel about the medians of the segments between cuts.

    Only the better measured half of the bins takes part; the sampling errors say how little the others know.
    """
    residual = [part - median_of_bins(part) for part in np.split(evidence.signal, cuts) if len(part)]
    count = evidence.profile.count
    return MAD_TO_SIGMA * median_of_bins(np.abs(np.concatenate(residual))[count >= np.median(count)])


def last_bins(side: BinRange, reach: int) -> slice:
    """Returns the last `reach` bins of a range."""
    return slice(max(side[0], side[1] - reach), side[1])


def first_bins(side: BinRange, reach: int) -> slice:
    """Returns the first `reach` bins of a range."""
    return slice(side[0], min(side[1], side[0] + reach))


def median_of_bins(a: Float) -> Float:
    """Returns the median (p,) of (n, p) over the bins, NaN for a channel without measurement."""
    n, column = np.isfinite(a).sum(0), np.arange(a.shape[1])
    if not len(a):
        return np.full(a.shape[1], np.nan)
    ordered = np.sort(a, axis=0)  # NaN last
    below, above = np.maximum(n - 1, 0) // 2, np.minimum(n // 2, len(a) - 1)
    return np.where(n > 0, 0.5 * (ordered[below, column] + ordered[above, column]), np.nan)
