"""The cues for a party wall between two sides of a front, each with its size in standard errors.

Both sides are compared in every channel of the profile, and in the rhythm of their openings.
"""

import numpy as np

from frontage.buildings.fronts.profile import BIN_M
from frontage.buildings.split.channels import FLOOR
from frontage.buildings.split.evidence import (
    MAD_TO_SIGMA,
    NEAR_BINS,
    REACH_BINS,
    BinRange,
    SplitEvidence,
    first_bins,
    last_bins,
)
from frontage.buildings.split.relief import (
    does_cornice_continue,
    is_free_above,
    is_gable,
    is_step_kept,
    is_step_upright,
)
from frontage.geometry.arrays import Float

# least step of each kind of channel: m, m, m, Delta E (Lab), log intensity
STEP = {"eaves": 0.4, "offset": 0.05, "rough": 0.015, "colour": 6.0, "bright": 0.2}
SURE = 4.0  # standard errors from which a cue is conclusive
_ALONE = 5.0  # standard errors from which it needs no other: as much as a sure cue and a hint together
_HINT = 3.0  # standard errors from which a cue confirms another
_LOW_STEP = 0.5  # share of a conclusive eaves step that confirms another cue
_STEEP = 0.02  # share of a wall's height; seen steeply, a cornice's depth moves the top that it shows
_DISTANCE_M = 10.0  # from which a front is scanned across a street (assumed)
_FEWEST_BINS = 4  # measured on each side of a step
_RHYTHM_BINS = 12  # bins of each side from which its openings show a rhythm
_RHYTHM_ROWS = 8  # height bins, from which they do
_BELOW_EAVES = 0.2  # mean number of occupied height bins above, from which a height is below the eaves
_LEVEL, _LEVEL_SIGMAS = 2 / 3, 0.967  # share of a side with level eaves; that quantile of a Gaussian's |x|
_UNLIKE = 0.5  # mean square difference of levelled row profiles: a correlation of 3/4
_LEAST_OWN = 0.02  # the least mean square difference between the halves of one side
_RHYTHM_GAIN = 2.0  # standard errors per ratio of the spreads
_OF_WINGS = ("eaves", "rough")  # cues that wings under one cornice give as neighbours do


def compare_sides(
    evidence: SplitEvidence, left: BinRange, right: BinRange, spread: Float
) -> tuple[dict[str, float], bool]:
    """Returns the cues (name: standard errors) that part two sides, and whether the eaves suffice alone.

    Where one cornice runs over both sides they are one building's wings as a rule: parapets, relief and
    openings differ between wings, so only the plane and the surface tell of a neighbour there, and another
    rhythm where the surface changes beyond doubt.

    spread (p,): of every channel within a house
    """
    profile = evidence.profile
    cues: dict[str, float] = {}
    common = does_cornice_continue(profile, left, right)
    alone, tall = False, profile.rows.shape[1] * BIN_M
    for k, kind in enumerate(evidence.kinds):
        step, t = difference(evidence, k, left, right, spread[k])
        least = max(STEP[kind], _STEEP * tall) if kind == "eaves" else least_step(evidence, k, left, right)
        if t > SURE and abs(step) > least:
            alone |= kind == "eaves" and not common and t > _ALONE
        elif kind == "eaves":
            least *= _LOW_STEP
        is_step = t > _HINT and abs(step) > least
        if is_step and (kind != "offset" or is_step_upright(profile, left, right, step)):
            name = cue_of(kind)
            cues[name] = max(cues.get(name, 0.0), t)
    rows = profile.rows
    t = _rhythm(rows[last_bins(left, 2 * REACH_BINS)], rows[first_bins(right, 2 * REACH_BINS)])
    if t > _HINT:
        cues["rhythm"] = t
    if common:
        painted = cues.get("surface", 0.0) > SURE  # neighbours paint each their own house
        wings = _OF_WINGS if painted else (*_OF_WINGS, "rhythm")
        cues = {name: t for name, t in cues.items() if name not in wings}
    return cues, alone


def least_step(evidence: SplitEvidence, k: int, left: BinRange, right: BinRange) -> float:
    """Returns the least step of channel k that may part two sides.

    Intensity falls with the square of the distance: where one side stands further back, that much is no sign
    of another paint.
    """
    kind = evidence.kinds[k]
    if kind != "bright":
        return STEP[kind]
    back, _ = difference(evidence, evidence.kinds.index("offset"), left, right, np.nan)
    return STEP[kind] + 2.0 * abs(back) / _DISTANCE_M


def cue_of(kind: str) -> str:
    """Returns the cue that a kind of channel gives; colour and intensity see the same paint."""
    return "surface" if kind in ("colour", "bright") else kind


def difference(
    evidence: SplitEvidence, k: int, left: BinRange, right: BinRange, spread: float
) -> tuple[float, float]:
    """Returns the step of channel k from the left to the right side, and its size in standard errors."""
    kind = evidence.kinds[k]
    floor = max(FLOOR[kind], evidence.cell / 4) if kind == "eaves" else FLOOR[kind]
    reach = NEAR_BINS if kind == "offset" else REACH_BINS
    own = max(spread, floor) if np.isfinite(spread) else floor
    step, t = _step(evidence, k, last_bins(left, reach), first_bins(right, reach), own)
    if kind == "eaves":  # a step and not a slope: it shows close to the cut as well as far from it
        close, _ = _step(evidence, k, last_bins(left, NEAR_BINS), first_bins(right, NEAR_BINS), floor)
        step, t = (float(np.sign(step)) * min(abs(step), abs(close)), t) if step * close > 0 else (0.0, 0.0)
        profile = evidence.profile
        kept = is_free_above(profile, left, right) and is_step_kept(profile, left, right)
        if not kept or is_gable(profile, left, right):
            return 0.0, 0.0
    return step, t


def _step(evidence: SplitEvidence, k: int, left: slice, right: slice, spread: float) -> tuple[float, float]:
    """Returns the step of channel k between the medians of two stretches, and its size in standard errors.

    Bins within 1 m count as one observation. Each side adds what its sampling leaves open.
    """
    medians, variance, per = [], 0.0, 1.0 / BIN_M
    for part in (left, right):
        known = np.isfinite(evidence.signal[part, k])
        side, sampling = evidence.signal[part, k][known], evidence.sampling[part, k][known]
        if len(side) < _FEWEST_BINS:
            return 0.0, 0.0
        medians.append(float(np.median(side)))
        ragged = _raggedness(evidence.kinds[k], np.abs(side - medians[-1]))
        variance += (
            (max(spread, ragged) ** 2 + float(np.nan_to_num(np.median(sampling))) ** 2) * per / len(side)
        )
    step = medians[1] - medians[0]
    return step, abs(step) / float(np.sqrt(variance))


def _raggedness(kind: str, off: Float) -> float:
    """Returns one sigma of a side's bins, from their distances `off` (n,) to its median.

    A ragged side proves nothing. The eaves of a house are level along most of it, but where the scan ends
    within a row of windows, its upper end drops at every window.
    """
    sigma = MAD_TO_SIGMA * float(np.median(off))
    return max(sigma, float(np.quantile(off, _LEVEL)) / _LEVEL_SIGMAS) if kind == "eaves" else sigma


def _rhythm(a: Float, b: Float) -> float:
    """Measures how differently the openings of two sides (k, r) stand in height.

    The unit is the spread between the halves of each side.
    """
    if min(len(a), len(b)) < _RHYTHM_BINS:
        return 0.0
    above = [np.cumsum(x.mean(0)[::-1])[::-1] for x in (a, b)]
    both = np.minimum(*above) > _BELOW_EAVES
    if both.sum() < _RHYTHM_ROWS:
        return 0.0
    half = [
        _levelled(x.mean(0)[both])
        for x in (a[: len(a) // 2], a[len(a) // 2 :], b[: len(b) // 2], b[len(b) // 2 :])
    ]
    between = float(np.mean((_levelled(a.mean(0)[both]) - _levelled(b.mean(0)[both])) ** 2))
    own = 0.5 * float(np.mean((half[0] - half[1]) ** 2) + np.mean((half[2] - half[3]) ** 2))
    return float(np.sqrt(between / max(own, _LEAST_OWN)) * _RHYTHM_GAIN) if between > _UNLIKE else 0.0


def _levelled(share: Float) -> Float:
    """Removes the level and contrast of a row profile (r,), which depend on the density of the points."""
    spread = float(np.std(share))
    return (share - share.mean()) / spread if spread > 0 else np.zeros_like(share)
