"""sRGB codes and linear light: averages, gains and blends of pictures are right in linear light only."""

import cv2
import numpy as np

from frontage.geometry.arrays import Array

_CODE = np.arange(256) / 255.0
_LINEAR = np.where(_CODE <= 0.04045, _CODE / 12.92, ((_CODE + 0.055) / 1.055) ** 2.4)
_LIGHT = np.arange(65536) / 65535.0
TO_LINEAR_16 = np.rint(_LINEAR * 65535).astype(np.uint16)
"""Linear light, 65535 = saturated, of the codes 0..255."""
TO_CODE_8 = np.rint(
    255 * np.where(_LIGHT <= 0.0031308, 12.92 * _LIGHT, 1.055 * _LIGHT ** (1 / 2.4) - 0.055)
).astype(np.uint8)
"""Codes of linear light 0..65535."""
_GAMMA = 2.4
_OFFSET = 255 * 0.055  # of codes above the toe, which are 255 * 1.055 light^(1 / 2.4) less this
_TOE = 11  # codes up to this are proportional to the light, or close to that
_WHITE, _BURNT = 245, 254  # codes of all channels, from which on white is taken as saturated, and surely is
_LINEAR_32 = _LINEAR.astype(np.float32)


def linear_light(codes: Array) -> Array:
    """Converts sRGB codes (...) uint8 to linear light (...) float32, 1 = saturated."""
    return np.asarray(np.take(_LINEAR_32, codes))


def brightened(codes: Array, log_gain: Array) -> Array:
    """Multiplies the light of sRGB codes (h, w, 3) uint8 by exp(log_gain) (h, w, 3); returns codes."""
    return scaled(codes, code_scale(log_gain))


def code_scale(log_gain: Array) -> Array:
    """Returns what `scaled` needs (...) float32 for factors exp(log_gain) (...) on the light."""
    return np.asarray(cv2.exp(np.multiply(log_gain, 1.0 / _GAMMA, dtype=np.float32)).reshape(log_gain.shape))


def scaled(codes: Array, scale: Array) -> Array:
    """Multiplies the light of sRGB codes (h, w, 3 or 4) uint8 by scale^2.4; returns codes.

    `scale` (h, w, 3 or 4) float32 is 1 for the fourth channel; it may be changed.
    White that is saturated in all channels was at least as bright as that, and is not darkened: grey shutters
    would stand beside white ones.
    Above its toe, the curve of sRGB is a power of the light with an offset, so that a factor on the light is
    a factor on the code plus that offset. Only the codes in the toe go through linear light.
    """
    _spare_white(codes, scale)
    shifted = cv2.add(codes, (_OFFSET,) * 4, dtype=cv2.CV_32F)
    out = cv2.add(cv2.multiply(shifted, scale, dst=shifted), (-_OFFSET,) * 4, dtype=cv2.CV_8U)
    darker = cv2.min(codes, out)
    if darker.min(initial=255) <= _TOE:
        dark = darker <= _TOE
        light = TO_LINEAR_16[codes[dark]] * scale[dark] ** np.float32(_GAMMA)
        out[dark] = TO_CODE_8[np.minimum(light + 0.5, 65535.0).astype(np.uint16)]
    return np.asarray(out)


def _spare_white(codes: Array, scale: Array) -> None:
    """Takes back, in place, what of a scale (h, w, c) would darken saturated white."""
    if int(cv2.extractChannel(codes, 1).max(initial=0)) <= _WHITE:  # one channel tells of most pictures
        return
    bright = (_WHITE + 1,) * 3 + (0,) * (codes.shape[2] - 3)
    at = cv2.inRange(codes, bright, (255,) * codes.shape[2]).view(np.bool_)
    if at.any():
        white = codes[at][:, :3].min(1)
        kept = np.clip((_BURNT - white.astype(np.float32)) / (_BURNT - _WHITE), 0.0, 1.0)[:, None]
        scale[at] = np.where(scale[at] < 1.0, scale[at] ** kept, scale[at])
