"""Random fields for textures: smooth noise of a chosen wavelength, and one random number per cell of a grid.

Smooth noise is read from one periodic tile (a narrow band of frequencies, made once by FFT), so an octave
costs one table look-up. Every field takes the footprint of a pixel and fades out before it would alias.
"""

from functools import lru_cache

import cv2
import numpy as np

from frontage.geometry.arrays import Array

_SIDE = 512  # texels along each side of the tile
_WAVE = 8  # texels per wavelength: the noise repeats after 64 waves
_ROW = 4096  # samples per row handed to cv2.remap, which refuses sides above 32767


@lru_cache(maxsize=1)
def _tile() -> Array:
    """Makes periodic noise (512, 512) float32: mean 0, standard deviation 1, wavelengths 5.5 to 16 texels."""
    rng = np.random.default_rng(20240229)
    f = np.hypot(*np.meshgrid(np.fft.fftfreq(_SIDE), np.fft.fftfreq(_SIDE)))
    band = np.exp(-0.5 * (np.log(np.maximum(f, 1e-9) * _WAVE) / 0.3) ** 2)
    field = np.fft.ifft2(np.fft.fft2(rng.normal(size=(_SIDE, _SIDE))) * band).real
    return np.asarray((field - field.mean()) / field.std(), np.float32)


def scramble(seed: Array, salt: int) -> Array:
    """Return a repeatable 32-bit hash (n,) uint32 of seeds (n,)."""
    h = np.asarray(seed).astype(np.uint32) * np.uint32(0x9E3779B1) + np.uint32(
        (salt * 0x85EBCA77) & 0xFFFFFFFF
    )
    h = (h ^ (h >> np.uint32(15))) * np.uint32(0x2C1B3C6D)
    h = (h ^ (h >> np.uint32(12))) * np.uint32(0x297A2D39)
    return np.asarray(h ^ (h >> np.uint32(15)))


def cell(i: Array, j: Array, seed: Array, salt: int = 0) -> Array:
    """Return one random number 0..1 (n,) float32 per cell (i, j) (n,) of an integer grid, by seed (n,)."""
    mixed = np.asarray(i).astype(np.int32).view(np.uint32) * np.uint32(0x85EBCA77)
    mixed = (mixed ^ (mixed >> np.uint32(13))) + np.asarray(j).astype(np.int32).view(np.uint32)
    return (scramble(mixed ^ np.asarray(seed).astype(np.uint32), salt) >> np.uint32(8)) * np.float32(2**-24)


def wave(
    u: Array, v: Array, length: float | tuple[float, float], *, seed: Array, salt: int, blur: Array
) -> Array:
    """Return smooth noise (n,) float32 of one wavelength, with mean 0 and standard deviation 1.

    u, v     (n,) float32 m, position
    length   m, wavelength, or one each along u and along v
    seed     (n,) uint32; together with `salt` it tells fields apart
    blur     (n,) m, footprint of a pixel: the field fades to 0 as its wavelength drops below two of them
    """
    along_u, along_v = length if isinstance(length, tuple) else (length, length)
    shift = scramble(seed, salt)
    x = u * np.float32(_WAVE / along_u) + (shift & np.uint32(511)).astype(np.float32)
    y = v * np.float32(_WAVE / along_v) + (shift >> np.uint32(16) & np.uint32(511)).astype(np.float32)
    fade = np.exp(blur * blur * np.float32(-4.9 / min(along_u, along_v) ** 2))
    return np.asarray(_sample(x, y) * fade, np.float32)


def fractal(
    u: Array,
    v: Array,
    lengths: tuple[float, ...],
    *,
    seed: Array,
    salt: int,
    blur: Array,
    gain: float = 1.0,
) -> Array:
    """Return the sum (n,) float32 of one `wave` per wavelength, each `gain` times as strong as the last.

    Its standard deviation is 1 where no pixel blurs it.
    """
    total = np.zeros(len(u), np.float32)
    strength = gain ** np.arange(len(lengths))
    strength /= np.sqrt((strength**2).sum())
    for k, length in enumerate(lengths):
        total += np.float32(strength[k]) * wave(u, v, length, seed=seed, salt=salt + 101 * k, blur=blur)
    return total


def stripes(x: Array, share: Array | float, blur: Array) -> Array:
    """Return the share (n,) of the interval x +- blur / 2 that lies in stripes [k, k + share], k integer.

    This is an exact box filter of the stripes.
    """
    width = np.maximum(blur, np.float32(1e-3))
    x = x - np.floor(x)  # the difference of areas is exact for small numbers
    return (_stripe_area(x + 0.5 * width, share) - _stripe_area(x - 0.5 * width, share)) / width


def _stripe_area(x: Array, share: Array | float) -> Array:
    whole = np.floor(x)
    return np.asarray(whole * share + np.minimum(x - whole, share), np.float32)


def _sample(x: Array, y: Array) -> Array:
    """Interpolates the tile bilinearly at texel positions (n,), wrapping around: (n,) float32."""
    n = len(x)
    rows = max(1, -(-n // _ROW))
    at = np.zeros((2, rows * _ROW), np.float32)
    for k, c in enumerate((x, y)):
        at[k, :n] = c - np.floor(c * np.float32(1 / _SIDE)) * np.float32(_SIDE)
    maps = at.reshape(2, rows, _ROW)
    return np.asarray(
        cv2.remap(_tile(), maps[0], maps[1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP).reshape(-1)[:n]
    )
