"""Resamples a picture along a smooth map: sharp when magnifying, free of aliasing when minifying.

Bilinear interpolation (paper A, section 3.2) skips source pixels where the photo is finer than the
ortho-image, and blurs it where the photo is coarser. Here the local map of a tile is described by its
Jacobian J (source px per target px) with singular values s1 >= s2:

- s1 > 1.2, minifying: whole octaves are averaged away in linear light; the rest is prefiltered with the
  Gaussian that an elliptical weighted average (Heckbert 1989) would use, of covariance ``(J J^T - I) / 4``;
  then the source is sampled bilinearly.
- otherwise: the source is magnified by cubic interpolation to twice its density (four times where it is much
  coarser), and then sampled bilinearly in steps that are too small to blur it. This takes half the time of
  cubic sampling. Where s1 < 0.7 an overshoot of the cubic could be visible; it is clamped to the range of the
  neighbours, so that nothing rings.

Pictures are sampled with four channels, because OpenCV's bilinear remap is then twice as fast as with three.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.raster.light import TO_CODE_8, TO_LINEAR_16
from frontage.raster.sourcemap import EVERYTHING, SourceMap

INTERPOLATIONS = ("adaptive", "bilinear", "nearest")
MINIFYING = 1.2  # source px per target px, above which a prefilter is used
MAGNIFYING = 0.7  # source px per target px, below which the overshoot of a cubic is visible
_NARROW_PX = 0.3  # a Gaussian of a smaller sigma has no effect
_REACH = 2.2  # sigmas at which a Gaussian is truncated (97 % of it)
_UPRIGHT = 0.1  # px^2, negligible covariance between rows and columns (or a fifth of the variance)
_MARGIN_PX = 4  # of source around the positions of the map, for the kernels
_FEW_PX = 3000  # of the target, below which preparing the source takes longer than sampling it
_CACHE_BYTES = 1 << 20  # of the source of a strip; beyond the cache of a core, sampling is 1.5 times slower
_CV = {"bilinear": cv2.INTER_LINEAR, "nearest": cv2.INTER_NEAREST}


def resample(
    image: Array,
    at: SourceMap,
    interpolation: str = "adaptive",
    out: Array | None = None,
    window: tuple[slice, slice] = EVERYTHING,
    rough: bool = False,
) -> Array:
    """Samples `image` (h, w, 3) uint8 along a map of shape (m, n); returns (m, n, 4) uint8 with alpha 255.

    `interpolation` is one of `INTERPOLATIONS`. Unknown positions and those outside take the colour of the
    nearest edge; the caller has to mask them. If `out` is given, which may be a window of a larger picture,
    the result is written to it. `window` selects some rows and columns of the map; `out` is that of these.
    With a single channel, `out` (m, n) takes grey values.
    Where the photo is several times as fine as the target, a `rough` picture averages the first octave in
    codes instead of light. That takes half of the time; black and white in equal parts make a code of 128
    then, and not of 188.
    """
    rows, columns = (range(*part.indices(size)) for part, size in zip(window, at.shape, strict=True))
    out = np.empty((len(rows), len(columns), 4), np.uint8) if out is None else out
    if not at.known:
        out[:] = 0 if out.ndim == 2 else (0, 0, 0, 255)
        return out
    kernel = _kernel(at.derivatives, interpolation, rough)
    if kernel.direct is not None and out.ndim == 3 and len(rows) * len(columns) <= _FEW_PX:
        planes = at.planes((0.0, 0.0), 1.0, window)
        few = cv2.remap(image, *planes, kernel.direct, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(cv2.cvtColor(few, cv2.COLOR_RGB2RGBA, dst=out))
    strip = max(8, int(_CACHE_BYTES / (4 * len(columns) * max(kernel.scale, kernel.step, 1.0) ** 2)))
    for first in range(rows.start, rows.stop, strip):
        part = slice(first, min(first + strip, rows.stop)), window[1]
        _sample(image, at, part, kernel, out[first - rows.start :][:strip])
    return out


@dataclass(frozen=True)
class _Kernel:
    """What is done to a part of the source before it is sampled; `scale` = its density afterwards.

    A `direct` flag of OpenCV samples the source itself in the same way, which is faster for few pixels.
    """

    scale: float
    prepared: Callable[[Array], Array]
    flag: int = cv2.INTER_LINEAR
    direct: int | None = None

    @cached_property
    def step(self) -> int:
        """The number of source px, along one axis, that become one."""
        return max(1, round(1.0 / self.scale))

    @cached_property
    def margin(self) -> int:
        """The number of source px around the positions of a map that the kernels need."""
        return _MARGIN_PX * self.step


@lru_cache(maxsize=64)
def _kernel(derivatives: tuple[float, ...], interpolation: str, rough: bool) -> _Kernel:
    """Chooses the kernel for a map whose Jacobian has these four derivatives, row by row."""
    jacobian = np.reshape(derivatives, (2, 2))
    if interpolation != "adaptive":
        return _Kernel(1.0, lambda source: source, _CV[interpolation])
    stretch = _stretch(jacobian)
    if stretch > MINIFYING:
        step = 1 << int(np.floor(np.log2(stretch)))
        blurred = _gaussian(jacobian / step)
        if step == 1:
            return _Kernel(1.0, blurred)
        averaged = _roughly_averaged if rough and step > 2 else _averaged
        return _Kernel(1.0 / step, lambda source: blurred(averaged(source, step)))
    factor, clamp = 4 if stretch <= 0.5 else 2, stretch < MAGNIFYING
    direct = None if clamp else cv2.INTER_CUBIC
    return _Kernel(factor, lambda source: _magnified(source, factor, clamp), direct=direct)


def _stretch(jacobian: Float) -> float:
    """Returns the larger singular value of a (2, 2) matrix."""
    (a, b), (c, d) = jacobian.tolist()
    total, det = a * a + b * b + c * c + d * d, a * d - b * c
    return float(np.sqrt(0.5 * (total + np.sqrt(max(total * total - 4 * det * det, 0.0)))))


def _span(low: float, high: float, margin: int, size: int, step: int) -> tuple[int, int]:
    """First and last (excluded) source pixel that is needed, within the picture and on the grid of `step`."""
    first = min(max(math.floor(low) - margin, 0), size - 1) // step * step
    last = max(-(-(math.ceil(high) + margin) // step) * step, first + 1)
    return first, min(last, size)


def _sample(image: Array, at: SourceMap, window: tuple[slice, slice], kernel: _Kernel, out: Array) -> None:
    """Samples a window of a map; cv2.remap needs sides below 32767 px, which the callers' tiles have."""
    base = (float(np.floor(at.low[0])), float(np.floor(at.low[1])))
    planes = at.planes(base, kernel.scale, window)
    spans = []
    for plane, first, size in zip(planes, base, image.shape[1::-1], strict=True):
        low, high, _, _ = cv2.minMaxLoc(plane)
        low, high = first + (low + 0.5) / kernel.scale, first + (high + 0.5) / kernel.scale
        spans.append(_span(low, high, kernel.margin, size, kernel.step))
        plane -= (spans[-1][0] - first) * kernel.scale
    (c0, c1), (r0, r1) = spans
    part = image[r0:r1, c0:c1]
    source = kernel.prepared(cv2.cvtColor(part, cv2.COLOR_RGB2GRAY) if out.ndim == 2 else part)
    if source.ndim == 3 and source.shape[2] == 3:
        source = cv2.cvtColor(source, cv2.COLOR_RGB2RGBA)
    if source.dtype == np.uint8:
        cv2.remap(source, *planes, kernel.flag, dst=out, borderMode=cv2.BORDER_REPLICATE)
        return
    light = cv2.remap(source, *planes, kernel.flag, borderMode=cv2.BORDER_REPLICATE)
    np.take(TO_CODE_8, light, out=out)


def _roughly_averaged(source: Array, step: int) -> Array:
    """Averages blocks of step x step px like `_averaged`, the first octave of them in codes."""
    return _averaged(_reduced(source, 2), step // 2)


def _reduced(source: Array, step: int) -> Array:
    """Averages the values of blocks of step x step px: (ceil h/step, ceil w/step, 3)."""
    h, w = source.shape[:2]
    if h % step or w % step:
        source = cv2.copyMakeBorder(source, 0, -h % step, 0, -w % step, cv2.BORDER_REPLICATE)
    while step > 1:  # a power of two; halving is much faster than larger steps
        half = source.shape[1] // 2, source.shape[0] // 2
        source, step = cv2.resize(source, half, interpolation=cv2.INTER_AREA), step // 2
    return source


def _averaged(source: Array, step: int) -> Array:
    """Averages blocks of step x step px in linear light: (ceil h/step, ceil w/step, 3) uint16."""
    return _reduced(cv2.LUT(source, TO_LINEAR_16), step)


def _gaussian(jacobian: Float) -> Callable[[Array], Array]:
    """Returns the function that blurs by a Gaussian of covariance (J J^T - I) / 4, where that is positive."""
    values, axes = np.linalg.eigh(jacobian @ jacobian.T)
    values = np.maximum((values - 1.0) / 4.0, 0.0)
    if values[-1] <= _NARROW_PX**2:
        return lambda source: source
    (a, b), (_, d) = (axes * values) @ axes.T
    if abs(b) <= max(_UPRIGHT, 0.2 * max(a, d)):  # an ellipse along rows and columns, or a circle
        sigma = np.sqrt(np.maximum([a, d], 1e-4))
        w, h = (2 * max(int(np.ceil(_REACH * s - 0.5)), 0) + 1 for s in sigma)
        return lambda source: cv2.GaussianBlur(source, (w, h), sigma[0], sigmaY=sigma[1])
    reach = int(np.ceil(_REACH * np.sqrt(max(a, d)) - 0.5))
    x, y = np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1))
    inverse = np.linalg.inv(np.array([[a, b], [b, d]]) + 0.02 * np.eye(2))
    kernel = np.exp(-0.5 * (inverse[0, 0] * x * x + 2 * inverse[0, 1] * x * y + inverse[1, 1] * y * y))
    kernel /= kernel.sum()
    return lambda source: cv2.filter2D(source, -1, kernel)


def _magnified(source: Array, factor: int, clamp: bool) -> Array:
    """Magnifies colours (h, w, 3) by `factor` to RGBA, or grey values (h, w) to grey values.

    With `clamp`, no value leaves the range of its neighbours.
    """
    if source.ndim == 3:
        source = cv2.cvtColor(source, cv2.COLOR_RGB2RGBA)
    size = (source.shape[1] * factor, source.shape[0] * factor)
    large: Array = cv2.resize(source, size, interpolation=cv2.INTER_CUBIC)
    if clamp:
        box = np.ones((3, 3), np.uint8)
        low = cv2.resize(cv2.erode(source, box), size, interpolation=cv2.INTER_NEAREST)
        high = cv2.resize(cv2.dilate(source, box), size, interpolation=cv2.INTER_NEAREST)
        large = cv2.min(cv2.max(large, low, dst=large), high, dst=large)
    return large
