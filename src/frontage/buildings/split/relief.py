"""What the relief of a front says about a step of its plane or of its eaves."""

import numpy as np

from frontage.buildings.fronts.profile import BIN_M, FrontProfile
from frontage.buildings.split.channels import FLOOR
from frontage.buildings.split.evidence import (
    NEAR_BINS,
    REACH_BINS,
    BinRange,
    first_bins,
    last_bins,
    median_of_bins,
)
from frontage.geometry.arrays import Float

_UPRIGHT_SHARE = 0.75  # share of the height through which a step of the plane must run
_KEPT = 2 / 3  # share of the higher side that must be higher
_FEWEST_BETWEEN = 2  # bins at the level of the lower side between higher ones, from which its eaves go on
_LEAST_STEP_M = 0.05  # m, of the plane at one height
_CROWN_BINS = 12  # bins (3 m) below the eaves: cornice, frieze and the uppermost lintels
_MOULDED_M = 0.04  # m, spread of the relief over these bins from which it tells something
_SAME_CORNICE = 0.75  # correlation of the relief on both sides of a cut that shows one cornice
_SIGMAS = 2.0  # standard errors by which a shifted relief must be more alike
_ENDS = 8  # parts of a gable, of which the outermost ones are its feet
_RIDGE_M = 1.5  # m, by which most of a gable is higher than its feet
_ALIKE = 0.8  # share of the tops of a gable that are as high as those opposite
_SAME_TOP_M = 0.5  # m, two height bins
_REMAINDER = 0.5  # share of the higher side's wall that the lower side may show above its eaves


def is_step_upright(profile: FrontProfile, left: BinRange, right: BinRange, step: float) -> bool:
    """Decides whether a step of the plane (m) runs through the whole height that both sides measured.

    A step that starts above the ground floor or ends below the roof is a bay or an oriel.
    """
    relief = profile.relief
    at_height = median_of_bins(relief[first_bins(right, NEAR_BINS)])
    at_height = at_height - median_of_bins(relief[last_bins(left, NEAR_BINS)])
    at_height = at_height[np.isfinite(at_height)] * np.sign(step)
    return len(at_height) < 3 or bool(
        np.mean(at_height > max(_LEAST_STEP_M, 0.5 * abs(step))) >= _UPRIGHT_SHARE
    )


def is_free_above(profile: FrontProfile, left: BinRange, right: BinRange) -> bool:
    """Decides whether the lower side is empty where the higher one still has wall.

    Between galleries, dormers and badly seen storeys, the recognised wall ends higher here and lower there,
    but above it the house goes on.
    """
    parts = last_bins(left, REACH_BINS), first_bins(right, REACH_BINS)
    tops = _median_tops(profile, parts)
    if not np.isfinite(tops).all():
        return True
    first, last = sorted(int((top - profile.base) / BIN_M) + 1 for top in tops)
    full = [np.isfinite(profile.relief[part, first:last]) for part in parts]
    if not full[0].size:
        return True
    low, high = (full[i].mean() for i in np.argsort(tops))
    return bool(low < _REMAINDER * high)


def is_step_kept(profile: FrontProfile, left: BinRange, right: BinRange) -> bool:
    """Decides whether the higher side stays higher as far as the narrowest house would reach.

    A stair house or a chimney on a roof that is narrower is no neighbour. Nor are dormers: between them, the
    eaves of the lower side go on.
    """
    parts = last_bins(left, REACH_BINS), first_bins(right, REACH_BINS)
    tops = _median_tops(profile, parts)
    if not np.isfinite(tops).all():
        return True
    top = profile.top[parts[int(np.argmax(tops))]]
    top = top[np.isfinite(top)]
    higher = np.flatnonzero(top > np.mean(tops))
    if len(higher) < _KEPT * len(top):
        return False
    between = top[higher[0] : higher[-1]]
    return bool((np.abs(between - min(tops)) < FLOOR["eaves"]).sum() < _FEWEST_BETWEEN)


def does_cornice_continue(profile: FrontProfile, left: BinRange, right: BinRange) -> bool:
    """Decides whether the relief under the lower eaves is the same on both sides, at the same height.

    Then what rises above one of them is a railing or a parapet (or was measured there only), and not the
    wall of a neighbour. The height bin of the eaves is left out, because wall fills only a part of it. The
    relief of neighbours whose storeys differ by a bin fits much better when one side is shifted by it.
    """
    parts = last_bins(left, NEAR_BINS), first_bins(right, NEAR_BINS)
    tops = _median_tops(profile, parts)
    if not np.isfinite(tops).all():
        return False
    last = int((min(tops) - profile.base) / BIN_M)
    rows = slice(max(0, last - _CROWN_BINS), max(0, last))
    a, b = (median_of_bins(profile.relief[part, rows]) for part in parts)
    known = np.isfinite(a) & np.isfinite(b)
    if known.sum() < _CROWN_BINS // 2 or min(np.std(a[known]), np.std(b[known])) < _MOULDED_M:
        return False
    same = _correlation(a, b)
    shifted = max(_correlation(a[1:], b[:-1]), _correlation(a[:-1], b[1:]))
    doubt = _SIGMAS / np.sqrt(known.sum() - 3)  # of a correlation's Fisher transform
    return same > _SAME_CORNICE and np.arctanh(shifted) <= np.arctanh(same) + doubt


def is_gable(profile: FrontProfile, left: BinRange, right: BinRange) -> bool:
    """Decides whether the tops over both sides rise to a ridge and fall again alike, as over one gable.

    What stands behind a gable may rise above its slopes, so that they seem to have a step.
    """
    top = profile.top[left[0] : right[1]]
    known = np.isfinite(top)
    if known.sum() < 2 * NEAR_BINS:
        return False
    top = np.interp(np.arange(len(top)), np.flatnonzero(known), top[known])
    end = max(len(top) // _ENDS, 1)
    if np.median(top[end:-end]) - max(top[:end].mean(), top[-end:].mean()) < _RIDGE_M:
        return False
    alike = [_mirrored(top[k:]) for k in range(end)] + [_mirrored(top[: len(top) - k]) for k in range(end)]
    return max(alike) >= _ALIKE


def _mirrored(top: Float) -> float:
    """Returns the share of the tops (n,) m that are as high as their mirror images about the middle."""
    return float((np.abs(top - top[::-1]) < _SAME_TOP_M).mean())


def _correlation(a: Float, b: Float) -> float:
    """Returns the correlation of two reliefs (r,) where both are known, at most 0.999; 0 if one is flat."""
    known = np.isfinite(a) & np.isfinite(b)
    if known.sum() < 2 or min(np.std(a[known]), np.std(b[known])) == 0:
        return 0.0
    return float(np.clip(np.corrcoef(a[known], b[known])[0, 1], -0.999, 0.999))


def _median_tops(profile: FrontProfile, parts: tuple[slice, slice]) -> list[Float]:
    """Median height (m local z) of the eaves in each part."""
    return [median_of_bins(profile.top[part, None])[0] for part in parts]
