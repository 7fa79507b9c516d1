"""Which steps of the eaves separate houses."""

import numpy as np

from frontage.buildings.fronts.profile import BIN_M, FrontProfile
from frontage.buildings.split.channels import channels
from frontage.buildings.split.evidence import SplitEvidence
from frontage.buildings.split.verdict import Verdict, judge_cut

_N, _LOW, _HIGH = 80, 10.0, 12.0  # bins; m, eaves left and right of bin 40


def _verdict(empty: bool, cornice: float = 0.0) -> Verdict:
    """Judges a step of the eaves at bin 40.

    empty    whether nothing was measured above the lower side
    cornice  m, by which a moulding projects below the lower eaves on both sides
    """
    n, rows = _N, round(_HIGH / BIN_M)
    top = np.repeat([_LOW, _HIGH], n // 2)
    relief = np.zeros((n, rows))
    low = round(_LOW / BIN_M)
    relief[:, low - 2 : low] = cornice
    if empty:
        relief[: n // 2, low + 1 :] = np.nan
    flat = np.zeros(n)
    nothing = np.full(n, np.nan)
    profile = FrontProfile(
        0.0, flat, top, nothing, np.full((n, 6), np.nan), nothing, np.ones((n, rows)), relief, 0.0, flat + 100
    )
    signal, kinds = channels(profile)
    evidence = SplitEvidence(profile, signal, kinds, np.full_like(signal, 0.05), [], 0.25)
    return judge_cut(evidence, [n // 2], 0)


def test_a_step_of_the_eaves_separates_houses() -> None:
    found = _verdict(empty=True)
    assert found.convincing
    assert found.cues == ("eaves",)


def test_a_house_that_continues_above_the_lower_side_has_no_step() -> None:
    assert not _verdict(empty=False).cues


def test_a_wall_above_a_continuous_cornice_is_a_parapet() -> None:
    found = _verdict(empty=True, cornice=0.4)
    assert found.cues == ("eaves",)
    assert not found.convincing
