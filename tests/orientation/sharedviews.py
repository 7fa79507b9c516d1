"""Photos of two painted walls, the scan of the walls, and what pairs of the photos have in common."""

import numpy as np
import pytest

from frontage.orientation.network import TiePoints
from frontage.orientation.nouns import CommonPoints
from frontage.orientation.placed import Placed, Scene
from frontage.orientation.reflectance.surface import scanned_surface
from orientation.paintedwalls import LANDSCAPE, corner_of_two, looking, posed, scan_of

POSES = (looking(2.5, -7.5), looking(5.0, -8.0), looking(7.5, -6.5, heading=20.0))
WRONG = 0.3
"""Share of false matches."""


def painted_street():
    """The surface of the scan, the photos, and points on the walls."""
    walls = corner_of_two()
    photos = [posed(pose, LANDSCAPE, f"{k}.jpg") for k, pose in enumerate(POSES)]
    xyz = np.concatenate([w.points(0.15, np.random.default_rng(2), 0.0)[0] for w in walls])
    return scanned_surface(scan_of(walls, 0.04)), photos, xyz


def common(photos, xyz, first, second, wrong=WRONG):
    """What two photos see of points, some of it in wrong places."""
    rng = np.random.default_rng([first, second])
    size = (LANDSCAPE.width, LANDSCAPE.height)
    pixels = np.stack([photos[k].project(xyz) for k in (first, second)], axis=1)
    pixels = pixels[((pixels > 0) & (pixels < size)).all((1, 2))]
    pixels += rng.normal(0, 0.2, pixels.shape)
    false = rng.random(len(pixels)) < wrong
    pixels[false, 1] = rng.uniform(0, size, (int(false.sum()), 2))
    return CommonPoints(first, second, pixels), false


def scene_of(surface, given, pairs):
    return Scene(given, surface, lambda _: pytest.fail("no picture is needed"), (), 0, print, (), pairs)


def placed(photos, *numbers):
    return Placed(np.array(numbers), tuple(photos[n] for n in numbers), TiePoints.none())
