"""Metrics with their intervals, and the scoring of poses."""

import numpy as np
import pytest

from frontage.errors import InputError
from frontage.evaluation.metric import detections, mean, median, metric, normalised
from frontage.evaluation.poses import score_poses
from frontage.evaluation.result import FoundPose
from frontage.evaluation.truth import read_truth
from frontage.geometry.rigid import Rigid3
from truth_tables import table, truth


def test_an_interval_covers_the_truth_about_as_often_as_it_says() -> None:
    rng = np.random.default_rng(0)
    hits = 0
    for seed in range(150):
        f = metric(rng.normal(3.0, 2.0, 40), mean, seed=seed)
        hits += f.low <= 3.0 <= f.high
    assert 0.88 <= hits / 150 <= 0.99


def test_the_same_items_give_the_same_interval() -> None:
    values = np.arange(20.0)
    assert metric(values, median) == metric(values, median)
    assert metric(values[:1], median).low is None and metric(values[:0], median).value is None


def test_detection_rates() -> None:
    rows = np.array([[1, 0, 0]] * 6 + [[0, 1, 0]] * 2 + [[0, 0, 1]] * 4)
    f = detections(rows)
    assert (f["precision"].value, f["recall"].value) == (0.75, 0.6)
    assert f["f1"].value == pytest.approx(2 * 0.75 * 0.6 / 1.35)


def test_normalised_errors_show_too_small_sigmas() -> None:
    errors = np.random.default_rng(1).normal(0, 1, 4000)
    honest, vain = normalised(errors, "e"), normalised(errors / 0.25, "e")
    assert honest["e_normalised"].value == pytest.approx(1.0, abs=0.03)
    assert honest["e_within_95"].value == pytest.approx(0.95, abs=0.02)
    assert vain["e_normalised"].value == pytest.approx(4.0, abs=0.1) and vain["e_within_95"].value < 0.5


def test_poses_are_compared_by_name() -> None:
    t = truth().photos
    move, turn = np.array([0.03, 0.0, 0.04]), 0.001
    R = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    pose = Rigid3("local", "camera", R @ t[0].true.R, t[0].true.t + move)
    f = score_poses(t, [FoundPose("a.jpg", pose, np.full(3, 0.03), np.full(3, 0.001))]).figures
    assert f["position_median"].value == pytest.approx(0.05)
    assert f["angle_median"].value == pytest.approx(np.degrees(turn))
    assert f["position_normalised"].n == 3 and f["angle_normalised"].value == pytest.approx(1 / np.sqrt(3))
    assert score_poses(t, [FoundPose("b.jpg", pose)]).figures["recall"].value == 0.0


@pytest.mark.parametrize("damage", [{"schema": 9}, {"facades": [{}]}, {"origin": "here"}])
def test_a_file_that_is_not_a_truth_is_refused(damage: dict) -> None:
    with pytest.raises(InputError, match=r"truth\.json"):
        read_truth(table() | damage)
