"""The pose of one photo from points of the scan, most of which may be wrong."""

import numpy as np
import pytest

from frontage.geometry.rigid import rotation_angle
from frontage.orientation.resection import resect
from orientation.paintedwalls import LANDSCAPE, PORTRAIT, looking

SIGMA = 0.5


def measured(camera, pose, share_wrong, count=120, seed=0, depth=1.5):
    """Pixels of points before a street, and which of them are wrong."""
    rng = np.random.default_rng(seed)
    xyz = np.column_stack(
        [rng.uniform(-2, 12, 6 * count), rng.uniform(-depth, 0, 6 * count), rng.uniform(0, 7, 6 * count)]
    )
    pixels = camera.project(pose.inverse.apply(xyz))
    with np.errstate(invalid="ignore"):
        inside = ((pixels > 0) & (pixels < (camera.width, camera.height))).all(1)
    rows = np.flatnonzero(inside)[:count]
    pixels, xyz = pixels[rows] + rng.normal(0, SIGMA, (len(rows), 2)), xyz[rows]
    wrong = np.arange(len(rows)) < round(share_wrong * len(rows))
    pixels[wrong] = rng.uniform(0, (camera.width, camera.height), (int(wrong.sum()), 2))
    return pixels, xyz, wrong


def up_in(pose, off_degrees=0.0):
    """The plumb line in the camera's frame, a little wrong."""
    up = pose.R.T @ np.array([0.0, 0.0, 1.0])
    return up + np.tan(np.radians(off_degrees)) * np.cross(up, [0.0, 0.0, 1.0])


@pytest.mark.parametrize("share", [0.0, 0.5, 0.8])
@pytest.mark.parametrize("level", [False, True], ids=["three points", "two points and the plumb line"])
@pytest.mark.parametrize("camera", [LANDSCAPE, PORTRAIT], ids=["landscape", "portrait"])
def test_the_pose_is_found_among_wrong_points(camera, level, share):
    pose = looking(5.0, -8.0, 1.7, heading=15.0, pitch=10.0, roll=2.0)
    pixels, xyz, wrong = measured(camera, pose, share, seed=int(10 * share))
    found = resect(camera, pixels, xyz, 2.0, up=up_in(pose, 0.2) if level else None)
    assert found is not None
    assert np.linalg.norm(found.pose.t - pose.t) < 0.05
    assert rotation_angle(found.pose.R @ pose.R.T) < np.radians(0.3)
    assert found.inliers[~wrong].mean() > 0.9
    assert not wrong.any() or found.inliers[wrong].mean() < 0.1
    assert found.hypotheses > 0


def test_the_plumb_line_saves_hypotheses():
    pose = looking(5.0, -8.0, heading=-20.0)
    pixels, xyz, _ = measured(LANDSCAPE, pose, 0.8, seed=3)
    plain, level = (resect(LANDSCAPE, pixels, xyz, 2.0, up=up) for up in (None, up_in(pose)))
    assert plain is not None and level is not None
    assert level.hypotheses < 0.6 * plain.hypotheses


@pytest.mark.parametrize("heading", [-170.0, -60.0, 45.0, 90.0])
def test_all_headings_are_alike_to_two_points(heading):
    pose = looking(5.0, -3.0, heading=heading, pitch=-4.0)
    rng = np.random.default_rng(1)
    inside = rng.uniform(0, (LANDSCAPE.width, LANDSCAPE.height), (60, 2))
    xyz = pose.apply(LANDSCAPE.ray(inside) * rng.uniform(4, 20, (60, 1)))
    found = resect(LANDSCAPE, inside, xyz, 2.0, up=up_in(pose))
    assert found is not None and found.inliers.all()
    assert np.linalg.norm(found.pose.t - pose.t) < 1e-4


@pytest.mark.parametrize("level", [False, True])
def test_noise_has_no_pose(level):
    pose = looking(5.0, -8.0)
    pixels, xyz, _ = measured(LANDSCAPE, pose, 1.0, count=30, seed=5)
    assert resect(LANDSCAPE, pixels, xyz, 1.0, up=up_in(pose) if level else None) is None


def test_five_points_are_too_few():
    pose = looking(5.0, -8.0)
    pixels, xyz, _ = measured(LANDSCAPE, pose, 0.0)
    assert resect(LANDSCAPE, pixels[:5], xyz[:5], 2.0) is None
    assert resect(LANDSCAPE, pixels[:12], xyz[:12], 2.0) is not None


def test_points_without_a_ray_are_left_out():
    pose = looking(5.0, -8.0)
    pixels, xyz, _ = measured(LANDSCAPE, pose, 0.0)
    pixels[:10] = np.nan
    found = resect(LANDSCAPE, pixels, xyz, 2.0)
    assert found is not None and not found.inliers[:10].any() and found.inliers[10:].mean() > 0.9
    assert len(found.inliers) == len(pixels)
