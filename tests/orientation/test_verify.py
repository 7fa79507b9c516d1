"""A right pose is confirmed; one that is off by a window, and a picture of something else, are not."""

import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3
from frontage.model import Camera
from frontage.orientation.reflectance.surface import scanned_surface
from frontage.orientation.verify import verify
from orientation.paintedwalls import Wall, looking, paint, photograph, posed, scan_of, windows

PITCH = 2.0  # m, of the windows: less than what is searched
CAMERA = Camera("PINHOLE", 1000, 750, np.array([700.0, 700.0, 503.0, 372.0]))
SPACING = 0.06
SQUARE = looking(9.0, -12.0, pitch=0.0)
TILTED = looking(9.0, -12.0, heading=10.0, pitch=8.0)
MOVES = {"right": (PITCH, 0.0, 0.0), "left": (-PITCH, 0.0, 0.0), "up": (0.0, 0.0, PITCH)}


def facade(texture):
    """Equal windows on a wall with a share of texture, as plaster has."""
    tones = windows(18.0, 9.0, PITCH) * (1 - texture / 2 + texture * paint(18.0, 9.0))
    return Wall((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), np.clip(tones, 0.05, 1.0))


class View:
    """A wall, its scan, and a photo of it from a true pose."""

    def __init__(self, wall, true, spacing=SPACING):
        self.true, self.surface = true, scanned_surface(scan_of([wall], spacing))
        self.image = photograph([wall], posed(true, CAMERA))

    def verdict(self, move=(0.0, 0.0, 0.0), image=None):
        """The verdict on the true pose moved by metres."""
        pose = Rigid3("local", "camera", self.true.R, self.true.t + move)
        return verify(posed(pose, CAMERA), self.surface, lambda _: self.image if image is None else image)


@pytest.fixture(scope="module")
def square():
    return View(facade(1.0), SQUARE)


@pytest.fixture(scope="module")
def tilted():
    return View(facade(0.6), TILTED)


def test_the_right_pose_is_confirmed(square, tilted):
    for view in (square, tilted):
        verdict = view.verdict()
        assert verdict.confirmed and verdict.decided and not verdict.contradicted
        assert verdict.templates >= 15 and verdict.agreeing > 0.7 * verdict.templates
        assert verdict.chance < 1e-6 and verdict.shift == 0.0
    assert 0.3 < square.verdict().rival < 0.95  # the neighbouring windows


@pytest.mark.parametrize("move", MOVES.values(), ids=MOVES)
def test_a_pose_that_is_off_by_one_window_is_contradicted(square, move):
    verdict = square.verdict(move)
    assert verdict.contradicted and not verdict.confirmed
    assert verdict.shift == pytest.approx(PITCH * 700.0 / 12.0, rel=0.05)
    assert 1.0 < verdict.rival < 3.0


@pytest.mark.parametrize("move", MOVES.values(), ids=MOVES)
def test_a_slanted_view_that_is_off_by_one_window_is_not_confirmed(tilted, move):
    assert not tilted.verdict(move).confirmed


def test_a_pose_that_is_off_by_half_a_window_is_contradicted(square, tilted):
    for view in (square, tilted):
        verdict = view.verdict((0.5 * PITCH, 0.0, 0.0))
        assert verdict.contradicted and not verdict.confirmed
        assert verdict.agreeing < 0.2 * verdict.templates


def test_an_unrelated_picture_is_not_confirmed(square):
    for seed in (40, 41):
        wall = Wall((0, 0, 0), (1, 0, 0), paint(18.0, 9.0, seed=seed))
        verdict = square.verdict(image=photograph([wall], posed(SQUARE, CAMERA)))
        assert not verdict.confirmed
        assert verdict.agreeing < 0.3 * verdict.templates


def test_dark_for_light_makes_no_difference(square):
    assert square.verdict(image=255 - square.image).confirmed


def test_a_finer_scan_decides_as_well():
    verdict = View(facade(1.0), SQUARE, 0.025).verdict()
    assert verdict.templates >= 15 and verdict.confirmed


def test_too_little_of_the_scan_decides_nothing(square):
    small = Wall((8.5, 0.0, 1.5), (1.0, 0.0, 0.0), paint(1.2, 1.2))
    photo = posed(SQUARE, CAMERA)
    verdict = verify(photo, scanned_surface(scan_of([small], SPACING)), lambda _: square.image)
    assert not verdict.decided and not verdict.confirmed and not verdict.contradicted
    away = posed(looking(9.0, -12.0, heading=180.0), CAMERA)
    assert verify(away, square.surface, lambda _: square.image).templates == 0
