"""The chain of paper B finds poses from a reflectance image, and none where nothing agrees."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from frontage.geometry.rigid import Rigid3, rotation_angle
from frontage.model import Camera, Photo, Scan
from frontage.orientation.paper import match_reflectance, orient_as_paper, refine_pose
from frontage.orientation.reflectance.raster import raster_reflectance
from raster_scans import SIZE, scan_raster, within

PIXEL = 0.02  # m, of the painted wall
CAMERA = Camera("OPENCV", 840, 560, np.array([630.0, 634.0, 424.0, 276.0, -0.05, 0.01, 1e-3, -5e-4]))


def paint(seed):
    """Grey tones 0..1 of the wall, 2 cm per pixel, with detail from 6 cm to half a metre."""
    rng = np.random.default_rng(seed)
    h, w = round(SIZE[1] / PIXEL), round(SIZE[0] / PIXEL)
    total = np.zeros((h, w), np.float32)
    for step in (4, 9, 25):
        grain = rng.normal(size=(h // step + 3, w // step + 3)).astype(np.float32)
        total += cv2.resize(grain, (w, h), interpolation=cv2.INTER_CUBIC)
    return np.clip(0.5 + 0.15 * total, 0.05, 1.0)


def tones(picture, x, z):
    rows = np.array([(SIZE[1] - z) / PIXEL - 0.5, x / PIXEL - 0.5])
    return map_coordinates(picture, rows, order=1, mode="nearest")


def pose(x=5.0, y=-8.0, z=1.7, heading=0.1, pitch=0.12):
    """A camera that looks at the wall, turned to the right and up."""
    turn = cv2.Rodrigues(np.array([0.0, 0.0, -heading]))[0] @ cv2.Rodrigues(np.array([pitch, 0.0, 0.0]))[0]
    R = turn @ np.column_stack([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    return Rigid3("local", "camera", R, np.array([x, y, z]))


def photograph(picture, place):
    """The photo (h, w, 3) of the wall; sky and ground are grey."""
    column, row = np.meshgrid(np.arange(CAMERA.width) + 0.5, np.arange(CAMERA.height) + 0.5)
    ray = place.rotate(CAMERA.ray(np.column_stack([column.ravel(), row.ravel()])))
    way = -place.t[1] / ray[:, 1]
    x, z = (place.t[k] + way * ray[:, k] for k in (0, 2))
    grey = np.where(within((0, 0, *SIZE))(x, z), 0.0, 0.4).reshape(row.shape)
    shown = tones(picture, x.reshape(row.shape), z.reshape(row.shape))
    image = np.where(grey > 0, grey, np.sqrt(np.maximum(shown, 0.0)))
    return np.repeat((255 * image[..., None]).astype(np.uint8), 3, axis=2)


@pytest.fixture(scope="module")
def scan() -> Scan:
    """A scan of the painted wall at 3 cm, without beams lost."""
    found, _ = scan_raster(within((0, 0, 0, 0)), street=False, step=0.003, noise=0.001)
    tone = tones(paint(1), found.xyz[:, 0], found.xyz[:, 2])
    return replace(found, intensity=(0.9 * tone).astype(np.float32))


def test_a_photo_of_the_wall_finds_its_place(scan):
    true = [pose(), pose(3.5, -7.0, 1.6, -0.15, 0.2)]
    images = {f"{k}": photograph(paint(1), place) for k, place in enumerate(true)}
    found = orient_as_paper([Photo(name, CAMERA) for name in images], scan, images.__getitem__)
    for one, place in zip(found, true, strict=True):
        assert one.photo is not None and one.photo.local_from_camera is not None
        off = one.photo.pose.t - place.t
        assert np.linalg.norm(off) < 0.05
        assert rotation_angle(one.photo.pose.R @ place.R.T) < np.radians(0.3)
        sigma = one.photo.local_from_camera.sigma
        assert (np.abs(off) < 5 * sigma[:3]).all() and (sigma[:3] < 0.05).all() and (sigma > 0).all()
        assert 20 <= len(one.xyz) <= one.matched and 0.05 < one.rms < 2.0
        assert np.abs(one.xyz[:, 1]).max() < 0.02
        residual = CAMERA.project(one.photo.pose.inverse.apply(one.xyz)) - one.pixels
        assert np.sqrt(np.mean(residual**2)) == pytest.approx(one.rms, rel=1e-6)


def test_a_photo_of_another_wall_gets_no_pose(scan):
    (one,) = orient_as_paper([Photo("other", CAMERA)], [scan], lambda _: photograph(paint(2), pose()))
    assert one.photo is None and len(one.xyz) == 0 and np.isnan(one.rms)


def test_a_photo_without_any_key_point_gets_no_pose(scan):
    grey = np.full((CAMERA.height, CAMERA.width, 3), 90, np.uint8)
    (one,) = orient_as_paper([Photo("fog", CAMERA)], scan, lambda _: grey)
    assert one.photo is None and one.matched == 0


def test_only_the_green_channel_counts(scan):
    image = photograph(paint(1), pose())
    coloured = photograph(paint(2), pose())
    coloured[..., 1] = image[..., 1]
    picture, photo = raster_reflectance(scan), Photo("p", CAMERA)
    grey, green = (match_reflectance(photo, picture, lambda _, i=i: i) for i in (image, coloured))
    assert len(grey[0]) > 20
    assert np.array_equal(grey[0], green[0]) and np.array_equal(grey[1], green[1])


def test_a_cloud_without_a_raster_is_looked_at_from_its_station(scan):
    image = photograph(paint(1), pose())
    (one,) = orient_as_paper([Photo("p", CAMERA)], replace(scan, grid=None), lambda _: image)
    assert one.photo is not None
    assert np.linalg.norm(one.photo.pose.t - pose().t) < 0.1


def test_the_refinement_converges_and_its_covariance_is_right():
    rng = np.random.default_rng(4)
    xyz = np.column_stack([rng.uniform(1, 9, 40), rng.uniform(-0.5, 0.5, 40), rng.uniform(0.5, 5, 40)])
    true = pose()
    exact = CAMERA.project(true.inverse.apply(xyz))
    start = Rigid3("local", "camera", cv2.Rodrigues(np.array([0.03, -0.02, 0.04]))[0] @ true.R, true.t + 0.3)
    found = refine_pose(CAMERA, exact, xyz, start)
    assert found is not None and np.linalg.norm(found[0].value.t - true.t) < 1e-8
    squared = []
    for _ in range(60):
        noisy = refine_pose(CAMERA, exact + rng.normal(0, 0.7, exact.shape), xyz, start)
        assert noisy is not None
        turn = cv2.Rodrigues(noisy[0].value.R @ true.R.T)[0][:, 0]
        error = np.concatenate([noisy[0].value.t - true.t, turn])
        squared.append(error @ np.linalg.solve(noisy[0].covariance, error) / 6)
    assert 0.8 < np.mean(squared) < 1.3


def test_too_few_points_or_points_in_one_place_determine_nothing():
    xyz = np.array([[4.0, 0.0, 2.0], [5.0, 0.0, 2.0], [5.0, 0.0, 3.0]])
    assert refine_pose(CAMERA, CAMERA.project(pose().inverse.apply(xyz)), xyz, pose()) is None
    same = np.repeat(xyz[:1], 12, axis=0)
    assert refine_pose(CAMERA, CAMERA.project(pose().inverse.apply(same)), same, pose()) is None
