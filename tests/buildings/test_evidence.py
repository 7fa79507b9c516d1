"""Which steps of the eaves separate houses."""

import numpy as np
import pytest

from frontage.buildings.fronts.profile import BIN_M, FrontProfile
from frontage.buildings.options import BuildingOptions
from frontage.buildings.split import verdict
from frontage.buildings.split.channels import channels
from frontage.buildings.split.evidence import SplitEvidence
from frontage.buildings.split.find import find_cuts
from frontage.buildings.split.verdict import Verdict, judge_cut
from frontage.geometry.arrays import Float

_N, _LOW, _HIGH = 80, 10.0, 12.0  # bins; m, eaves left and right of bin 40


def _verdict(
    empty: bool,
    cornice: float = 0.0,
    wings: bool = False,
    paint: float = 0.0,
    high: int = _N,
    gaps: tuple[int, ...] = (),
    edge: float = 0.0,
    lower: int = 0,
    moulding: tuple[int, int] = (2, 0),
) -> Verdict:
    """Judges a step of the eaves at bin 40.

    empty    whether nothing was measured above the lower side
    cornice  m, by which a moulding projects below the lower eaves on both sides
    wings    whether the right side is rougher and has its openings at other heights
    paint    Delta E, by which the right side has another colour
    high     bins of the right side that are higher than the left one
    gaps     bins of the right side that are not
    edge     m, by which the right side projects in the bin of the eaves
    lower    bins by which the moulding of the right side is lower
    moulding bins below the lower eaves where the moulding begins and ends
    """
    n, rows = _N, round(_HIGH / BIN_M)
    top = np.repeat([_LOW, _HIGH], n // 2)
    top[n // 2 + high :] = _LOW
    top[n // 2 + np.array(gaps, int)] = _LOW
    relief = np.zeros((n, rows))
    low = round(_LOW / BIN_M)
    foot, head = low - moulding[0], low - moulding[1]
    relief[: n // 2, foot:head] = cornice
    relief[n // 2 :, foot - lower : head - lower] = cornice
    relief[n // 2 :, low] += edge
    if empty:
        relief[: n // 2, low + 1 :] = np.nan
    flat = np.zeros(n)
    nothing = np.full(n, np.nan)
    rough, walls = nothing.copy(), np.ones((n, rows))
    if wings:
        rough = np.repeat([0.005, 0.1], n // 2)
        for first, step in ((0, 0), (n // 2, 6)):
            walls[first : first + n // 2, 4 + step : 10 + step] = 0.0
            walls[first : first + n // 2, 20 + step : 26 + step] = 0.0
    colour = np.full((n, 6), np.nan)
    if paint:
        colour = np.repeat([50.0, 50.0 + paint], n // 2)[:, None] * np.ones(6)
    profile = FrontProfile(0.0, flat, top, rough, colour, nothing, walls, relief, 0.0, flat + 100)
    signal, kinds = channels(profile)
    evidence = SplitEvidence(profile, signal, kinds, np.full_like(signal, 0.05), [], 0.25)
    return judge_cut(evidence, [n // 2], 0)


def test_a_step_of_the_eaves_separates_houses() -> None:
    found = _verdict(empty=True)
    assert found.convincing
    assert found.cues == ("eaves",)


def test_a_stair_house_that_is_narrower_than_a_house_is_none() -> None:
    assert _verdict(empty=True, high=20).cues == ("eaves",)
    assert not _verdict(empty=True, high=14).cues  # 3.5 of the 6 m beside the cut


def test_level_eaves_are_no_step() -> None:
    assert not _verdict(empty=True, high=0).cues


def test_dormers_over_eaves_that_go_on_are_no_house() -> None:
    assert _verdict(empty=True, gaps=(7,)).cues == ("eaves",)
    assert not _verdict(empty=True, gaps=(5, 6, 7, 13, 14, 15)).cues


def test_a_house_that_continues_above_the_lower_side_has_no_step() -> None:
    assert not _verdict(empty=False).cues


def test_a_wall_above_a_continuous_cornice_is_a_parapet() -> None:
    found = _verdict(empty=True, cornice=0.4)
    assert not found.cues
    assert not found.convincing


def test_a_cornice_continues_whatever_its_topmost_bin_shows() -> None:
    """Wall fills only a part of that bin, and noise decides which part."""
    assert not _verdict(empty=True, cornice=0.4, edge=-0.5).cues


def test_storeys_at_two_heights_have_no_common_cornice() -> None:
    """The reliefs are alike, and more so when one side is shifted."""
    assert _verdict(empty=True, cornice=0.4, lower=1).cues == ("eaves",)
    assert _verdict(empty=True, cornice=0.4, lower=1, moulding=(20, 6)).cues == ("eaves",)
    assert not _verdict(empty=True, cornice=0.4, moulding=(20, 6)).cues


def test_wings_under_one_cornice_may_differ_in_relief_and_openings() -> None:
    assert {"rough", "rhythm"} <= set(_verdict(empty=False, wings=True).cues)
    found = _verdict(empty=False, cornice=0.4, wings=True)
    assert not found.cues
    assert not found.convincing


def test_houses_under_one_cornice_differ_in_paint_and_openings() -> None:
    found = _verdict(empty=False, cornice=0.4, wings=True, paint=30.0)
    assert {"surface", "rhythm"} == set(found.cues)
    assert found.convincing


@pytest.mark.parametrize(("sigmas", "convincing"), [(3.3, False), (3.6, True)])
def test_two_weak_cues_do_not_cut(sigmas: float, convincing: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    told = ({"rhythm": sigmas, "surface": sigmas}, False)
    monkeypatch.setattr(verdict, "compare_sides", lambda *_: told)
    assert _verdict(empty=True).convincing == convincing


def _profile(top: Float, offset: Float, bright: Float) -> FrontProfile:
    """Returns a front of one colour, with the eaves, the place and the log intensity of every bin (n,)."""
    n, rows = len(top), round(_HIGH / BIN_M)
    wall, above = np.ones((n, rows)), np.where(BIN_M * np.arange(rows) > top[:, None], np.nan, 0.0)
    rough, colour = np.full(n, np.nan), np.full((n, 6), 50.0)
    return FrontProfile(0.0, offset, top, rough, colour, bright, wall, above, 0.0, np.full(n, 100.0))


@pytest.mark.parametrize(("back", "is_cue"), [(5.0, False), (0.1, True)])
def test_intensity_that_falls_with_the_distance_is_no_other_paint(back: float, is_cue: bool) -> None:
    """What lies 15 m away returns half of what the wing before it does, which lies 10 m away."""
    right = np.arange(_N) >= _N // 2
    profile = _profile(np.full(_N, _LOW), np.where(right, -back, 0.0), np.where(right, -0.7, 0.0))
    signal, kinds = channels(profile)
    evidence = SplitEvidence(profile, signal, kinds, np.full_like(signal, 0.05), [], 0.25)
    assert ("surface" in judge_cut(evidence, [_N // 2], 0).cues) is is_cue


def test_an_avant_corps_is_no_neighbour_though_a_tree_hides_one_of_its_eaves() -> None:
    place = np.arange(120)
    middle = (place >= 44) & (place < 72)
    top, bright = np.where(middle, _HIGH, _LOW), np.where(middle, 0.5, 0.0)  # seen by another scanner
    top[66:74] = np.nan
    profile = _profile(top, np.where(middle, 0.4, 0.0), bright)
    assert not find_cuts(profile, BuildingOptions(), np.zeros(len(top), np.bool_))


@pytest.mark.parametrize("gable", [True, False])
def test_the_slope_of_a_gable_that_a_chimney_steps_over_is_no_neighbour(gable: bool) -> None:
    """The counterpart is a higher house beside a lower one."""
    place = np.arange(48)
    slopes = 6.8 + 0.22 * np.minimum(place, place[::-1])
    top = slopes if gable else np.where(place < 24, 8.0, 11.5)
    top[(place > 15) & (place < 32)] = 11.4  # what stands behind them
    profile = _profile(top, np.zeros(48), np.where(place < 32, 0.0, 0.4))
    assert bool(find_cuts(profile, BuildingOptions(), np.zeros(48, np.bool_))) is not gable


@pytest.mark.parametrize("window", [True, False])
def test_the_end_of_a_scan_in_a_row_of_windows_is_no_step_of_the_eaves(window: bool) -> None:
    """The counterpart is lower from end to end."""
    place, cut = np.arange(80), 15
    top = np.where(place < cut, 9.0, 10.0)
    top[:6] += window
    profile = _profile(top, np.zeros(80), np.zeros(80))
    signal, kinds = channels(profile)
    evidence = SplitEvidence(profile, signal, kinds, np.full_like(signal, 0.05), [], 0.25)
    assert judge_cut(evidence, [cut], 0).convincing is not window
