"""Key points found in tiles are those of the whole picture."""

import cv2
import numpy as np
import pytest
from scipy.spatial import cKDTree

from frontage.orientation.ties import sift


def picture(height, width, seed=3):
    """A picture (h, w) uint8 with blobs and grain of many sizes."""
    rng = np.random.default_rng(seed)
    total = np.zeros((height, width), np.float32)
    for step in (3, 7, 20, 60):
        grain = rng.normal(size=(height // step + 2, width // step + 2)).astype(np.float32)
        total += cv2.resize(grain, (width, height), interpolation=cv2.INTER_CUBIC)
    return np.clip(128 + 25 * total, 0, 255).astype(np.uint8)


@pytest.fixture
def small_tiles(monkeypatch):
    monkeypatch.setattr(sift, "_TILE_PX", 400)


def test_tiles_have_the_key_points_of_the_whole_picture(monkeypatch):
    grey = picture(620, 870)
    whole = sift.detect(grey)
    monkeypatch.setattr(sift, "_TILE_PX", 400)
    tiles = sift.detect(grey)
    assert len(whole.parts) == 1 and len(tiles.parts) > 4
    small = np.flatnonzero(whole.table[:, 2] < sift._LARGE_PX)
    tree = cKDTree(tiles.table[:, :3])
    off, nearest = tree.query(whole.table[small, :3])
    assert (off < 0.01).mean() > 0.99
    same = small[off < 0.01]
    mine, theirs = whole.describe(same), tiles.describe(nearest[off < 0.01])
    # several descriptors may belong to one place, one per orientation
    assert (np.abs(mine - theirs).max(1) < 2).mean() > 0.8
    assert len(tiles.table) == pytest.approx(len(whole.table), rel=0.02)


def test_large_key_points_come_from_the_reduced_picture(small_tiles):
    grey = np.full((620, 870), 90, np.uint8)
    cv2.circle(grey, (400, 300), 60, 200, -1)
    found = sift.detect(cv2.GaussianBlur(grey, (0, 0), 3.0)).table
    large = found[found[:, 2] >= sift._LARGE_PX]
    near = large[np.hypot(*(large[:, :2] - (400, 300)).T) < 2.0]
    # the scale at which a disc answers most is its radius over the root of two, and the size twice that
    assert len(near) and near[:, 2].max() == pytest.approx(2 * 60 / np.sqrt(2), rel=0.2)


def test_a_picture_without_anything_has_no_key_points(small_tiles):
    found = sift.detect(np.full((500, 900), 120, np.uint8))
    assert found.table.shape == (0, 4)
    assert found.describe(np.empty(0, np.int64)).shape == (0, 128)
