"""The plumb line is found from vertical edges in the photos of a block."""

import cv2
import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Photo
from frontage.orientation.upright import plumb_line, plumb_line_within, turn_upright, up_from_cameras
from orientation.paintedwalls import EXACT, LANDSCAPE, PORTRAIT, looking

POSES = (
    looking(2.0, -8.0, heading=8.0, pitch=9.0, roll=2.5),
    looking(5.0, -8.0, heading=-4.0, pitch=14.0, roll=-1.5),
    looking(8.0, -7.0, heading=-12.0, pitch=6.0, roll=1.0),
)
BLOCK = cv2.Rodrigues(np.array([0.5, -0.9, 0.3]))[0]
"""A rotation block_from_local: blocks lie in any direction."""


def drawn(pose, camera, seed, verticals=True):
    """A picture of vertical edges of a wall, and of slanted ones that are no help."""
    rng = np.random.default_rng(seed)
    image = np.full((camera.height, camera.width), 90, np.uint8)
    x = np.arange(-1.0, 12.0, 0.6) + rng.uniform(-0.1, 0.1, 22)
    low = rng.uniform(0, 3, 22)
    edges = [((a, 0, b), (a, 0, b + 2.5)) for a, b in zip(x, low, strict=True)] if verticals else []
    for _ in range(15):
        a, b, slant = rng.uniform(0, 10), rng.uniform(0, 5), rng.uniform(-2, 2)
        edges.append(((a, 0, b), (a + slant, 0, b + rng.uniform(-0.8, 0.8))))
    for edge in edges:
        many = np.linspace(*np.array(edge, float), 20)
        # cv2 counts from the middle of the first pixel
        at = camera.project(pose.inverse.apply(many)) - 0.5
        if np.isfinite(at).all() and np.abs(at).max() < 4000:
            cv2.polylines(image, [np.round(at * 256).astype(np.int32)], False, 220, 3, cv2.LINE_AA, 8)
    image = cv2.GaussianBlur(image, (0, 0), 0.8)
    noise = rng.normal(0, 1.5, image.shape)
    return np.repeat(np.clip(image + noise, 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def block(poses, cameras, verticals=True):
    photos, images = [], {}
    for k, (pose, camera) in enumerate(zip(poses, cameras, strict=True)):
        own = Rigid3("block", "camera", BLOCK @ pose.R, BLOCK @ pose.t)
        photos.append(Photo(str(k), camera, Estimate(own, EXACT, 0.0)))
        images[str(k)] = drawn(pose, camera, k, verticals)
    return photos, images


def degrees_off(up):
    return np.degrees(np.arccos(np.clip(up @ BLOCK[:, 2], -1, 1)))


@pytest.mark.parametrize("camera", [LANDSCAPE, PORTRAIT], ids=["landscape", "portrait"])
def test_vertical_edges_give_the_plumb_line(camera):
    photos, images = block(POSES, (camera,) * 3)
    first = up_from_cameras(photos)
    assert 0.3 < degrees_off(first) < 8.0
    up = plumb_line(photos, images.__getitem__, first)
    assert degrees_off(up) < 0.1
    assert np.linalg.norm(up) == pytest.approx(1.0)


def test_pictures_on_their_side_are_understood():
    poses = (*POSES[:2], looking(8.0, -7.0, heading=-12.0, pitch=6.0, roll=91.0))
    photos, images = block(poses, (LANDSCAPE,) * 3)
    first = up_from_cameras(photos)
    assert degrees_off(first) < 8.0
    assert degrees_off(plumb_line(photos, images.__getitem__, first)) < 0.1


@pytest.mark.parametrize("pitch", [0.0, 12.0, 22.0])
def test_photos_that_all_look_one_way_are_not_taken_to_lie_on_their_side(pitch):
    poses = tuple(looking(x, -8.0, heading=0.2 * x, pitch=pitch, roll=0.3) for x in (2.0, 5.0, 8.0))
    photos, images = block(poses, (LANDSCAPE,) * 3)
    assert degrees_off(up_from_cameras(photos)) < pitch + 2.0  # how far they all look up is not known
    assert degrees_off(plumb_line(photos, images.__getitem__, up_from_cameras(photos))) < 0.15


def test_without_vertical_edges_nothing_goes_far_wrong():
    photos, images = block(POSES, (LANDSCAPE,) * 3, verticals=False)
    first = up_from_cameras(photos)
    assert degrees_off(plumb_line(photos, images.__getitem__, first)) < 12.0
    grey = np.full((600, 800, 3), 90, np.uint8)
    assert np.array_equal(plumb_line(photos, lambda _: grey, first), first)


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (14.0, 0.0), (-9.0, 11.0), (0.0, -18.0)])
def test_one_photo_whose_tilt_is_roughly_known_is_levelled(tilt):
    photos, images = block(POSES[:1], (LANDSCAPE,))
    rough = cv2.Rodrigues(np.radians([*tilt, 0.0]))[0] @ BLOCK[:, 2]
    up = plumb_line_within(photos, images.__getitem__, rough, np.radians(10.0))
    assert degrees_off(up) < 0.2


def test_edges_that_are_upright_by_chance_do_not_tilt_a_photo():
    photos, images = block(POSES, (LANDSCAPE,) * 3, verticals=False)
    for rough in (BLOCK[:, 2], up_from_cameras(photos)):
        assert np.array_equal(plumb_line_within(photos, images.__getitem__, rough, np.radians(10.0)), rough)


def test_the_smallest_turn_takes_a_direction_upright():
    up = np.array([0.3, -0.4, 0.5])
    up /= np.linalg.norm(up)
    R = turn_upright(up)
    assert R @ up == pytest.approx([0, 0, 1])
    assert np.arccos((np.trace(R) - 1) / 2) == pytest.approx(np.arccos(up[2]))
    for sign in (1.0, -1.0):
        R = turn_upright(np.array([0.0, 0.0, sign]))
        assert R @ [0, 0, sign] == pytest.approx([0, 0, 1]) and np.linalg.det(R) == pytest.approx(1)
