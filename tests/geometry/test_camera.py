"""Camera models: against OpenCV where it has them, round trips for all, and no ghosts past the fold."""

import cv2
import numpy as np
import pytest

from frontage.errors import InputError
from frontage.geometry import camera

CENTRE = (1000.0, 750.0)
CAMERAS = {
    "SIMPLE_PINHOLE": (1500.0, *CENTRE),
    "PINHOLE": (1500.0, 1510.0, *CENTRE),
    "SIMPLE_RADIAL": (1500.0, *CENTRE, -0.12),
    "RADIAL": (1500.0, *CENTRE, -0.2, 0.05),
    "OPENCV": (1500.0, 1510.0, *CENTRE, -0.2, 0.05, 1e-3, -8e-4),
    "FULL_OPENCV": (1500.0, 1510.0, *CENTRE, 0.3, -0.1, 1e-3, -8e-4, 0.02, 0.45, -0.08, 0.01),
    "SIMPLE_FISHEYE": (600.0, *CENTRE),
    "FISHEYE": (600.0, 610.0, *CENTRE),
    "SIMPLE_RADIAL_FISHEYE": (600.0, *CENTRE, 0.02),
    "RADIAL_FISHEYE": (600.0, *CENTRE, 0.03, -0.004),
    "OPENCV_FISHEYE": (600.0, 610.0, *CENTRE, 0.03, -0.01, 0.002, -3e-4),
    "THIN_PRISM_FISHEYE": (600.0, 610.0, *CENTRE, 0.03, -0.01, 1e-3, -8e-4, 0.002, -3e-4, 5e-4, -4e-4),
    "RAD_TAN_THIN_PRISM_FISHEYE": (600.0, 610.0, *CENTRE, 0.03, -0.01, 2e-3, -3e-4, 1e-5, -1e-6, 1e-3, -8e-4,
                                   5e-4, 1e-5, -4e-4, 2e-5),
    "FOV": (900.0, 910.0, *CENTRE, 0.8),
    "SIMPLE_DIVISION": (1500.0, *CENTRE, -0.15),
    "DIVISION": (1500.0, 1510.0, *CENTRE, 0.1),
    "EQUIRECTANGULAR": (2000.0, 1500.0),
}  # fmt: skip


def some_points(n: int = 500) -> np.ndarray:
    rng = np.random.default_rng(3)
    xy = rng.uniform([-0.6, -0.45], [0.6, 0.45], (n, 2))
    depth = rng.uniform(2.0, 40.0, n)
    return np.column_stack([xy, np.ones(n)]) * depth[:, None]


def test_every_model_is_tested():
    assert set(CAMERAS) == set(camera.MODELS)


@pytest.mark.parametrize("name", CAMERAS)
def test_a_ray_leads_back_to_its_point(name):
    xyz = some_points()
    pixels = camera.project(name, np.array(CAMERAS[name]), xyz)
    rays = camera.unproject(name, np.array(CAMERAS[name]), pixels)
    assert np.isfinite(pixels).all()
    assert np.abs(rays - xyz / np.linalg.norm(xyz, axis=1, keepdims=True)).max() < 1e-10


@pytest.mark.parametrize("name", CAMERAS)
def test_a_pixel_leads_back_to_itself_over_the_whole_picture(name):
    u, v = np.meshgrid(np.linspace(0, 2000, 41), np.linspace(0, 1500, 31))
    pixels = np.column_stack([u.ravel(), v.ravel()])
    rays = camera.unproject(name, np.array(CAMERAS[name]), pixels)
    known = np.isfinite(rays).all(1)
    assert known.mean() > 0.95
    back = camera.project(name, np.array(CAMERAS[name]), rays[known])
    assert np.abs(back - pixels[known]).max() < 1e-6 or name == "EQUIRECTANGULAR"


def opencv_coefficients(name: str) -> tuple[np.ndarray, np.ndarray]:
    p = CAMERAS[name]
    K = np.array([[p[0], 0, p[2]], [0, p[1], p[3]], [0, 0, 1.0]])
    return K, np.array(p[4:])


@pytest.mark.parametrize("name", ["PINHOLE", "OPENCV", "FULL_OPENCV", "OPENCV_FISHEYE"])
def test_projects_as_opencv_does(name):
    xyz = some_points()
    K, dist = opencv_coefficients(name)
    function = cv2.fisheye.projectPoints if name == "OPENCV_FISHEYE" else cv2.projectPoints
    if name == "OPENCV_FISHEYE":
        theirs = function(xyz[:, None], np.zeros(3), np.zeros(3), K, dist)[0]
    else:
        theirs = function(xyz, np.zeros(3), np.zeros(3), K, dist)[0]
    ours = camera.project(name, np.array(CAMERAS[name]), xyz)
    assert np.abs(ours - theirs.reshape(-1, 2)).max() < 1e-8


def test_nothing_behind_the_camera_is_seen():
    xyz = np.array([[0.0, 0.0, -5.0], [1.0, 1.0, 0.0], [0.1, 0.0, 5.0]])
    seen = np.isfinite(camera.project("PINHOLE", np.array(CAMERAS["PINHOLE"]), xyz)).all(1)
    assert seen.tolist() == [False, False, True]


@pytest.mark.parametrize("name", ["SIMPLE_RADIAL", "OPENCV", "FULL_OPENCV", "SIMPLE_RADIAL_FISHEYE"])
def test_past_the_fold_there_are_no_ghosts(name):
    params = np.array(CAMERAS[name])
    params[{"SIMPLE_RADIAL": 3, "SIMPLE_RADIAL_FISHEYE": 3}.get(name, 4)] = -0.3
    params[5:] = 0.0 if name.endswith("OPENCV") else params[5:]
    angle = np.linspace(0.0, 1.55, 400)
    u = camera.project(name, params, np.column_stack([np.sin(angle), 0 * angle, np.cos(angle)]))[:, 0]
    known = np.isfinite(u)
    assert known[0] and not known[-1]
    assert (np.diff(u[known]) > 0).all(), "the picture folds back"
    assert not known[np.argmin(known) :].any(), "a second sheet appears past the fold"


def test_a_fisheye_sees_beyond_ninety_degrees():
    a = np.radians(100.0)
    ray = np.array([[np.sin(a), 0.0, np.cos(a)]])
    pixel = camera.project("FISHEYE", np.array(CAMERAS["FISHEYE"]), ray)
    assert pixel[0, 0] == pytest.approx(1000.0 + 600.0 * a, abs=1e-9)


def test_unknown_models_and_wrong_counts_are_refused():
    with pytest.raises(InputError, match="FISHEYE624"):
        camera.parameter_count("FISHEYE624")
    with pytest.raises(InputError, match="4 parameters, not 3"):
        camera.project("PINHOLE", np.ones(3), np.ones((1, 3)))


def test_a_pinhole_is_distinguished_from_a_distorted_camera():
    assert camera.is_pinhole("OPENCV", np.array([1500.0, 1500, 1, 1, 0, 0, 0, 0]))
    assert not camera.is_pinhole("OPENCV", np.array(CAMERAS["OPENCV"]))
    assert not camera.is_pinhole("FISHEYE", np.array(CAMERAS["FISHEYE"]))
