"""Open gaps in a row: places where a wall would have been measured, and what lies behind it was instead.

A stretch without recognised wall is no gap yet: a grazing or sparse scan leaves walls unrecognised, and a
tree or a car throws a shadow. A gap is seen through.
"""

import numpy as np

from frontage.buildings.profile import BIN, Profile
from frontage.geometry.arrays import Bool, Float

_STANDING = 1.0  # m before and behind the line of the wall: what stands there may be the wall
_BEHIND = 1.5  # m, from here on something lies behind the wall
_FOOT = 0.5  # m above the ground: lower things do not make a wall
_EXPECTED = 10.0  # leaves a bin must be expected to hold before their absence says anything
_LEFT_OVER = 0.1  # share of the expected leaves that railings and wires may leave in a gap
_SIDE = 12  # bins (3 m) on either side that tell what to expect


def open_bins(profile: Profile, s: Float, d: Float, height: Float, weight: Float) -> Bool:
    """Bins (n,) of a front that are open from the ground up.

    s, d (m,) m: places of all cells around the front, in its frame; height (m,) m above the ground;
    weight (m,): occupied leaves of each.
    """
    n = len(profile)
    at = np.floor((s - profile.lo) / BIN).astype(np.int64)
    inside = np.flatnonzero((at >= 0) & (at < n))
    at, rel = at[inside], d[inside] - profile.offset_at(s[inside])
    standing = (np.abs(rel) < _STANDING) & (height[inside] > _FOOT)
    present = np.bincount(at[standing], weights=weight[inside][standing], minlength=n)
    through = np.bincount(at[rel < -_BEHIND], minlength=n) > 0
    expected = _expected(np.where(np.isfinite(profile.top), present, np.nan))
    return through & (expected >= _EXPECTED) & (present <= _LEFT_OVER * expected)


def _expected(present: Float) -> Float:
    """Leaves (n,) that a wall would leave in each bin: the lesser of its two sides; 0 = not known."""
    padded = np.pad(present, _SIDE, constant_values=np.nan)
    window = np.lib.stride_tricks.sliding_window_view(padded, _SIDE)
    known = np.isfinite(window).sum(1) >= _SIDE // 4
    median = np.zeros(len(window))
    median[known] = np.nanmedian(window[known], axis=1)
    return np.minimum(median[: len(present)], median[_SIDE + 1 :])
