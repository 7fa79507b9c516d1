"""Develops light to an 8-bit picture: blur, vignetting, exposure, noise, white balance, tone curve."""

from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.simulate.sensors.cameras import CameraSpec

_MIDDLE = 0.25  # linear level at which the exposure places the typical brightness
_BRIGHT_QUANTILE = 0.97  # of the brightness, which the exposure tries not to saturate
_CONTRAST = 0.03  # amplitude of the S-shaped curve that cameras usually add to that of sRGB
_GREY_WORLD = 0.25  # exponent of the correction towards a grey mean
_BAND = 256  # rows that share a random generator
_LUMA = np.array([0.30, 0.59, 0.11], np.float32)


def _tone_table() -> Array:
    light = np.arange(65536) / 65535.0
    code = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    curve = code + _CONTRAST * np.sin(2 * np.pi * (code - 0.5))
    return np.rint(255 * np.clip(curve, 0, 1)).astype(np.uint8)


_TONE = _tone_table()


def encode(light: Array) -> Array:
    """Encode linear light (..., 3), 1 = saturated, as uint8: sRGB's curve with a camera's usual contrast."""
    return np.asarray(np.take(_TONE, np.clip(light * 65535, 0, 65535).astype(np.uint16)))


def develop(light: Array, spec: CameraSpec, rng: np.random.Generator) -> Array:
    """Return the picture (h, w, 3) uint8 RGB of the light (h, w, 3) float32 on the sensor.

    The variance of the noise is signal / full_well + (read_noise / full_well)^2, in units of a saturated
    pixel. Pixels that the lens does not see (light exactly 0) stay black.
    """
    thin = light[::8, ::8][light[::8, ::8].any(axis=2)]
    gain = _exposure(thin) * 2.0 ** rng.normal(0, spec.exposure_jitter)
    jitter = np.exp(rng.normal(0, spec.white_balance_jitter, 2))
    red, blue = jitter * _balance(thin)
    balance = np.array([red, 1.0, blue], np.float32)
    loss = 0.0 if spec.model == "EQUIRECTANGULAR" else spec.vignetting  # stitched panoramas have none
    bands = range(0, len(light), _BAND)
    seeds = rng.integers(2**63, size=len(bands))
    out = np.empty(light.shape, np.uint8)

    def band(k: int) -> None:
        first, end = bands[k], min(bands[k] + _BAND, len(light))
        seen = np.asarray(light[first:end].any(axis=2))
        signal = _blurred(light, first, end, spec.psf) * np.float32(gain)
        signal *= _vignette(light.shape, loss, first, end)[..., None]
        signal = _noisy(signal, spec, np.random.default_rng(seeds[k]))
        out[first:end] = encode(signal * balance * seen[..., None])

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(band, range(len(bands))))
    return out


def _blurred(light: Array, first: int, end: int, sigma: float) -> Array:
    """Blurs rows `first` to `end` - 1 by a Gaussian of `sigma` px."""
    if sigma <= 0:
        return light[first:end]
    margin = int(np.ceil(4 * sigma)) + 1
    top, bottom = max(first - margin, 0), min(end + margin, len(light))
    wide = cv2.GaussianBlur(light[top:bottom], (0, 0), sigma, borderType=cv2.BORDER_REFLECT)
    return np.asarray(wide[first - top : end - top])


def _noisy(signal: Array, spec: CameraSpec, rng: np.random.Generator) -> Array:
    grain = rng.standard_normal(signal.shape, dtype=np.float32)
    floor = (spec.read_noise / spec.full_well) ** 2
    grain *= np.sqrt(np.maximum(signal, 0) * np.float32(1 / spec.full_well) + np.float32(floor))
    grain += signal
    return np.minimum(grain, np.float32(1.0))


def _vignette(shape: tuple[int, ...], loss: float, first: int, end: int) -> Array:
    """Returns the transmission (rows, w) float32: 1 in the middle, 1 - `loss` in the corners."""
    h, w = shape[:2]
    y, x = (np.linspace(-1, 1, n, dtype=np.float32) for n in (h, w))
    r2 = ((y[first:end, None] * h) ** 2 + (x * w) ** 2) / np.float32(h * h + w * w)
    return np.asarray(1 - np.float32(loss) * (0.6 * r2 + 0.4 * r2 * r2), np.float32)


def _exposure(thin: Array) -> float:
    """Returns the gain of an automatic exposure: typical light at the middle level, few saturated pixels."""
    if not len(thin):
        return 1.0
    luma = thin @ _LUMA
    typical = float(np.exp(np.log(np.maximum(luma, 1e-4)).mean()))
    bright = float(np.quantile(luma, _BRIGHT_QUANTILE))
    return float(min(_MIDDLE / typical, 1.6 / max(bright, 1e-6)))


def _balance(thin: Array) -> Float:
    """Returns the gains of red and blue of an automatic white balance: part of the way to a grey mean."""
    mean = np.maximum(thin.mean(0), 1e-4) if len(thin) else np.ones(3)
    return np.asarray((mean[1] / mean[[0, 2]]) ** _GREY_WORLD, np.float64)
