"""Derivatives of a projection by the point and by the parameters of the camera, for every camera model.

The models up to OPENCV have closed forms: each is OPENCV with parameters left out or shared. All others use
central differences. Since every model is central, the pixel depends on the direction of the ray only: the
derivative by the point is taken along two directions across the ray and is exactly zero along it. Differences
of unit vectors with a step of 1e-5 have a relative error below 1e-9.
"""

from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.model.photo import Camera

_STEP = 1e-5  # rad across the ray
_RELATIVE_STEP = 1e-5  # of a focal length or principal point (px), in which the projection is linear
_COEFFICIENT_STEP = 1e-4  # of a distortion coefficient, in most of which the projection is linear

# For each parameter of a model, the numbers of the OPENCV parameters (fx fy cx cy k1 k2 p1 p2) that it sets.
_AS_OPENCV: dict[str, tuple[tuple[int, ...], ...]] = {
    "SIMPLE_PINHOLE": ((0, 1), (2,), (3,)),
    "PINHOLE": ((0,), (1,), (2,), (3,)),
    "SIMPLE_RADIAL": ((0, 1), (2,), (3,), (4,)),
    "RADIAL": ((0, 1), (2,), (3,), (4,), (5,)),
    "OPENCV": ((0,), (1,), (2,), (3,), (4,), (5,), (6,), (7,)),
}


def by_point(camera: Camera, xyz: Float) -> Float:
    """Derivative (m, 2, 3), px per m, of the pixels of points (m, 3) m of the camera frame."""
    if camera.model in _AS_OPENCV:
        return _closed_by_point(_opencv_parameters(camera), xyz)
    distance = np.sqrt(np.einsum("mi,mi->m", xyz, xyz))
    ray = xyz / distance[:, None]
    total = np.zeros((len(xyz), 2, 3))
    for across in _across(ray):
        change = camera.project(ray + _STEP * across) - camera.project(ray - _STEP * across)
        total += change[:, :, None] * across[:, None, :]
    total *= (0.5 / _STEP / distance)[:, None, None]
    return total


def by_parameters(camera: Camera, xyz: Float, free: Int) -> Float:
    """Derivative (m, 2, f), px per unit, of the pixels of points (m, 3) by the parameters `free` (f,)."""
    if camera.model in _AS_OPENCV and len(free):
        full = _closed_by_parameters(_opencv_parameters(camera), xyz)
        sets = _AS_OPENCV[camera.model]
        return np.stack([full[:, :, list(sets[i])].sum(axis=2) for i in free], axis=2)
    total = np.empty((len(xyz), 2, len(free)))
    for column, index in enumerate(free):
        value = camera.params[index]
        # Focal lengths and principal point are many pixels; distortion coefficients are of the order of one.
        step = _RELATIVE_STEP * abs(value) if abs(value) > 10.0 else _COEFFICIENT_STEP
        total[:, :, column] = _shifted(camera, int(index), step, xyz) - _shifted(
            camera, int(index), -step, xyz
        )
        total[:, :, column] /= 2 * step
    return total


def _shifted(camera: Camera, index: int, step: float, xyz: Float) -> Float:
    """The pixels (m, 2) with one parameter changed."""
    params = camera.params.copy()
    params[index] += step
    return replace(camera, params=params).project(xyz)


def _across(ray: Float) -> tuple[Float, Float]:
    """Two unit vectors (m, 3) across unit rays (m, 3) and across each other."""
    axis = np.zeros_like(ray)
    axis[np.arange(len(ray)), np.argmin(np.abs(ray), axis=1)] = 1.0
    first = np.cross(ray, axis)
    first /= np.sqrt(np.einsum("mi,mi->m", first, first))[:, None]
    return first, np.cross(ray, first)


def _opencv_parameters(camera: Camera) -> Float:
    full = np.zeros(8)
    for value, numbers in zip(camera.params, _AS_OPENCV[camera.model], strict=True):
        full[list(numbers)] = value
    return full


def _closed_by_point(opencv: Float, xyz: Float) -> Float:
    fx, fy, _, _, k1, k2, p1, p2 = opencv
    inverse_depth = 1.0 / xyz[:, 2]
    x, y = xyz[:, 0] * inverse_depth, xyz[:, 1] * inverse_depth
    q = x * x + y * y
    radial, slope = 1.0 + q * (k1 + q * k2), k1 + 2.0 * k2 * q
    cross = 2.0 * (x * y * slope + p1 * x + p2 * y)
    by_x = radial + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    by_y = radial + 2.0 * y * y * slope + 2.0 * p2 * x + 6.0 * p1 * y
    total = np.empty((len(xyz), 2, 3))
    for row, (focal, along, across) in enumerate(((fx, by_x, cross), (fy, cross, by_y))):
        total[:, row, 0] = focal * inverse_depth * along
        total[:, row, 1] = focal * inverse_depth * across
        total[:, row, 2] = -(total[:, row, 0] * x + total[:, row, 1] * y)
    return total


def _closed_by_parameters(opencv: Float, xyz: Float) -> Float:
    fx, fy, _, _, k1, k2, p1, p2 = opencv
    x, y = xyz[:, 0] / xyz[:, 2], xyz[:, 1] / xyz[:, 2]
    q, xy = x * x + y * y, 2.0 * x * y
    radial = 1.0 + q * (k1 + q * k2)
    total = np.zeros((len(xyz), 2, 8))
    total[:, 0, 0] = x * radial + p1 * xy + p2 * (q + 2.0 * x * x)
    total[:, 1, 1] = y * radial + p2 * xy + p1 * (q + 2.0 * y * y)
    total[:, 0, 2] = total[:, 1, 3] = 1.0
    total[:, 0, 4:] = fx * np.stack([x * q, x * q * q, xy, q + 2.0 * x * x], axis=1)
    total[:, 1, 4:] = fy * np.stack([y * q, y * q * q, q + 2.0 * y * y, xy], axis=1)
    return total
