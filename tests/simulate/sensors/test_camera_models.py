"""Every camera model against independently written formulas, and the grid of rays against the models."""

from cmath import atan, tan
from math import acos, asin, atan2, cos, hypot, isclose, pi, sin, sqrt

import numpy as np
import pytest

from frontage.errors import OptionError
from frontage.geometry.camera import MODELS
from frontage.geometry.rigid import Rigid3
from frontage.model import Camera, Estimate, Photo
from frontage.simulate.optics.raygrid import RayGrid
from frontage.simulate.sensors.cameras import CameraSpec, make_camera

WIDTH, HEIGHT = 640, 480


def by_hand(model: str, p: list[float], x: float, y: float, z: float) -> tuple[float, float]:
    """Pixel of one point in the camera frame, from the definitions in COLMAP's models.h."""
    if model == "EQUIRECTANGULAR":
        r = sqrt(x * x + y * y + z * z)
        return (atan2(x, z) / (2 * pi) + 0.5) * p[0], (asin(y / r) / pi + 0.5) * p[1]
    single = model.startswith("SIMPLE") or model in ("RADIAL", "RADIAL_FISHEYE")
    fx, fy, cx, cy, *k = [p[0], p[0], *p[1:]] if single else p
    u, v = x / z, y / z
    if "FISHEYE" in model:
        theta = acos(z / sqrt(x * x + y * y + z * z))
        rho = hypot(x, y)
        u, v = (theta * x / rho, theta * y / rho) if rho else (0.0, 0.0)
    r2 = u * u + v * v
    du = dv = 0.0
    if model in ("SIMPLE_RADIAL", "SIMPLE_RADIAL_FISHEYE"):
        du, dv = u * k[0] * r2, v * k[0] * r2
    elif model in ("RADIAL", "RADIAL_FISHEYE"):
        du, dv = (w * (k[0] * r2 + k[1] * r2**2) for w in (u, v))
    elif model == "OPENCV":
        k1, k2, p1, p2 = k
        du = u * (k1 * r2 + k2 * r2**2) + 2 * p1 * u * v + p2 * (r2 + 2 * u * u)
        dv = v * (k1 * r2 + k2 * r2**2) + 2 * p2 * u * v + p1 * (r2 + 2 * v * v)
    elif model == "FULL_OPENCV":
        k1, k2, p1, p2, k3, k4, k5, k6 = k
        radial = (1 + k1 * r2 + k2 * r2**2 + k3 * r2**3) / (1 + k4 * r2 + k5 * r2**2 + k6 * r2**3)
        du = u * radial + 2 * p1 * u * v + p2 * (r2 + 2 * u * u) - u
        dv = v * radial + 2 * p2 * u * v + p1 * (r2 + 2 * v * v) - v
    elif model == "OPENCV_FISHEYE":
        du, dv = (w * (k[0] * r2 + k[1] * r2**2 + k[2] * r2**3 + k[3] * r2**4) for w in (u, v))
    elif model == "THIN_PRISM_FISHEYE":
        k1, k2, p1, p2, k3, k4, s1, s2 = k
        radial = k1 * r2 + k2 * r2**2 + k3 * r2**3 + k4 * r2**4
        du = u * radial + 2 * p1 * u * v + p2 * (r2 + 2 * u * u) + s1 * r2
        dv = v * radial + 2 * p2 * u * v + p1 * (r2 + 2 * v * v) + s2 * r2
    elif model == "RAD_TAN_THIN_PRISM_FISHEYE":
        radial = sum(k[i] * r2 ** (i + 1) for i in range(6))
        a, b = u * (1 + radial), v * (1 + radial)
        q = a * a + b * b
        p0, p1, s0, s1, s2, s3 = k[6:]
        du = a + (2 * a * a + q) * p0 + 2 * a * b * p1 + s0 * q + s1 * q * q - u
        dv = b + (2 * b * b + q) * p1 + 2 * a * b * p0 + s2 * q + s3 * q * q - v
    elif model == "FOV":
        r = sqrt(r2)
        bent = (atan(2 * r * tan(k[0] / 2)) / k[0]).real
        du, dv = (u * bent / r - u, v * bent / r - v) if r else (0.0, 0.0)
    elif "DIVISION" in model:
        r = sqrt(r2)
        # x_u = x_d / (1 + k r_d^2): the distorted radius solves k r r_d^2 - r_d + r = 0
        bent = (1 - sqrt(1 - 4 * k[0] * r * r)) / (2 * k[0] * r) if r else 0.0
        assert isclose(bent / (1 + k[0] * bent**2), r, rel_tol=1e-9)
        du, dv = (u * bent / r - u, v * bent / r - v) if r else (0.0, 0.0)
    return fx * (u + du) + cx, fy * (v + dv) + cy


def camera_of(model: str) -> Camera:
    return make_camera(CameraSpec(model=model, width=WIDTH, height=HEIGHT, focal=22), seed=5)


@pytest.mark.parametrize("model", MODELS)
def test_known_points_are_projected_by_the_formulas(model):
    camera = camera_of(model)
    turn = 0.4
    R = np.array([[cos(turn), 0, sin(turn)], [0, 1, 0], [-sin(turn), 0, cos(turn)]])
    pose = Rigid3("local", "camera", R, np.array([3.0, -2.0, 1.6]))
    photo = Photo("a.jpg", camera, Estimate(pose, np.zeros((6, 6)), np.inf))
    rng = np.random.default_rng(1)
    ahead = np.column_stack([rng.uniform([-0.7, -0.5], [0.7, 0.5], (200, 2)), np.ones(200)])
    in_camera = ahead * rng.uniform(2, 30, (200, 1))
    expected = [by_hand(model, camera.params.tolist(), *map(float, xyz)) for xyz in in_camera]
    assert np.abs(photo.project(pose.apply(in_camera)) - expected).max() < 1e-6


@pytest.mark.parametrize("model", MODELS)
def test_the_ray_of_every_pixel_leads_back_to_its_centre(model):
    camera = camera_of(model)
    rays = RayGrid(camera).rows(0, HEIGHT)
    assert np.isfinite(rays).all()
    assert np.abs(np.linalg.norm(rays, axis=2) - 1).max() < 1e-12
    for row, column in [(0, 0), (0, WIDTH - 1), (HEIGHT - 1, 0), (240, 319), (77, 401), (300, 13)]:
        x, y = by_hand(model, camera.params.tolist(), *map(float, rays[row, column]))
        assert hypot(x - column - 0.5, y - row - 0.5) < 1e-4


def test_rays_end_where_the_lens_sees_nothing_and_are_right_up_to_there():
    camera = Camera("FISHEYE", 600, 400, np.array([60.0, 60.0, 300.0, 200.0]))  # 180 degrees at 188 px
    rays = RayGrid(camera).rows(150, 250)
    y, x = np.mgrid[150:250, 0:600] + 0.5
    inside = np.hypot(x - 300, y - 200) < 60 * pi
    assert (np.isfinite(rays).all(2) == inside).all()
    r = np.hypot(x - 300, y - 200) / 60
    assert np.abs(rays[..., 2] - np.cos(r))[inside].max() < 1e-6


def test_a_lens_is_drawn_from_the_seed_and_bends_by_more_than_a_pixel():
    a, b = (make_camera(CameraSpec(model="OPENCV"), seed) for seed in (1, 2))
    assert (a.params == make_camera(CameraSpec(model="OPENCV"), 1).params).all()
    assert (a.params[4:] != b.params[4:]).all()
    corner = np.array([[0.6, 0.45, 1.0]])
    straight = np.r_[a.params[:4], np.zeros(4)]
    shift = np.linalg.norm(a.project(corner) - Camera("OPENCV", 4000, 3000, straight).project(corner))
    assert 5 < shift < 300


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"model": "PINHOL"}, "PINHOL.*is not known"),
        ({"model": "PINHOLE", "params": (1.0, 2.0)}, "4 parameters, not 2"),
        ({"layout": "places"}, "at least one entry"),
        ({"places": ({"along": 1, "across": -5},)}, "only used with layout"),
        ({"widht": 3}, "widht"),
        ({"focal": -3}, "focal"),
    ],
)
def test_a_wrong_camera_is_refused_with_the_reason(wrong, words):
    with pytest.raises(ValueError, match=words):
        CameraSpec(**wrong)


def test_a_camera_that_sees_nothing_in_its_middle_is_refused():
    params = (60.0, 60.0, 2000.0, 200.0)  # the middle is more than 180 degrees off the axis
    with pytest.raises(OptionError, match="nothing in the middle"):
        make_camera(CameraSpec(model="FISHEYE", width=600, height=400, params=params), 0)
    with pytest.raises(OptionError, match="nothing in the middle"):
        make_camera(CameraSpec(model="PINHOLE", width=600, height=400, params=(0.0, 0.0, 300.0, 200.0)), 0)
