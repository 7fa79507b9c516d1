"""What the frame looks like: bars have its colour, panes have not.

The colours of the frame, between the outline and the panes, and those of everything inside are collected
for every view, because light and exposure differ. Brightness counts less than hue, since frames lie partly
in the shadow of the reveal, bars in the sun, and their undersides in the dark. Where a curtain has the
colour of the frame, both are as probable, and nothing is concluded.
"""

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter

from frontage.crossbars.rectify import grey_of
from frontage.geometry.arrays import Array

_BINS = (28, 14, 14)  # of brightness and two ratios of colours
_LOWEST_LEVEL = 6.0  # of 255: below, colours are noise
_RATIO = 0.7  # largest logarithm of a ratio of colours
_BLUR = (1.6, 0.9, 0.9)  # bins: noise, compression, shading
_LIT = (7.0, 0.9, 0.9)  # bins: the same paint in the sun and in the shadow
_LIT_SHARE = 0.35  # of the pixels of frames and bars that are lit unlike the rest of the frame
_BARS = 0.15  # share of bars in what the colours inside a frame are collected from
_LEFT = 0.4  # least share of any colour that is that of panes
_BOUND = 2.0  # nats that the colour of one pixel can say
_FEW = 40  # pixels of a frame that tell its colour
_UNSEEN = 0.05  # share of colours that neither sample holds


def frame_likeness(image: Array, inside: Array, frame: Array, panes: Array) -> Array:
    """Returns how much every pixel looks like the frame, (h, w) float32 nats, 0 where this is not known.

    image   (h, w, 3) float32, a view on the plane of the frame
    inside  (h, w) bool, where it shows the window
    frame   (h, w) bool, between the outline and the panes
    panes   (h, w) bool, inside the frame
    """
    bins = _binned(image)
    own, other = bins[frame & inside], bins[panes & inside]
    if len(own) < _FEW or len(other) < _FEW:
        return np.zeros(image.shape[:2], np.float32)
    frames = (1 - _LIT_SHARE) * _density(own, _BLUR) + _LIT_SHARE * _density(own, _LIT)
    inner = _density(other, _BLUR)
    ratio = np.log(frames / np.maximum(inner - _BARS * frames, _LEFT * inner))
    return np.asarray(np.clip(ratio, -_BOUND, _BOUND)[bins] * inside, np.float32)


def _binned(image: Array) -> Array:
    """Returns the number of the bin (h, w) of every colour."""
    level = np.log(np.maximum(image, _LOWEST_LEVEL))
    low, high = np.log(_LOWEST_LEVEL), np.log(255.0)
    parts = (
        (grey_of(level) - low) / (high - low),
        0.5 + (level[..., 0] - level[..., 1]) / (2 * _RATIO),
        0.5 + (level[..., 2] - level[..., 1]) / (2 * _RATIO),
    )
    index = [np.clip(p * n, 0, n - 1).astype(np.int32) for p, n in zip(parts, _BINS, strict=True)]
    return np.asarray((index[0] * _BINS[1] + index[1]) * _BINS[2] + index[2])


def _density(bins: Array, blur: tuple[float, float, float]) -> Array:
    """Returns the probability of every bin, of a sample of colours; none is impossible."""
    count = np.bincount(bins, minlength=int(np.prod(_BINS))).astype(np.float64)
    smooth = gaussian_filter(count.reshape(_BINS), blur, mode="nearest").ravel() / len(bins)
    return np.asarray((1 - _UNSEEN) * smooth + _UNSEEN / len(count))


def eroded(mask: Array) -> Array:
    """Returns a mask (h, w) bool without the pixels on its border, which are mixed."""
    return np.asarray(cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=0) > 0)
