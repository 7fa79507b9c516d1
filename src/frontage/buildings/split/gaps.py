"""Find open gaps in a row: places where a wall would have been measured, and what lies behind was instead.

A stretch without recognised wall is not yet a gap. A grazing or sparse scan leaves walls unrecognised, and a
tree or a car throws a shadow; a gap is seen through.
"""

import numpy as np

from frontage.buildings.fronts.profile import BIN_M, FrontProfile
from frontage.geometry.arrays import Bool, Float

_STANDING_M = 1.0  # m before and behind the line of the wall, where it may stand
_BEHIND_M = 1.5  # m; points further back lie behind the wall
_FOOT_M = 0.5  # m above the ground; lower things do not make a wall
_LEAST_EXPECTED = 10.0  # leaves that a bin must be expected to hold before their absence says anything
_REMAINDER = 0.1  # share of the expected leaves that railings and wires may leave in a gap
_SIDE_BINS = 12  # bins (3 m) on either side that tell what to expect


def open_bins(profile: FrontProfile, s: Float, d: Float, height: Float, weight: Float) -> Bool:
    """Finds the bins (n,) of a front that are open from the ground up.

    s, d    (m,) m, places of all coarse cells around the front, in its frame
    height  (m,) m above the ground; `weight` (m,) occupied leaves of each cell
    """
    n = len(profile)
    at = np.floor((s - profile.lo) / BIN_M).astype(np.int64)
    inside = np.flatnonzero((at >= 0) & (at < n))
    at, rel = at[inside], d[inside] - profile.offset_at(s[inside])
    standing = (np.abs(rel) < _STANDING_M) & (height[inside] > _FOOT_M)
    present = np.bincount(at[standing], weights=weight[inside][standing], minlength=n)
    through = np.bincount(at[rel < -_BEHIND_M], minlength=n) > 0
    expected = _expected(np.where(np.isfinite(profile.top), present, np.nan))
    return through & (expected >= _LEAST_EXPECTED) & (present <= _REMAINDER * expected)


def _expected(present: Float) -> Float:
    """Returns the leaves (n,) that a wall would leave in each bin: the lesser of its sides; 0 = unknown."""
    padded = np.pad(present, _SIDE_BINS, constant_values=np.nan)
    window = np.lib.stride_tricks.sliding_window_view(padded, _SIDE_BINS)
    known = np.isfinite(window).sum(1) >= _SIDE_BINS // 4
    median = np.zeros(len(window))
    median[known] = np.nanmedian(window[known], axis=1)
    return np.minimum(median[: len(present)], median[_SIDE_BINS + 1 :])
