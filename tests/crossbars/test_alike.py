"""Frames of one type stand at one depth."""

import numpy as np
import pytest

from crossbars.painted import DEPTH, EYES, HOLE, MULLION, view, window
from frontage.crossbars.alike import types, with_one_depth
from frontage.crossbars.observe import Sight, look

LARGER = (HOLE[0], HOLE[1], HOLE[2] + 0.3, HOLE[3])


def seen(depth: float, number: int, eyes: int = 3) -> Sight:
    """Returns what some of the eyes see of a window whose depth m the scan measured with an error of 1 cm."""
    views = [view(eye, (MULLION,)) for eye in EYES[3 - eyes :]]
    return look(window(views, depth=depth, name=f"B01/F1/W1-{number}"))


def depth_of(sight: Sight) -> tuple[float, float]:
    assert sight.depth is not None
    return float(sight.depth.value), float(sight.depth.sigma[0])


def test_windows_of_one_shape_and_size_are_of_one_type() -> None:
    other = look(window([view(eye, hole=LARGER) for eye in EYES], hole=LARGER))
    assert types([seen(DEPTH, 1), other, seen(DEPTH, 2)]) == [[0, 2], [1]]


def test_a_window_takes_over_the_depth_of_its_type() -> None:
    alone = seen(DEPTH + 0.03, 3, eyes=1)
    assert depth_of(alone)[0] == pytest.approx(DEPTH + 0.03)  # one view tells no depth
    found = depth_of(with_one_depth([seen(DEPTH, 1), seen(DEPTH, 2), alone])[2])
    assert found[0] == pytest.approx(DEPTH, abs=0.015)
    assert found[1] < depth_of(alone)[1]


def test_a_frame_that_stands_elsewhere_keeps_its_depth() -> None:
    elsewhere = seen(DEPTH + 0.2, 3, eyes=1)
    found = with_one_depth([seen(DEPTH, 1), seen(DEPTH, 2), elsewhere])
    assert depth_of(found[2])[0] == pytest.approx(DEPTH + 0.2)


def test_windows_that_only_the_scan_shows_keep_their_depths() -> None:
    sights = [look(window([], depth=depth)) for depth in (0.10, 0.12)]
    assert np.allclose([depth_of(s)[0] for s in with_one_depth(sights)], (0.10, 0.12))


def test_frames_that_are_set_differently_share_little() -> None:
    depths = (DEPTH - 0.04, DEPTH, DEPTH + 0.04)
    found = with_one_depth([seen(depth, k, eyes=1) for k, depth in enumerate(depths)])
    assert np.allclose([depth_of(s)[0] for s in found], depths, atol=0.006)
