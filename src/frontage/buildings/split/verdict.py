"""Judge a cut by its cues, and move it to the step of the channels that speak for it.

A step of the wall's plane counts only where it runs from the foot to the eaves: a piece that starts above the
ground floor or ends below the roof is a bay or an oriel.
"""

from dataclasses import dataclass

import numpy as np

from frontage.buildings.split.channels import FLOOR, sharpest
from frontage.buildings.split.cues import compare_sides, cue_of
from frontage.buildings.split.evidence import NEAR_BINS, SplitEvidence, spread_within

_GAP_CUE = 9.0  # standard errors that an open gap counts as
_LEAST_ODDS = float(np.log(9.0))  # log odds from which two cues together make a cut: 90 %
_MOST_ODDS = 20.0  # log odds of a cut


PLACED = frozenset({"eaves", "offset", "surface", "gap"})
"""Cues that tell where a party wall is, not only that one is."""


@dataclass(frozen=True)
class Verdict:
    """The cues for a cut, whether they are convincing, and the log odds for it."""

    cues: tuple[str, ...]
    convincing: bool
    odds: float


def judge_cut(evidence: SplitEvidence, cuts: list[int], i: int) -> Verdict:
    """Judges cut i among its neighbours.

    An eaves step or a gap convinces alone. Any other cue needs a second one, and both together must make a
    party wall at least 90 % likely.
    """
    left, right = evidence.sides(cuts, i)
    cues, alone = compare_sides(evidence, left, right, spread_within(evidence, cuts))
    if any(a <= cuts[i] <= b for a, b in evidence.gaps):
        cues["gap"], alone = _GAP_CUE, True
    odds: float = sum(min(t * t / 2, 12.0) - 4.0 for t in cues.values()) - 2.0
    convincing = alone or (len(cues) >= 2 and odds > _LEAST_ODDS and bool(PLACED & cues.keys()))
    return Verdict(tuple(sorted(cues)), convincing, float(np.clip(odds, -_MOST_ODDS, _MOST_ODDS)))


def settle_cuts(evidence: SplitEvidence, cuts: list[int], cues: list[tuple[str, ...]]) -> list[int]:
    """Moves each cut to the step of the channels that speak for it.

    A piece may become narrower than houses are looked for (a bay between two of them), but no narrower than
    the stretch that its eaves and its plane are taken from.
    """
    names = [cue_of(kind) for kind in evidence.kinds]
    floor = np.array([FLOOR[kind] for kind in evidence.kinds])
    spread = np.nan_to_num(spread_within(evidence, cuts))
    sigma = np.sqrt(spread**2 + floor**2 + evidence.sampling**2)
    tells = [np.array([name in own for name in names]) for own in cues]
    places = sharpest(evidence.signal, sigma, np.array(cuts, np.int64), NEAR_BINS, tells)
    return [int(c) for c in places]
