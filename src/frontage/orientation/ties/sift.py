"""SIFT in tiles: the key points of the whole picture in less than half of the memory.

SIFT doubles a picture and keeps some fifteen blurred copies of it as floating-point numbers: 2 GB for 7
megapixels. Here small key points are looked for in tiles with a margin that their surroundings do not reach
across, so that they are those of the whole picture. Key points that are larger than the margin allows are
looked for in the whole picture, reduced to half its size, in which their octaves are the same.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float, Int

_CONTRAST = 0.02  # COLMAP's threshold: 0.02 / 3 per layer
_TILE_PX = 1600  # longest side of a tile without its margin
_MARGIN_PX = 192  # a multiple of the steps of all octaves that a tile is asked for
_REACH = 6.0  # from a key point, in its size, over which its descriptor looks
_LARGE_PX = _MARGIN_PX / _REACH
_HALF = 2


@dataclass(frozen=True, eq=False)
class _Part:
    """A part of the picture, reduced `step` times; `corner` (x, y) is its first pixel; its key points."""

    picture: Array
    corner: tuple[int, int]
    step: int
    found: Sequence[cv2.KeyPoint]


@dataclass(frozen=True, eq=False)
class Detected:
    """Key points of a picture before their descriptors.

    table  (n, 4) x and y in px, first pixel centre at 0; size in px; response
    """

    table: Float
    parts: tuple[_Part, ...]

    def describe(self, rows: Int) -> Array:
        """Returns the descriptors (n, 128) float32 of the key points at `rows`."""
        result = np.zeros((len(rows), 128), np.float32)
        start = 0
        for part in self.parts:
            mine = np.flatnonzero((rows >= start) & (rows < start + len(part.found)))
            if len(mine):
                chosen = [part.found[k - start] for k in rows[mine]]
                result[mine] = _sift().compute(part.picture, chosen)[1]
            start += len(part.found)
        return result


def detect(grey: Array) -> Detected:
    """Finds the key points of a picture (h, w) uint8."""
    parts = [_detected(grey, tile) for tile in _tiles(grey.shape)]
    if len(parts) > 1:
        parts.append(_large(grey))
    rows = [
        (
            (k.pt[0] + 0.5) * part.step - 0.5 + part.corner[0],
            (k.pt[1] + 0.5) * part.step - 0.5 + part.corner[1],
            k.size * part.step,
            k.response,
        )
        for part in parts
        for k in part.found
    ]
    return Detected(np.array(rows, np.float64).reshape(-1, 4), tuple(parts))


def _sift() -> cv2.SIFT:
    # The precise mode removes a shift of a quarter pixel that the doubled first octave brings otherwise.
    return cv2.SIFT.create(contrastThreshold=_CONTRAST, enable_precise_upscale=True)


def _tiles(shape: tuple[int, ...]) -> list[tuple[int, int, int, int]]:
    """Tiles x0, y0, x1, y1 that cover a picture; corners are multiples of the margin."""
    cuts = []
    for side in shape[:2]:
        count = -(-side // _TILE_PX)
        inner = [round(side * k / count / _MARGIN_PX) * _MARGIN_PX for k in range(1, count)]
        cuts.append([0, *inner, side])
    rows, columns = cuts
    return [(x0, y0, x1, y1) for y0, y1 in pairwise(rows) for x0, x1 in pairwise(columns)]


def _detected(grey: Array, tile: tuple[int, int, int, int]) -> _Part:
    """The key points of a tile; small ones where other tiles have the rest."""
    x0, y0, x1, y1 = tile
    h, w = grey.shape
    left, top = max(0, x0 - _MARGIN_PX), max(0, y0 - _MARGIN_PX)
    picture = np.ascontiguousarray(grey[top : y1 + _MARGIN_PX, left : x1 + _MARGIN_PX])
    found = _sift().detect(picture, None)
    if (x0, y0, x1, y1) == (0, 0, w, h):
        return _Part(picture, (0, 0), 1, found)
    kept = [
        k
        for k in found
        if k.size < _LARGE_PX and x0 <= k.pt[0] + left + 0.5 < x1 and y0 <= k.pt[1] + top + 0.5 < y1
    ]
    return _Part(picture, (left, top), 1, kept)


def _large(grey: Array) -> _Part:
    """The large key points of a picture, from half its size."""
    size = (grey.shape[1] // _HALF, grey.shape[0] // _HALF)
    even = grey[: size[1] * _HALF, : size[0] * _HALF]
    half = cv2.resize(even, size, interpolation=cv2.INTER_AREA)
    found = [k for k in _sift().detect(half, None) if k.size * _HALF >= _LARGE_PX]
    return _Part(half, (0, 0), _HALF, found)
