"""Key points of one photo: SIFT (Lowe 2004) with RootSIFT descriptors (Arandjelovic and Zisserman 2012).

OpenCV's SIFT is used. pycolmap's needs 12.6 s for a picture of 3200 x 2400 px where OpenCV's needs 2.3 s.
"""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float, Int
from frontage.orientation.nouns import KeyPoints
from frontage.orientation.ties.options import TieOptions
from frontage.orientation.ties.sift import detect

_CELLS = 16  # grid cells along the longer side
_CROWDED = 3.0  # times the mean of all cells, the most that a cell may hold before others are served
_REBLUR_PX = 1.5  # sigma of the blur against which edges are compared
_WEAKEST = 10.0  # response of Sobel's filter that noise does not reach
_EDGES = 0.97  # quantile of the gradients above which a pixel belongs to an edge


def key_points(image: Array, options: TieOptions | None = None) -> KeyPoints:
    """Finds the key points of a picture (h, w, 3) uint8 RGB, or (h, w) uint8 grey.

    The picture is reduced to `options.side`. Of several key points at one place the first is kept, and of too
    many those of the highest contrast, but no grid cell takes more than its share. Pixels refer to the full
    picture, first pixel centre at 0.5.
    """
    options = options or TieOptions()
    grey = image if image.ndim == 2 else cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_RGB2GRAY)
    small = _reduced(grey, options.side)
    found = detect(small)
    kept = _selected(found.table, small.shape, options.most)
    stretch = np.array([grey.shape[1] / small.shape[1], grey.shape[0] / small.shape[0]])
    return KeyPoints(
        pixels=(found.table[kept, :2] + 0.5) * stretch,
        scale=found.table[kept, 2] * stretch.mean(),
        descriptors=_root(found.describe(kept)),
        sharpness=edge_width(grey),
    )


def edge_width(grey: Array) -> float:
    """Returns the width (one sigma, px) of the finest edges of a picture (h, w) uint8; NaN without edges.

    An edge of width s whose gradient falls by the ratio r when it is blurred by b has s = b / sqrt(r^2 - 1)
    (Zhuo and Sim 2011). Edges across and along are measured apart and the wider counts, because a moved
    camera blurs only one of them.
    """
    step = max(1, round(np.sqrt(grey.size / 4e6)))  # strips of full resolution, of four megapixels in all
    rows = max(64, grey.shape[0] // 16)
    strips = [grey[k : k + rows] for k in range(0, grey.shape[0], rows)][::step]
    widths = [w for w in (_strip_widths(s.astype(np.float32)) for s in strips) if np.isfinite(w).all()]
    return float(np.median(np.array(widths), axis=0).max()) if widths else float("nan")


def _strip_widths(grey: Array) -> Float:
    """Width (2,) px of the finest tenth of the edges across and along; NaN where there are none."""
    soft = cv2.GaussianBlur(cv2.GaussianBlur(grey, (0, 0), 0.7), (0, 0), _REBLUR_PX)
    fine = cv2.GaussianBlur(grey, (0, 0), 0.7)  # against noise; taken off below
    result = []
    for dx, dy in ((1, 0), (0, 1)):
        sharp = np.abs(cv2.Sobel(fine, cv2.CV_32F, dx, dy))
        other = np.abs(cv2.Sobel(soft, cv2.CV_32F, dx, dy))
        edge = sharp > max(float(np.quantile(sharp[::4, ::4], _EDGES)), _WEAKEST)
        ratio = sharp[edge] / np.maximum(other[edge], 1e-3)
        ratio = ratio[ratio > 1.002]
        if len(ratio) < 50:
            result.append(np.nan)
            continue
        width = _REBLUR_PX / np.sqrt(float(np.quantile(ratio, 0.9)) ** 2 - 1)
        result.append(np.sqrt(max(width**2 - 0.49, 0.01)))
    return np.array(result)


def _reduced(grey: Array, side: int) -> Array:
    """The picture with a longer side of at most `side` px."""
    h, w = grey.shape
    s = side / max(h, w)
    if s >= 1.0:
        return np.ascontiguousarray(grey)
    size = (max(1, round(w * s)), max(1, round(h * s)))
    small: Array = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
    return small


def _selected(table: Float, shape: tuple[int, ...], most: int) -> Int:
    """Rows of distinct places, spread over the picture, by falling scale; columns x, y, size, response."""
    if not len(table):
        return np.empty(0, np.int64)
    _, rows = np.unique(np.round(table[:, :2] * 8).astype(np.int64), axis=0, return_index=True)
    edge = max(shape) / _CELLS
    cell = (table[rows, 1] // edge).astype(np.int64) * (_CELLS + 1) + (table[rows, 0] // edge).astype(
        np.int64
    )
    order = np.lexsort([rows, -table[rows, 3], cell])
    starts = np.flatnonzero(np.diff(cell[order], prepend=-1))
    rank = np.arange(len(order)) - np.repeat(starts, np.diff(np.append(starts, len(order))))
    crowded = rank >= _CROWDED * most / len(starts)
    by_use = np.lexsort([rows[order], -table[rows[order], 3], crowded])
    kept = rows[order[by_use[:most]]]
    return kept[np.lexsort([kept, -table[kept, 2]])].astype(np.int64)


def _root(raw: Array) -> Array:
    """RootSIFT descriptors (n, 128) uint8 of raw ones: the roots of the shares, times 512."""
    share = raw / np.maximum(raw.sum(1, keepdims=True), 1e-6)
    descriptors: Array = np.minimum(np.round(512 * np.sqrt(share)), 255).astype(np.uint8)
    return descriptors
