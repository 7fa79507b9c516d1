"""Oriented gradients that do not know dark from light, so that photo and laser can be compared.

A gradient (gx, gy) of length g becomes ``((gx^2 - gy^2) / g, 2 gx gy / g, g - mean g)``: its direction with
the angle doubled, as in the structure tensor, and its excess over the surroundings. Paint that is dark in the
photo and bright to the laser has the same channels in both. The channels are divided by the local root mean
square, so that weak texture on plaster counts as much as the borders of windows.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool

_NORMALISE_PX = 10.0  # sigma of the surroundings that gradients are compared with
_SMALLEST = 1e-6
_WEAKEST = 0.1  # of the picture's typical gradient: what is weaker is noise


@dataclass(frozen=True, eq=False)
class Channels:
    """Oriented gradients (3, h, w) float32, zero where unknown, and where they are known (h, w)."""

    values: Array
    known: Bool

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in pixels."""
        return self.known.shape[0], self.known.shape[1]


def oriented_gradients(tone: Array, known: Bool | None = None) -> Channels:
    """Returns the channels of a picture (h, w) of log tones, known everywhere unless `known` (h, w) says."""
    inside = np.ones(tone.shape, np.bool_) if known is None else known
    picture = np.where(inside, tone, 0.0).astype(np.float32)
    gx = cv2.Scharr(picture, cv2.CV_32F, 1, 0) / 32.0
    gy = cv2.Scharr(picture, cv2.CV_32F, 0, 1) / 32.0
    inner = cv2.erode(inside.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=0) > 0
    length = np.hypot(gx, gy) * inner
    weight = _blurred(inner.astype(np.float32)) + _SMALLEST
    typical = np.sqrt(_blurred(length * length) / weight)
    floor = _WEAKEST * float(np.median(typical[inner])) if inner.any() else 1.0
    unit = 1.0 / (typical + floor + _SMALLEST)
    safe = np.maximum(length, _SMALLEST)
    relative = length * unit
    excess = (relative - _blurred(relative) / weight) * inner
    values = np.stack([(gx * gx - gy * gy) / safe * unit * inner, 2 * gx * gy / safe * unit * inner, excess])
    return Channels(values.astype(np.float32), inner)


def _blurred(picture: Array) -> Array:
    blurred: Array = cv2.GaussianBlur(picture, (0, 0), _NORMALISE_PX)
    return blurred


def mean_channels(*parts: Channels) -> Channels:
    """Returns the mean of channels that see the same surface, where any of them is known."""
    count = sum(part.known.astype(np.float32) for part in parts)
    total = sum(part.values for part in parts)
    known = np.asarray(count) > 0
    return Channels(np.asarray(total / np.maximum(np.asarray(count), 1.0), np.float32), known)


def padded(channels: Channels, margin: int) -> Channels:
    """Returns the channels with a margin of unknown pixels on every side."""
    values = np.pad(channels.values, ((0, 0), (margin, margin), (margin, margin)))
    return Channels(values, np.pad(channels.known, margin))
