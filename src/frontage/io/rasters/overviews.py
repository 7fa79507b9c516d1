"""Overviews of a raster: the same band at half, a quarter, ... of its size, for fast display."""

from collections.abc import Iterator

import numpy as np

from frontage.geometry.arrays import Array
from frontage.raster.tiles import allocate

_SMALLEST_PX = 256  # no overview of a raster whose longer side is no larger
_ROWS = 128  # rows of the larger level that are worked on at a time


def overviews(band: Array) -> Iterator[Array]:
    """Yield smaller and smaller versions of a band (h, w) or an RGBA image (h, w, 4); sizes are rounded up.

    Colours are averaged with their alpha as weight, floating-point values over those that are not NaN.
    Whole numbers name things, such as photos, so the upper left one of four is taken.
    """
    while max(band.shape[:2]) > _SMALLEST_PX:
        band = _halved(band)
        yield band


def _halved(band: Array) -> Array:
    h, w = ((n + 1) // 2 for n in band.shape[:2])
    if not any(band.strides):  # one value for all pixels
        return np.broadcast_to(band[:1, :1], (h, w))
    small = allocate((h, w, *band.shape[2:]), band.dtype)
    reduce = _mean_colour if band.ndim == 3 else _mean if band.dtype.kind == "f" else _first
    for r in range(0, band.shape[0], _ROWS):
        part = reduce(np.asarray(band[r : r + _ROWS]))
        small[r // 2 : r // 2 + len(part)] = part
    return small


def _first(part: Array) -> Array:
    return part[::2, ::2]


def _mean(part: Array) -> Array:
    known = np.isfinite(part)
    total = _sums(np.where(known, part, 0.0).astype(np.float64))
    count = _sums(known.astype(np.float64))
    mean = np.full(total.shape, np.nan)
    np.divide(total, count, out=mean, where=count > 0)
    return mean.astype(part.dtype)


def _mean_colour(part: Array) -> Array:
    weight = part[..., 3:].astype(np.float64)
    total, alpha = _sums(part[..., :3] * weight), _sums(weight)
    colour = np.zeros(total.shape)
    np.divide(total, alpha, out=colour, where=alpha > 0)
    shown = alpha / np.maximum(_sums(np.ones(weight.shape)), 1.0)
    made: Array = np.rint(np.concatenate([colour, shown], axis=-1)).astype(part.dtype)
    return made


def _sums(part: Array) -> Array:
    """Sums of 2 x 2 pixels; at an odd edge of the two that there are."""
    h, w = part.shape[:2]
    pad = [(0, h % 2), (0, w % 2), *[(0, 0)] * (part.ndim - 2)]
    even = np.pad(part, pad)
    total: Array = even[::2, ::2] + even[1::2, ::2] + even[::2, 1::2] + even[1::2, 1::2]
    return total
