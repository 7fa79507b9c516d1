"""Resampling a picture along a smooth map: sharp when magnifying, free of aliasing when minifying.

Bilinear interpolation (paper A, 3.2) drops source pixels as soon as the photo is finer than the ortho-image.
Here the local map of a tile is summed up by its Jacobian J (source px per target px), and the source is
prefiltered with the Gaussian that an elliptical weighted average (Heckbert 1989) would use there: covariance
``(J J^T - I) / 4`` along the axes where J stretches, after whole octaves were averaged away in linear light.
"""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float

INTERPOLATIONS = ("adaptive", "bilinear", "nearest")
MINIFYING = 1.2  # source px per target px beyond which a prefilter pays
_MARGIN = 12  # px of source kept around what the map asks for: reach of the kernels
_REMAP_LIMIT = 32767  # px: sides of pictures that cv2.remap takes
_CV = {"adaptive": cv2.INTER_CUBIC, "bilinear": cv2.INTER_LINEAR, "nearest": cv2.INTER_NEAREST}

_CODE = np.arange(256) / 255.0
_TO_LINEAR = np.where(_CODE <= 0.04045, _CODE / 12.92, ((_CODE + 0.055) / 1.055) ** 2.4)
_TO_LINEAR_16 = np.rint(_TO_LINEAR * 65535).astype(np.uint16)
_LIGHT = np.arange(65536) / 65535.0
_TO_CODE_8 = np.rint(
    255 * np.where(_LIGHT <= 0.0031308, 12.92 * _LIGHT, 1.055 * _LIGHT ** (1 / 2.4) - 0.055)
).astype(np.uint8)


def resample(image: Array, at: Array, jacobian: Float, interpolation: str = "adaptive") -> Array:
    """Sample `image` (h, w, 3) uint8 at `at` (m, n, 2) px (pixel centre at 0.5): (m, n, 3) uint8.

    `jacobian` (2, 2) is the typical d(source)/d(target) of the map. Positions that are NaN or outside give
    the nearest edge's colour; the caller masks them.
    """
    h, w = image.shape[:2]
    if interpolation != "adaptive" and max(h, w) < _REMAP_LIMIT:
        return _sample(image, _shifted(at, 0, 0, 1), _CV[interpolation])
    (u0, u1), (v0, v1) = _range(at)
    if not np.isfinite([u0, v0]).all():
        return np.zeros((*at.shape[:2], 3), np.uint8)
    stretch = float(np.linalg.svd(jacobian, compute_uv=False)[0])
    octaves = max(0, int(np.floor(np.log2(max(stretch, 1.0))))) if interpolation == "adaptive" else 0
    step, margin = 1 << octaves, _MARGIN << octaves
    c0, c1 = _span(u0, u1, margin, w, step)
    r0, r1 = _span(v0, v1, margin, h, step)
    source = image[r0:r1, c0:c1]
    place = _shifted(at, c0, r0, step)
    if interpolation != "adaptive":
        return _sample(source, place, _CV[interpolation])
    if octaves:
        source = _averaged(source, step)
    source = _prefiltered(source, jacobian / step)
    sampled = _sample(source, place, cv2.INTER_CUBIC)
    if stretch <= 1.0:
        sampled = _without_ringing(sampled, source, place)
    return np.take(_TO_CODE_8, sampled) if sampled.dtype == np.uint16 else sampled


def _shifted(at: Array, column: int, row: int, step: int) -> Array:
    """Map positions as OpenCV counts them (centres at whole numbers) in a cut-out reduced by `step`."""
    place: Array = cv2.add(np.asarray(at, np.float32), (-column - 0.5 * step, -row - 0.5 * step, 0.0, 0.0))
    if step > 1:
        place /= step
    cv2.patchNaNs(place, -1.0)
    return place


def _range(at: Array) -> tuple[tuple[float, float], tuple[float, float]]:
    """Smallest and largest known u and v of a map, NaN when there is none."""
    u, v = cv2.split(at)  # OpenCV's extremes are several times faster than numpy's on such small arrays
    (u0, u1, _, _), (v0, v1, _, _) = cv2.minMaxLoc(u), cv2.minMaxLoc(v)
    if np.isfinite(cv2.sumElems(at)[:2]).all():
        return (u0, u1), (v0, v1)
    known = np.isfinite(u) & np.isfinite(v)
    if not known.any():
        return (np.nan, np.nan), (np.nan, np.nan)
    u, v = u[known], v[known]
    return (float(u.min()), float(u.max())), (float(v.min()), float(v.max()))


def _span(low: float, high: float, margin: int, size: int, step: int) -> tuple[int, int]:
    """First and last source pixel needed, inside the picture and on the grid of `step`."""
    first = int(np.clip(np.floor(low) - margin, 0, size - 1)) // step * step
    last = int(np.clip(np.ceil(high) + margin, first + 1, size))
    return first, last


def _averaged(source: Array, step: int) -> Array:
    """Blocks of step x step px averaged in linear light: (ceil h/step, ceil w/step, 3) uint16."""
    light = cv2.LUT(source, _TO_LINEAR_16)
    h, w = light.shape[:2]
    light = cv2.copyMakeBorder(light, 0, -h % step, 0, -w % step, cv2.BORDER_REPLICATE)
    small: Array = cv2.resize(
        light, (light.shape[1] // step, light.shape[0] // step), interpolation=cv2.INTER_AREA
    )
    return small


def _prefiltered(source: Array, jacobian: Float) -> Array:
    """`source` blurred by a Gaussian of covariance (J J^T - I)/4 where J stretches by more than MINIFYING."""
    values, axes = np.linalg.eigh(jacobian @ jacobian.T)
    if np.sqrt(values[-1]) <= MINIFYING:
        return source
    covariance = (axes * (np.maximum(values - 1.0, 0.0) / 4.0)) @ axes.T
    (a, b), (_, d) = covariance
    if abs(b) <= 0.1 * max(a, d):  # an upright photo: the ellipse lies along rows and columns
        sigma = np.sqrt(np.maximum([a, d], 1e-4))
        size = 2 * np.ceil(2.5 * sigma).astype(int) + 1
        blurred: Array = cv2.GaussianBlur(source, (int(size[0]), int(size[1])), sigma[0], sigmaY=sigma[1])
        return blurred
    reach = int(np.ceil(2.5 * np.sqrt(max(a, d))))
    x, y = np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1))
    inverse = np.linalg.inv(covariance + 0.02 * np.eye(2))
    kernel = np.exp(-0.5 * (inverse[0, 0] * x * x + 2 * inverse[0, 1] * x * y + inverse[1, 1] * y * y))
    blurred = cv2.filter2D(source, -1, kernel / kernel.sum())
    return blurred


def _sample(source: Array, place: Array, flag: int) -> Array:
    """cv2.remap, whose pictures and maps must stay below 32767 px: the caller's tiles do."""
    sampled: Array = cv2.remap(source, place, None, flag, borderMode=cv2.BORDER_REPLICATE)
    return sampled


def _without_ringing(sampled: Array, source: Array, place: Array) -> Array:
    """Clamp a cubic sample to the range of the source pixels around it."""
    box = np.ones((3, 3), np.uint8)
    low = _sample(cv2.erode(source, box), place, cv2.INTER_NEAREST)
    high = _sample(cv2.dilate(source, box), place, cv2.INTER_NEAREST)
    clamped: Array = np.clip(sampled, low, high)
    return clamped
