"""Pictures that can be compared: tones of photos, and what the shape of a surface alone looks like."""

from collections.abc import Callable

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float

ImageOf = Callable[[str], Array]
"""The picture (h, w, 3) uint8 RGB of a photo, by the photo's id."""

_GREEN = 1  # the channel nearest to the 532 nm of the paper's scanner, and the one with the least noise
_DARK = 8.0  # code values: noise of dark pixels does not dominate the logarithm
_BLUR_PX = 0.8  # sigma, as smooth as the rendering of the scan
_STEP_M = 0.15  # steps in depth from here on count in full
_SURROUNDINGS_PX = 12.0
_GAP_PX = 10  # an empty place up to this far from a surface is taken for a hole in it


def photo_tone(rgb: Array, factor: float) -> tuple[Array, Float]:
    """Returns the log tone (h, w) float32 of the green channel, `factor` times coarser than the photo.

    Also returns (2,) px of the photo per pixel, across and down.
    """
    height, width = rgb.shape[:2]
    w, h = max(8, round(width / factor)), max(8, round(height / factor))
    green = np.ascontiguousarray(rgb[..., _GREEN])
    reduced = cv2.resize(green, (w, h), interpolation=cv2.INTER_AREA).astype(np.float32)
    blurred = cv2.GaussianBlur(reduced, (0, 0), _BLUR_PX)
    return np.log(blurred + _DARK), np.array([width / w, height / h])


def geometry_tone(depth: Array, known: Bool) -> tuple[Array, Bool]:
    """Returns a picture (h, w) of the shape of a surface, and where it is known.

    Depth (h, w) m is compared with its surroundings: reveals, ledges and corners become edges. Empty places
    beside a surface are drawn as deep, because glass and sky return nothing.
    """
    weight = cv2.GaussianBlur(known.astype(np.float32), (0, 0), _SURROUNDINGS_PX) + 1e-6
    mean = cv2.GaussianBlur(np.where(known, depth, 0.0).astype(np.float32), (0, 0), _SURROUNDINGS_PX) / weight
    relief = np.clip((depth - mean) / _STEP_M, -1.0, 1.0)
    side = 2 * _GAP_PX + 1
    around = cv2.dilate(known.astype(np.uint8), np.ones((side, side), np.uint8)) > 0
    return np.where(known, relief, 1.0).astype(np.float32), around
