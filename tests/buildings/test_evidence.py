"""What counts as a step of the eaves, and what does not."""

import numpy as np

from frontage.buildings.fronts.profile import BIN_M, FrontProfile
from frontage.buildings.split.channels import channels
from frontage.buildings.split.evidence import SplitEvidence
from frontage.buildings.split.verdict import Verdict, judge_cut

_N, _LOW, _HIGH = 80, 10.0, 12.0  # bins; m, eaves left and right of bin 40


def _verdict(empty: bool, cornice: float = 0.0) -> Verdict:
    """Of a step of the eaves at bin 40; `empty` above the lower side or not; on both sides a `cornice` sticks
    out so many m below the lower eaves."""
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


def test_a_step_of_the_eaves_parts_houses() -> None:
    found = _verdict(empty=True)
    assert found.convincing
    assert found.cues == ("eaves",)


def test_no_step_where_the_house_goes_on_above_the_lower_side() -> None:
    assert not _verdict(empty=False).cues


def test_what_rises_over_one_cornice_is_a_parapet() -> None:
    found = _verdict(empty=True, cornice=0.4)
    assert found.cues == ("eaves",)
    assert not found.convincing
