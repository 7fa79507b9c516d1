"""Fronts of long balconies are layers of a larger wall behind them; walls of windows are none."""

import numpy as np
import pytest

from frontage.facades.candidate import sketch_candidate
from frontage.facades.cloud import prepare
from frontage.facades.galleries import without_galleries
from frontage.facades.scene import FacadeScene
from frontage.model import Scan, WorldRef

EYES = np.array([[-9.0, -14.0, 1.7], [5.0, -12.0, 1.7]])
DEEP, LONG, HIGH = 1.4, 15.0, 11.6


def parapets(x, z):
    """Solid parapets along three storeys, with nothing between them."""
    return (z > 2.7) & ((z + 0.2) % 2.9 < 1.1)


def windows(x, z):
    """The same bands as spandrels, with the posts of windows every metre between them."""
    return parapets(x, z) | (x % 1.0 < 0.12)


def piers(x, z):
    """The same bands with piers of 60 cm between them."""
    return parapets(x, z) | (x % 3.0 < 0.6)


def depths(opaque):
    """Returns the depths of what is kept of a front that is `opaque` (x, z) and the wall behind it."""
    rng = np.random.default_rng(0)
    x, z = (v.ravel() for v in np.meshgrid(np.arange(-LONG / 2, LONG / 2, 0.05), np.arange(0.0, HIGH, 0.05)))
    front = np.column_stack([x, np.zeros(len(x)), z])[opaque(x, z)]
    parts, eyes = [front], [np.arange(len(front)) % 2]
    wall = np.column_stack([x, np.full(len(x), DEEP), z])
    for k, eye in enumerate(EYES):
        at = eye + (wall - eye) * (-eye[1] / (wall[:, 1] - eye[1]))[:, None]
        parts.append(wall[~opaque(at[:, 0], at[:, 2])])
        eyes.append(np.full(len(parts[-1]), k))
    xyz = np.vstack(parts) + rng.normal(0.0, 0.004, (sum(map(len, parts)), 3))
    scan = Scan("front", xyz, WorldRef(np.zeros(3, np.int64)), EYES, np.concatenate(eyes).astype(np.int32))
    scene = FacadeScene(scan, np.eye(3), prepare(xyz, np.arange(len(xyz)), rng, None))
    candidates = []
    for y in (0.0, DEEP):
        point, votes = np.array([0.0, y, 5.0]), xyz[np.abs(xyz[:, 1] - y) < 0.02]
        candidate = sketch_candidate(
            np.array([0.0, 1.0, 0.0]), point, sigma=0.005, votes=votes, scene=scene, rng=rng
        )
        assert candidate is not None
        candidates.append(candidate)
    return [round(float(c.wall.point[1]), 1) for c in without_galleries(candidates, scene, rng)]


@pytest.mark.parametrize(
    ("opaque", "kept"), [(parapets, [DEEP]), (windows, [0.0, DEEP]), (piers, [0.0, DEEP])]
)
def test_only_bands_with_nothing_between_them_are_galleries(opaque, kept):
    assert depths(opaque) == kept
