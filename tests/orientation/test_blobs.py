"""Tie points whose blobs differ in size between photos are measured less precisely, and count less."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.orientation import adjusted_block
from frontage.orientation.network import TIE_SIGMA_PX, TiePoints, tie_images
from frontage.orientation.nouns import CommonPoints, KeyPoints, PairMatches
from orientation.adjustment.blocks import SIGMA_PX
from orientation.paintedwalls import looking, posed
from orientation.test_free import _block, _differences

NEAR, FAR = posed(looking(0.0, -8.0, pitch=0.0)), posed(looking(0.0, -16.0, pitch=0.0))
ON_WALL = np.array([[0.0, 0.0, 1.7], [1.0, 0.0, 2.0], [-1.0, 0.0, 1.5]])


def ties(sizes):
    photo, point = (a.ravel() for a in np.indices((2, 3)))
    pixels = np.concatenate([p.project(ON_WALL) for p in (NEAR, FAR)])
    return TiePoints(ON_WALL, photo, point, pixels, sizes)


def test_a_blob_may_be_displaced_by_as_much_as_its_size_differs():
    # As seen from twice as far, a blob of 8 px is one of 4 px.
    sizes = np.array([8.0, 8.0, 8.0, 4.0, 5.0, 4.0])
    sigma = tie_images((NEAR, FAR), ties(sizes)).sigma
    assert sigma[[0, 2, 3, 5]] == pytest.approx(TIE_SIGMA_PX)
    assert sigma[1] ** 2 - 0.25 == pytest.approx(4.0 * (sigma[4] ** 2 - 0.25))
    assert sigma[4] > 2.0 * TIE_SIGMA_PX
    assert tie_images((NEAR, FAR), ties(None)).sigma == pytest.approx(TIE_SIGMA_PX)
    unknown = np.where(np.arange(6) == 1, np.nan, sizes)
    assert tie_images((NEAR, FAR), ties(unknown)).sigma == pytest.approx(TIE_SIGMA_PX)


def test_sizes_stay_with_their_measurements():
    kept = ties(np.arange(6.0)).take(np.array([4, 1]))
    assert kept.sizes.tolist() == [4.0, 1.0] and kept.point.tolist() == [1, 1]
    joined = TiePoints.joined([kept, ties(None)])
    assert joined.sizes[:2].tolist() == [4.0, 1.0] and np.isnan(joined.sizes[2:]).all()
    descriptors = np.zeros((3, 128), np.uint8)
    points = [
        KeyPoints(p.project(ON_WALL), np.array([3.0, 2.0, 1.0]) * k, descriptors)
        for k, p in ((1, NEAR), (2, FAR))
    ]
    pair = PairMatches(0, 1, np.array([[2, 2], [0, 1]]), np.eye(3), np.array([1.0, 0.0, 0.0]), 0.3)
    assert CommonPoints.of(pair, points).sizes.tolist() == [[1.0, 2.0], [3.0, 4.0]]


def test_a_photo_whose_blobs_differ_in_size_is_not_believed_too_much():
    """Blobs of the last photo have other sizes; per px they are displaced by three times what others err."""
    squared, error = {False: [], True: []}, {False: [], True: []}
    for seed in range(6):
        block, poses = _block(seed)
        rng = np.random.default_rng(seed)
        last = block.photo == len(block.photos) - 1
        depth = np.zeros(len(block.photo))
        for k, photo in enumerate(block.photos):
            rows = block.photo == k
            depth[rows] = (
                poses[k].inverse.apply(block.points[block.point[rows]])[:, 2] / photo.camera.params[0]
            )
        change = np.where(last, rng.uniform(-1.0, 1.0, len(last)), 0.0)
        sizes = 0.03 / depth + change
        pixels = block.pixels + change[:, None] * rng.normal(0, 3.0 * SIGMA_PX, (len(last), 2))
        for told in squared:
            found = adjusted_block(replace(block, pixels=pixels, sizes=sizes if told else None))
            off, free = _differences(found, poses)
            turns = np.tile([0.1] * 3 + [1.0] * 3, len(poses))[:, None]
            off = off - free @ np.linalg.lstsq(turns * free, turns[:, 0] * off, rcond=None)[0]
            sigma = np.concatenate([p.local_from_camera.sigma for p in found.photos])
            squared[told].append(np.mean((off[-6:] / sigma[-6:]) ** 2))
            error[told].append(np.linalg.norm(off[-6:-3]))
    assert 0.5 < np.mean(squared[True]) < 1.6 and np.mean(squared[False]) > 1.5 * np.mean(squared[True])
    assert np.mean(error[True]) < np.mean(error[False])
