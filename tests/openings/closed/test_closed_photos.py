"""Shutters that only the photographs show."""

import numpy as np
import pytest

from frontage.model.ortho import OrthoImage
from frontage.openings import find_openings
from fronts import box_of, scan_wall

SIZE = (9.0, 9.0)
GRID = [(x, z, x + 1.1, z + 1.5) for z in (0.8, 3.6, 6.4) for x in (0.9, 3.1, 5.3, 7.3)]
SHUT = 5  # of the grid


def picture(facade, box, photos):
    """An ortho-image of the wall, with a leaf of another colour."""
    h, w, gsd = int(SIZE[1] / 0.01), int(SIZE[0] / 0.01), 0.01
    z, x = SIZE[1] - (np.arange(h)[:, None] + 0.5) * gsd, (np.arange(w)[None, :] + 0.5) * gsd
    leaf = (x > box[0]) & (x < box[2]) & (z > box[1]) & (z < box[3])
    noise = np.random.default_rng(3).normal(0.0, 6.0, (h, w, 3))
    rgb = np.where(leaf[..., None], (150, 150, 150), (180, 160, 140)) + noise
    pixels = np.dstack([np.clip(rgb, 0, 255), np.full((h, w), 255)]).astype(np.uint8)
    bands = {"depth": np.zeros((h, w), np.float32), "gsd_effective": np.full((h, w), 0.01, np.float32)}
    source = np.ones((h, w), np.uint16)
    return OrthoImage(
        pixels, gsd, (0.0, SIZE[1]), facade, source=source, sources=("a.jpg",), photos=photos, **bands
    )


@pytest.mark.parametrize("photos", [0, 1])
def test_a_photo_tells_a_shutter_that_the_scan_does_not_show(photos):
    holes = [box for k, box in enumerate(GRID) if k != SHUT]
    facade, scan = scan_wall(holes, spacing=0.03, size=SIZE, returned=0.5)
    ortho = picture(facade, GRID[SHUT], photos)
    found = find_openings(facade, scan, ortho=ortho)
    near = [o for o in found.openings if np.abs(box_of(o) - GRID[SHUT]).max() < 0.02]
    assert len(near) == photos and all(o.depth is not None for o in near)
