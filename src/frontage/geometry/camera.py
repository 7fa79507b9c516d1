"""COLMAP's camera models: projection of points to pixels and back.

Camera frame: x right, y down, z forward. The centre of the first pixel is at (0.5, 0.5). The parameters are
in COLMAP's order (github.com/colmap/colmap, src/colmap/sensor/models.h). Points that a model cannot see
(behind the camera, past the fold of the distortion polynomial) become NaN and never a ghost pixel.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from frontage.errors import InputError
from frontage.geometry.arrays import Float
from frontage.geometry.lens import Lens

_PINHOLE, _FISHEYE, _FOV, _DIVISION, _SPHERE = "pinhole", "fisheye", "fov", "division", "sphere"


@dataclass(frozen=True)
class _CameraModel:
    """The parameters of a model: their number, one or two focal lengths, the base projection, the lens."""

    count: int
    focals: int
    base: str
    lens: Callable[..., Lens] = lambda *_: Lens()


def _full_opencv(k1: float, k2: float, p1: float, p2: float, k3: float, *divisor: float) -> Lens:
    return Lens((k1, k2, k3), divisor, (p1, p2))


def _thin_prism(
    k1: float, k2: float, p1: float, p2: float, k3: float, k4: float, sx: float, sy: float
) -> Lens:
    return Lens((k1, k2, k3, k4), (), (p1, p2), (sx, 0.0, sy, 0.0))


def _rad_tan_thin_prism(*p: float) -> Lens:
    # COLMAP and Project Aria call the coefficient of x (r^2 + 2 x^2) p0, in contrast to OpenCV.
    return Lens(p[:6], (), (p[7], p[6]), (p[8], p[9], p[10], p[11]), staged=True)


_RADIAL: Callable[..., Lens] = lambda *k: Lens(k)  # noqa: E731
_MODELS = {
    "SIMPLE_PINHOLE": _CameraModel(3, 1, _PINHOLE),
    "PINHOLE": _CameraModel(4, 2, _PINHOLE),
    "SIMPLE_RADIAL": _CameraModel(4, 1, _PINHOLE, _RADIAL),
    "RADIAL": _CameraModel(5, 1, _PINHOLE, _RADIAL),
    "OPENCV": _CameraModel(8, 2, _PINHOLE, lambda k1, k2, p1, p2: Lens((k1, k2), (), (p1, p2))),
    "FULL_OPENCV": _CameraModel(12, 2, _PINHOLE, _full_opencv),
    "SIMPLE_FISHEYE": _CameraModel(3, 1, _FISHEYE),
    "FISHEYE": _CameraModel(4, 2, _FISHEYE),
    "SIMPLE_RADIAL_FISHEYE": _CameraModel(4, 1, _FISHEYE, _RADIAL),
    "RADIAL_FISHEYE": _CameraModel(5, 1, _FISHEYE, _RADIAL),
    "OPENCV_FISHEYE": _CameraModel(8, 2, _FISHEYE, _RADIAL),
    "THIN_PRISM_FISHEYE": _CameraModel(12, 2, _FISHEYE, _thin_prism),
    "RAD_TAN_THIN_PRISM_FISHEYE": _CameraModel(16, 2, _FISHEYE, _rad_tan_thin_prism),
    "FOV": _CameraModel(5, 2, _FOV),
    "SIMPLE_DIVISION": _CameraModel(4, 1, _DIVISION),
    "DIVISION": _CameraModel(5, 2, _DIVISION),
    "EQUIRECTANGULAR": _CameraModel(2, 0, _SPHERE),
}
MODELS = tuple(_MODELS)
"""The names of all supported camera models."""


def _model(name: str) -> _CameraModel:
    if name not in _MODELS:
        raise InputError(f"camera model {name!r} is not known; use one of {', '.join(MODELS)}", code="I310")
    return _MODELS[name]


def parameter_count(model: str) -> int:
    """Returns the number of parameters of a COLMAP camera model.

    Raises InputError (I310) that lists the known models.
    """
    return _model(model).count


def is_pinhole(model: str, params: Float) -> bool:
    """Whether the camera is an undistorted pinhole, for which a homography is exact."""
    _, _, lens = _parts(model, tuple(map(float, params)))
    return _model(model).base == _PINHOLE and lens == Lens(
        tuple(0.0 for _ in lens.radial), tuple(0.0 for _ in lens.divisor)
    )


def calibration_matrix(model: str, params: Float) -> Float:
    """Returns the matrix K (3, 3) of the undistorted camera, first pixel centre at 0.5.

    Raises InputError (I310) for a camera that has none (EQUIRECTANGULAR).
    """
    if _model(model).base == _SPHERE:
        raise InputError(f"a {model} camera has no calibration matrix; use the full projection", code="I310")
    (fx, fy), (cx, cy), _ = _parts(model, tuple(map(float, params)))
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


@lru_cache(maxsize=256)
def _parts(name: str, params: tuple[float, ...]) -> tuple[tuple[float, float], tuple[float, float], Lens]:
    """Focal lengths, principal point and lens of a camera."""
    model = _model(name)
    if len(params) != model.count:
        raise InputError(f"a {name} camera has {model.count} parameters, not {len(params)}", code="I310")
    if model.base == _SPHERE:
        return (params[0], params[1]), (0.5 * params[0], 0.5 * params[1]), Lens()
    f, rest = params[: model.focals], params[model.focals :]
    return (f[0], f[-1]), (rest[0], rest[1]), model.lens(*rest[2:])


def project(model: str, params: Float, xyz_camera: Float) -> Float:
    """Projects points (n, 3) of the camera frame to pixels (n, 2); NaN where the camera cannot see.

    Raises InputError (I310) for an unknown model.
    """
    p = tuple(np.asarray(params, np.float64).tolist())
    focal, centre, lens = _parts(model, p)
    xyz = np.atleast_2d(np.asarray(xyz_camera, np.float64))
    with np.errstate(invalid="ignore", divide="ignore"):
        xy = _PROJECT[_model(model).base](xyz, p[-1])
    if lens.radial or not lens.is_radial:
        xy = lens.distort(xy)
    pixels: Float = xy * np.array(focal) + np.array(centre)
    return pixels


def unproject(model: str, params: Float, pixels: Float) -> Float:
    """Returns the unit directions (n, 3) of pixels (n, 2) in the camera frame; NaN where there is none.

    Raises InputError (I310) for an unknown model.
    """
    p = tuple(map(float, params))
    focal, centre, lens = _parts(model, p)
    xy = (np.atleast_2d(np.asarray(pixels, np.float64)) - np.array(centre)) / np.array(focal)
    if lens.radial or not lens.is_radial:
        xy = lens.undistort(xy)
    with np.errstate(invalid="ignore", divide="ignore"):
        ray = _UNPROJECT[_model(model).base](xy, p[-1])
    unit: Float = ray / np.linalg.norm(ray, axis=1, keepdims=True)
    return unit


def _plane(xyz: Float, _: float) -> Float:
    """Central projection x/z, y/z; NaN behind the camera."""
    z = np.where(xyz[:, 2] > 0, xyz[:, 2], np.nan)
    xy: Float = xyz[:, :2] / z[:, None]
    return xy


def _plane_back(xy: Float, _: float) -> Float:
    return np.column_stack([xy, np.ones(len(xy))])


def _fisheye(xyz: Float, _: float) -> Float:
    """Equidistant projection: radius = angle from the axis."""
    r = np.hypot(xyz[:, 0], xyz[:, 1])
    theta = np.where(np.abs(xyz).sum(1) > 0, np.arctan2(r, xyz[:, 2]), np.nan)
    theta[(r == 0) & (xyz[:, 2] < 0)] = np.nan  # the direction straight back has no place in the picture
    xy: Float = xyz[:, :2] * np.where(r > 0, theta / np.where(r > 0, r, 1.0), theta)[:, None]
    return xy


def _fisheye_back(xy: Float, _: float) -> Float:
    theta = np.hypot(xy[:, 0], xy[:, 1])
    theta = np.where(theta < np.pi, theta, np.nan)
    return np.column_stack([xy * np.sinc(theta / np.pi)[:, None], np.cos(theta)])


def _fov(xyz: Float, omega: float) -> Float:
    """Devernay and Faugeras' field-of-view model: r_d = atan(2 r tan(w/2)) / w."""
    xy = _plane(xyz, 0.0)
    if abs(omega) < 1e-9:
        return xy
    r = np.hypot(xy[:, 0], xy[:, 1])
    slope = 2 * np.tan(omega / 2)
    bent: Float = (
        xy * np.where(r > 0, np.arctan(slope * r) / (np.where(r > 0, r, 1.0) * omega), slope / omega)[:, None]
    )
    return bent


def _fov_back(xy: Float, omega: float) -> Float:
    if abs(omega) < 1e-9:
        return _plane_back(xy, 0.0)
    r = np.hypot(xy[:, 0], xy[:, 1])
    angle = np.where(r * abs(omega) < np.pi / 2, r * omega, np.nan)
    slope = 2 * np.tan(omega / 2)
    return _plane_back(
        xy * np.where(r > 0, np.tan(angle) / (slope * np.where(r > 0, r, 1.0)), omega / slope)[:, None], 0.0
    )


def _division(xyz: Float, k: float) -> Float:
    """Fitzgibbon's division model: x_u = x_d / (1 + k r_d^2), solved for x_d; NaN past its fold."""
    xy = _plane(xyz, 0.0)
    bent: Float = xy * (2.0 / (1.0 + np.sqrt(1.0 - 4.0 * k * (xy**2).sum(1))))[:, None]
    return bent


def _division_back(xy: Float, k: float) -> Float:
    q = k * (xy**2).sum(1)
    return _plane_back(xy / np.where(np.abs(q) < 1.0, 1.0 + q, np.nan)[:, None], 0.0)


def _sphere(xyz: Float, _: float) -> Float:
    """Longitude and latitude (downwards) from the centre, as shares of width and height."""
    r = np.linalg.norm(xyz, axis=1)
    latitude = np.arcsin(xyz[:, 1] / np.where(r > 0, r, np.nan))
    return np.column_stack([np.arctan2(xyz[:, 0], xyz[:, 2]) / (2 * np.pi), latitude / np.pi])


def _sphere_back(xy: Float, _: float) -> Float:
    lon, lat = 2 * np.pi * xy[:, 0], np.pi * xy[:, 1]
    return np.column_stack([np.sin(lon) * np.cos(lat), np.sin(lat), np.cos(lon) * np.cos(lat)])


_PROJECT = {_PINHOLE: _plane, _FISHEYE: _fisheye, _FOV: _fov, _DIVISION: _division, _SPHERE: _sphere}
_UNPROJECT = {
    _PINHOLE: _plane_back,
    _FISHEYE: _fisheye_back,
    _FOV: _fov_back,
    _DIVISION: _division_back,
    _SPHERE: _sphere_back,
}
