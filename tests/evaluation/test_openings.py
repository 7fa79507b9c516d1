"""Scoring of openings."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.evaluation.bars import joined, match_bars
from frontage.evaluation.openings import score_openings
from frontage.geometry.rigid import Rigid3
from truth_tables import found_opening, found_openings, truth


def test_a_perfect_result_is_perfect() -> None:
    t = truth()
    part = score_openings(t, found_openings(t))
    f = part.figures
    for name in ("precision_50", "recall_50", "f1_50", "f1_75", "f1_visible_75", "iou", "kind_right"):
        assert f[name].value == pytest.approx(1.0), name
    for name in ("shape_right", "bars_exact", "recall_hidden_50", "recall_shuttered_50"):
        assert f[name].value == pytest.approx(1.0), name
    for name in ("border_p95", "border_left_bias", "depth_median", "bars_median"):
        assert f[name].value == pytest.approx(0.0, abs=1e-9), name
    assert f["f1_50"].n == 10  # the hidden and the shuttered one are not counted
    assert len(part.items) == 12 and not part.notes


def test_an_empty_result_has_zero_recall_and_no_border_errors() -> None:
    f = score_openings(truth(), []).figures
    assert f["recall_50"].value == 0.0 and f["f1_50"].value == 0.0
    assert f["precision_50"].value is None and f["border_median"].value is None
    assert f["border_median"].n == 0


def test_hidden_and_shuttered_openings_cannot_be_missed() -> None:
    t = truth()
    kept = [o for o in found_openings(t) if o.id not in ("B01/F1/W1-2", "B02/F1/W1-2")]
    f = score_openings(t, kept).figures
    assert f["f1_50"].value == 1.0
    assert f["recall_hidden_50"].value == 0.0 and f["recall_shuttered_50"].value == 0.0


def test_missed_and_invented_openings_are_counted() -> None:
    t = truth()
    found = found_openings(t)[:-4]  # four of B02 missed, one of them shuttered
    facade = t.facades[0]
    phantom = found_opening(facade, facade.openings[0], np.array([-0.9, -1.1, 0.0, 0.0]))
    f = score_openings(t, [*found, phantom]).figures
    assert f["recall_50"].value == pytest.approx(7 / 10)
    assert f["precision_50"].value == pytest.approx(7 / 8)
    assert f["f1_50"].low < f["f1_50"].value < f["f1_50"].high


def test_signed_borders_tell_which_side_is_off() -> None:
    t = truth()
    move = np.array([0.03, -0.01, 0.02, 0.005])
    f = score_openings(t, found_openings(t, move=move)).figures
    for name, value in zip(("left", "right", "bottom", "top"), move, strict=True):
        assert f[f"border_{name}_bias"].value == pytest.approx(value, abs=1e-9)
    assert f["width_bias"].value == pytest.approx(-0.04)
    assert f["border_median"].value == pytest.approx(0.015)


def test_the_same_shift_fails_a_stricter_overlap() -> None:
    t = truth()
    f = score_openings(t, found_openings(t, move=np.array([0.3, 0.3, 0.0, 0.0]))).figures
    assert f["recall_50"].value == 1.0 and f["recall_75"].value == 0.0 and f["precision_75"].value == 0.0


def test_errors_are_compared_with_their_sigmas() -> None:
    t, rng = truth(), np.random.default_rng(0)
    sigma = dict.fromkeys(("left", "right", "bottom", "top", "depth"), 0.01)
    for claimed, low, high in ((1.0, 0.85, 1.15), (0.2, 4.0, 6.0)):
        found = [
            found_opening(f, o, rng.normal(0, 0.01, 4), depth=o.depth + rng.normal(0, 0.01),
                          sigma={k: v * claimed for k, v in sigma.items()})
            for _ in range(12) for f in t.facades for o in f.openings[:1]
        ]  # fmt: skip
        scored = [
            score_openings(t, found[k : k + 2]).figures["border_normalised"].value for k in range(0, 24, 2)
        ]
        assert low < float(np.sqrt(np.mean(np.square(scored)))) < high


def test_bars_must_be_all_there_and_nothing_else() -> None:
    t = truth()
    right = found_openings(t)
    assert score_openings(t, right).figures["bars_exact"].value == 1.0
    few = [found_opening(f, o, bars=()) for f in t.facades for o in f.openings]
    assert score_openings(t, few).figures["bars_exact"].value == 0.0
    silent = [found_opening(f, o, bars=None) for f in t.facades for o in f.openings]
    assert score_openings(t, silent).figures["bars_exact"].value is None
    counted = [found_opening(f, o, bars=None, counts=(1, 1)) for f in t.facades for o in f.openings]
    assert score_openings(t, counted).figures["bars_exact"].value == 1.0
    wrong = [found_opening(f, o, bars=None, counts=(1, 0)) for f in t.facades for o in f.openings]
    assert score_openings(t, wrong).figures["bars_exact"].value == 0.0


def test_undecided_layouts_are_as_bad_as_wrong_ones() -> None:
    t = truth()
    right = found_openings(t)
    none = [found_opening(f, o, bars=None) for f in t.facades for o in f.openings]
    f = score_openings(t, [*right[:6], *none[6:]]).figures
    assert f["bars_exact"].value == 1.0
    assert f["bars_right"].n == 11  # the closed shutters of B02 tell nothing, B01's hidden window was decided
    assert f["bars_right"].value == f["bars_decided"].value == pytest.approx(6 / 11)
    assert score_openings(t, none).figures["bars_right"].value is None


def test_openings_on_no_true_facade_are_not_scored() -> None:
    t = truth()
    side = Rigid3("local", "local", np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.zeros(3))
    found = found_openings(t)
    gable = found_opening(t.facades[0], t.facades[0].openings[0], ring=side.apply(found[0].ring))
    part = score_openings(t, [*found, gable])
    assert part.figures["precision_50"].value == 1.0
    assert part.notes == ("1 openings lie on no facade of the truth and are not scored",)


@pytest.mark.parametrize("step", [0.4, 0.9])
def test_openings_of_a_part_that_stands_out_are_not_those_of_the_wall_behind_it(step: float) -> None:
    t = truth()
    wall = t.facades[0]
    frame = replace(wall.frame, t=wall.frame.apply(np.array([[0.0, -step, 0.0]]))[0])
    moved = tuple(replace(o, ring=o.ring + np.array([0.6, 0.2])) for o in wall.openings)
    part = replace(wall, frame=frame, openings=moved)
    for facades in ((wall, part), (part, wall)):
        both = replace(t, facades=facades)
        assert score_openings(both, found_openings(both)).figures["f1_75"].value == pytest.approx(1.0)


def test_pieces_that_continue_each_other_are_one_bar() -> None:
    rows = joined([(1.0, 0.1, 0.55), (1.004, 0.65, 1.1), (1.0, 1.6, 2.0), (1.3, 0.1, 0.5)])
    np.testing.assert_allclose(rows, [[1.0, 1.6, 2.0], [1.002, 0.1, 1.1], [1.3, 0.1, 0.5]], atol=1e-9)
    row, column, exact = match_bars(np.array([[1.0, 0.1, 1.1]]), rows[1:2])
    assert exact and row.tolist() == column.tolist() == [0]
    assert not match_bars(np.array([[1.0, 0.1, 0.6]]), rows[1:2])[2]
