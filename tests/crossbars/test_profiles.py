"""What single edges of a view say."""

import cv2
import numpy as np

from frontage.crossbars.profiles import view_profiles
from frontage.crossbars.rectify import Grid, PlaneView

GRID = Grid(0.0, 0.0, 0.0025, (480, 320))


def edges() -> np.ndarray:
    """Returns what speaks for edges across z of bars, and of slats 35 mm apart above 0.7 m."""
    grey = np.full(GRID.shape, 60.0, np.float32)
    for low in (0, 60, 120, 200):
        grey[low : low + 16] = 180.0
    slats = np.arange(280, 480)
    grey[slats[(slats - 280) % 14 < 6]] = 180.0
    grey += np.random.default_rng(3).normal(0, 2, GRID.shape).astype(np.float32)
    grey = cv2.GaussianBlur(grey, (0, 0), 1.0)  # as photos are
    image = np.repeat(grey[..., None], 3, axis=2)
    seen = PlaneView("view", image, np.ones(GRID.shape, np.float32), (0.0025, 0.0025))
    found = view_profiles(GRID, seen, axis=1)
    return np.maximum(found.rise, found.fall).mean(0)


def test_slats_speak_less_for_edges_than_a_bar_does() -> None:
    found = edges()
    bar, slats = found[118:139].max(), found[320:460].max()
    assert bar > 1.5
    assert slats < 0.6 * bar
