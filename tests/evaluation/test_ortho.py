"""Scoring of ortho-images."""

import cv2
import numpy as np
import pytest

from frontage.evaluation.ortho import displacements, score_orthos
from frontage.evaluation.result import OrthoPair


def wall(seed: int = 0, shape: tuple[int, int] = (620, 900)) -> np.ndarray:
    rng = np.random.default_rng(seed)
    grey = cv2.GaussianBlur(rng.normal(0, 1, shape).astype(np.float32), (0, 0), 1.5)
    grey += 0.6 * cv2.GaussianBlur(rng.normal(0, 1, shape).astype(np.float32), (0, 0), 4)
    return np.repeat(np.clip(128 + 160 * grey / np.abs(grey).max(), 1, 255).astype(np.uint8)[..., None], 3, 2)


def pair(found: np.ndarray, true: np.ndarray, **more: object) -> OrthoPair:
    everywhere, none = np.ones(true.shape[:2], bool), np.zeros(true.shape[:2], int)
    return OrthoPair("B01/F1", true, found, everywhere, none, 0.01, 0.01, **more)  # type: ignore[arg-type]


@pytest.mark.parametrize("shift", [(0.0, 0.0), (1.3, -0.7), (-6.25, 4.5), (0.2, 0.3)])
def test_a_shift_is_found_to_a_twentieth_of_a_pixel(shift: tuple[float, float]) -> None:
    true = wall()
    M = np.array([[1, 0, shift[0]], [0, 1, shift[1]]], np.float64)
    found = cv2.warpAffine(true, M, true.shape[1::-1], flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)
    shifts, scores = displacements(pair(found, true))
    assert len(shifts) > 20 and (scores > 0.9).all()
    assert np.abs(shifts - shift).max() < 0.05


def test_light_and_noise_do_not_count_as_displacement() -> None:
    true = wall()
    noise = np.random.default_rng(2).normal(0, 6, true.shape)
    found = np.clip(0.5 * true + 60 + noise, 0, 255).astype(np.uint8)
    part = score_orthos([pair(found, true)])
    assert part.figures["displacement_px_p95"].value < 0.2
    assert part.figures["alike"].value == 1.0


def test_another_wall_matches_nowhere() -> None:
    part = score_orthos([pair(wall(1), wall(0))])
    assert part.figures["alike"].value < 0.1
    assert part.figures["coverage"].value == 1.0


def test_a_car_in_front_of_the_wall_is_left_out() -> None:
    true = wall()
    found = true.copy()
    found[300:, 200:650] = wall(5)[300:, 200:650]
    f = score_orthos([pair(found, true)]).figures
    assert f["displacement_px_p95"].value < 0.1 and 0.4 < f["alike"].value < 0.9


def test_missing_pixels_reduce_coverage_and_the_relief_is_compared() -> None:
    true = wall()
    valid = np.ones(true.shape[:2], bool)
    valid[:, :300] = False
    depth = np.zeros(true.shape[:2])
    p = OrthoPair("F", np.where(valid[..., None], true, true), np.where(valid[..., None], true, 0), valid,
                  np.zeros(true.shape[:2], int), 0.01, 0.005, depth, depth + 0.012)  # fmt: skip
    f = score_orthos([p]).figures
    assert f["coverage"].value == pytest.approx(2 / 3)
    assert f["relief_bias"].value == pytest.approx(0.012)


def test_no_ortho_images_give_empty_metrics() -> None:
    f = score_orthos([]).figures
    assert f["displacement_median"].value is None and f["tiles"].value == 0
