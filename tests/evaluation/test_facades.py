"""Scoring of facade planes."""

import numpy as np
import pytest

from frontage.evaluation.facades import plane_error, score_facades
from frontage.evaluation.result import FoundFacade
from frontage.geometry.rigid import Rigid3
from truth_tables import found_facade, truth

MM = np.diag([1e-2, 1e-3, 1e-2, 1e-4, 1e-4, 1e-4]) ** 2


def test_a_perfect_plane_has_no_error() -> None:
    t = truth()
    f = score_facades(t, [found_facade(f) for f in t.facades]).figures
    assert f["recall"].value == 1.0 and f["outline_iou"].value == pytest.approx(1.0)
    assert f["offset_rms"].value == pytest.approx(0.0, abs=1e-9)
    assert f["angle_p95"].value == pytest.approx(0.0, abs=1e-6)


def test_offset_and_angle_are_recovered() -> None:
    t = truth()
    f = score_facades(t, [found_facade(f, 0.02, np.radians(0.5)) for f in t.facades]).figures
    assert f["offset_bias"].value == pytest.approx(-0.02, abs=1e-5)
    assert f["angle_median"].value == pytest.approx(0.5, abs=1e-6)


def test_the_error_is_the_tangent_that_leads_to_the_truth() -> None:
    facade = truth().facades[0]
    found = found_facade(facade, 0.01, 0.003)
    offset, about_x, about_z = plane_error(facade, found)
    c, s = np.cos(about_z), np.sin(about_z)
    R = found.frame.R @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    at = found.frame.t + offset * found.frame.R[:, 1]
    corrected = FoundFacade("", "", Rigid3("local", "facade", R, at), found.outline)
    assert abs(about_x) < 1e-12
    assert np.abs(plane_error(facade, corrected)).max() < 1e-9


def test_a_plane_that_faces_the_wrong_way_is_not_matched() -> None:
    t = truth()
    turned = [found_facade(f, turn=np.pi) for f in t.facades]
    part = score_facades(t, turned)
    assert part.figures["recall"].value == 0.0 and part.figures["elsewhere"].value == 2
    assert {row["found"] for row in part.items} == {None}


def test_reported_covariances_are_tested() -> None:
    t, rng = truth(), np.random.default_rng(1)
    for claimed, low, high in ((1.0, 0.7, 1.3), (0.1, 7.0, 13.0)):
        squared = []
        for _ in range(60):
            found = [
                found_facade(f, rng.normal(0, 1e-3), rng.normal(0, 1e-4), MM * claimed**2) for f in t.facades
            ]
            squared.append(score_facades(t, found).figures["plane_normalised"].value ** 2)
        assert low < np.sqrt(np.mean(squared) * 1.5) < high  # two of three directions were disturbed


def test_no_facades_give_empty_metrics() -> None:
    f = score_facades(truth(), []).figures
    assert f["recall"].value == 0.0 and f["offset_median"].value is None
