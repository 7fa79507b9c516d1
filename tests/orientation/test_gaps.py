"""Gaps in drawings of a scan: chance leaves them in a wall, edges and glass make others."""

import numpy as np
import pytest

from frontage.orientation.control import find_control
from frontage.orientation.reflectance.gaps import _ROWS, roughness, without_small_gaps
from frontage.orientation.reflectance.render import Rendering
from frontage.orientation.reflectance.surface import scanned_surface
from orientation.paintedwalls import Wall, looking, paint, photograph, posed, scan_of

NOISE_M = 0.003
SHAPE = (2 * _ROWS + 40, 120)
ROWS, COLUMNS = np.mgrid[: SHAPE[0], : SHAPE[1]]
SLANTED = 1.0 / (0.1 + 2e-4 * COLUMNS - 5e-5 * ROWS)  # a plane has a linear inverse depth
NOISE = np.random.default_rng(0).normal(0, NOISE_M, SHAPE)


def drawn(depth, gaps=()):
    known = np.ones(SHAPE, bool)
    for rows, columns in gaps:
        known[rows, columns] = False
    depth = np.where(known, depth, 0.0).astype(np.float32)
    return Rendering(posed(looking(0.0, -8.0)), np.ones(2), np.zeros(SHAPE, np.float32), depth, known)


def test_the_roughness_of_a_slanted_wall_is_its_noise():
    found = roughness(SLANTED + NOISE, np.ones(SHAPE, bool))
    assert np.median(found) == pytest.approx(NOISE_M, rel=0.05)
    assert found.max() < 1.5 * NOISE_M


def test_small_gaps_in_a_flat_surface_are_measured_and_large_ones_are_not():
    small = [(slice(r, r + 5), slice(60, 65)) for r in (50, _ROWS - 2, 2 * _ROWS + 4)]
    large = slice(100, 130), slice(40, 70)
    measured = without_small_gaps(drawn(SLANTED + NOISE, [*small, large]), NOISE_M)
    for gap in small:
        assert measured[gap].all()
    assert not measured[103:127, 43:67].any()  # its corners are rounded


def test_a_gap_at_a_step_in_depth_is_the_end_of_what_was_measured():
    gap = slice(50, 80), slice(60, 64)
    reveal = SLANTED + NOISE + np.where(COLUMNS > 62, 0.1, 0.0)
    assert not without_small_gaps(drawn(reveal, [gap]), NOISE_M)[gap].any()


def test_points_that_are_left_of_a_scan_by_chance_still_give_control():
    front = (Wall((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), paint(14.0, 9.0)),)
    photo = posed(looking(6.0, -8.0))
    scan, picture = scan_of(front, 0.015), photograph(front, photo)
    some = scan.take(np.flatnonzero(np.random.default_rng(1).random(len(scan)) < 0.25))
    surface = scanned_surface(some)
    found = find_control(photo, surface, lambda _: picture, radius=6, step=12, largest=48)
    assert len(found) > 1000
    assert np.median(np.abs(found.moved)) < 0.1
