"""Places that are painted from one photo, and the cloud that may hide them."""

import numpy as np

from frontage.ortho.occluders import _one_of_each_cube
from frontage.ortho.photo_image import _places


def test_places_hold_every_pixel_of_a_photo_once_and_little_else():
    mask = np.zeros((500, 480), bool)
    mask[10:200, 20:60] = mask[150:230, 400:470] = mask[498, 3] = True
    count = np.zeros(mask.shape, int)
    for window in _places(mask, 96, 96):
        count[window] += 1
    assert count.max() == 1 and (count[mask] == 1).all()
    assert count.sum() < 2 * mask.sum()
    assert list(_places(np.zeros((100, 100), bool), 96, 96)) == []


def test_every_cube_of_a_cloud_keeps_a_point():
    rng = np.random.default_rng(0)
    wall = rng.normal([0.0, 0.0, 0.0], [10.0, 0.004, 4.0], (200_000, 3))
    far = rng.uniform(-70.0, 70.0, (5000, 3))
    cloud = np.vstack([wall, far])
    kept = _one_of_each_cube(cloud)
    cubes = np.floor(cloud / 0.04 + 0.5).astype(int)
    filled = len(np.unique(cubes, axis=0))
    assert len(np.unique(cubes[kept], axis=0)) == filled
    assert filled <= len(kept) < 1.1 * filled
    assert len(_one_of_each_cube(np.zeros((0, 3)))) == 0
