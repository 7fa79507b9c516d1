"""Gaps in a drawing of the scan: those that only mean that no beam hit there, and those that mean an edge."""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float
from frontage.orientation.reflectance.render import Rendering

_GAP_PX = 7  # of the drawing: two spacings, which chance leaves open where points do not lie on a raster
_WINDOW_PX = 11  # in which the surface around a gap is judged: such a gap, and two pixels to every side
_FLAT = 3.0  # times as rough as the flat pieces of the scan
_ROWS = 256  # that are judged at once, for the memory that their moments take
_LEAST_DETERMINANT = 1e-6  # px^4: windows whose known pixels lie on a line tell no plane


def without_small_gaps(drawn: Rendering, thickness: float) -> Bool:
    """Returns what of a drawing (h, w) is known or is a small gap in a flat surface.

    thickness  m, how rough the flat pieces of the scan are

    Behind a step in depth, at glass and at the sky, a gap is the end of what was measured, and the photo has
    an edge there. In a flat surface a small gap has no reason but where beams happen to hit.
    """
    known = drawn.known & (drawn.depth > 0)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (_GAP_PX, _GAP_PX))
    closed = cv2.morphologyEx(drawn.known.astype(np.uint8), cv2.MORPH_CLOSE, disc) > 0
    gaps = closed & ~drawn.known
    if not gaps.any():
        return drawn.known
    measured = drawn.known.copy()
    for first in range(0, len(known), _ROWS):
        own = slice(first, first + _ROWS)
        if gaps[own].any():
            start = max(0, first - _WINDOW_PX)
            around = slice(start, first + _ROWS + _WINDOW_PX)
            flat = roughness(drawn.depth[around], known[around]) < _FLAT * thickness
            measured[own] |= gaps[own] & flat[first - start :][:_ROWS]
    return measured


def roughness(depth: Array, known: Bool) -> Float:
    """Returns how far (h, w) m depths around every pixel depart from a plane, as a root mean square.

    depth  (h, w) m along the optical axis, `known` (h, w) where. The inverse depth of a plane is linear in a
    picture, also of one that is seen at a slant. It is 0 where hardly anything is known.
    """
    h, w = known.shape
    inverse = np.where(known, 1.0 / np.where(known, depth, 1.0), 0.0).astype(np.float64)
    middle = float(inverse[known].mean()) if known.any() else 0.0
    row, column = np.mgrid[:h, :w] - np.array([0.5 * h, 0.5 * w])[:, None, None]
    layers = {"x": column, "y": row, "z": inverse - middle}
    weight = known.astype(np.float64)
    count = np.maximum(_total(weight), 1.0)
    mean = {name: _total(weight * layer) / count for name, layer in layers.items()}

    def moment(a: str, b: str) -> Float:
        return np.asarray(_total(weight * layers[a] * layers[b]) / count - mean[a] * mean[b])

    xx, xy, yy = moment("x", "x"), moment("x", "y"), moment("y", "y")
    zx, zy = moment("z", "x"), moment("z", "y")
    explained = zx * zx * yy - 2.0 * zx * zy * xy + zy * zy * xx
    left = moment("z", "z") - explained / np.maximum(xx * yy - xy * xy, _LEAST_DETERMINANT)
    per_inverse = 1.0 / np.maximum(mean["z"] + middle, 1e-6) ** 2  # m per 1/m
    return np.asarray(np.sqrt(np.maximum(left, 0.0)) * per_inverse)


def _total(layer: Float) -> Float:
    """The sum (h, w) over the window around every pixel; outside there is nothing."""
    side = (_WINDOW_PX, _WINDOW_PX)
    return np.asarray(cv2.boxFilter(layer, -1, side, normalize=False, borderType=cv2.BORDER_CONSTANT))
