"""Photos without a scan: the standard errors of a free network."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from tests.orientation.adjustment.blocks import facade_block

from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Photo
from frontage.orientation import Block, adjusted_block
from frontage.orientation.adjustment import NotDetermined


def _block(seed, **how):
    """A block with wrong approximate poses, and the true poses."""
    scene = facade_block(seed, control=0, start=0.2, **how)
    network = scene.network
    unknown = np.zeros((6, 6))
    photos = tuple(
        Photo(f"P{k}", network.cameras[0], Estimate(pose, unknown, 0.0))
        for k, pose in enumerate(network.poses)
    )
    images = network.images
    numbers = np.arange(len(photos))
    return Block(numbers, photos, network.points, images.photo, images.point, images.pixels), scene.poses


def _differences(block, poses):
    """Differences from the true poses (6 p,), and the seven freedoms (6 p, 7) of a free network."""
    off = [
        np.concatenate([p.pose.t - true.t, cv2.Rodrigues(p.pose.R @ true.R.T)[0][:, 0]])
        for p, true in zip(block.photos, poses, strict=True)
    ]
    free = np.zeros((len(poses), 6, 7))
    for k, true in enumerate(poses):
        free[k, :3, :3] = np.eye(3)
        free[k, :3, 3:6] = np.cross(np.eye(3), true.t).T
        free[k, 3:, 3:6] = np.eye(3)
        free[k, :3, 6] = true.t
    return np.concatenate(off), free.reshape(-1, 7)


def test_poses_of_a_free_network_err_by_their_standard_errors():
    squared = []
    for seed in range(6):
        block, poses = _block(seed)
        found = adjusted_block(block)
        off, free = _differences(found, poses)
        turns = np.tile([0.1] * 3 + [1.0] * 3, len(poses))[:, None]
        off = off - free @ np.linalg.lstsq(turns * free, turns[:, 0] * off, rcond=None)[0]
        sigma = np.concatenate([p.local_from_camera.sigma for p in found.photos])
        squared.append((off / sigma) ** 2)
    assert 0.5 < np.mean(squared) < 1.6


def test_errors_do_not_depend_on_the_units_of_a_block():
    block, _ = _block(1)
    one = adjusted_block(block)
    moved = [Rigid3("local", "camera", p.pose.R, 7.0 * p.pose.t) for p in block.photos]
    photos = tuple(
        replace(p, local_from_camera=Estimate(pose, np.zeros((6, 6)), 0.0))
        for p, pose in zip(block.photos, moved, strict=True)
    )
    other = adjusted_block(replace(block, photos=photos, points=7.0 * block.points))
    units = np.array([7.0] * 3 + [1.0] * 3)
    for a, b in zip(one.photos, other.photos, strict=True):
        np.testing.assert_allclose(b.local_from_camera.sigma, a.local_from_camera.sigma * units, rtol=1e-3)


def test_measurements_that_fail_the_tests_are_left_out():
    block, _ = _block(2)
    pixels = block.pixels.copy()
    pixels[5] += [40.0, -30.0]
    kept = adjusted_block(replace(block, pixels=pixels))
    assert not (np.abs(kept.pixels - pixels[5]).sum(axis=1) < 1e-9).any()
    assert len(kept.pixels) > 0.97 * len(pixels)
    assert kept.point.max() == len(kept.points) - 1


def test_photos_that_share_nothing_are_refused():
    block, _ = _block(3)
    apart = np.unique(block.point[block.photo < 4])
    own = np.where(block.photo < 4, True, ~np.isin(block.point, apart))
    split = replace(block, photo=block.photo[own], point=block.point[own], pixels=block.pixels[own])
    with pytest.raises(NotDetermined):
        adjusted_block(split)
