"""Layers: surfaces parallel to the facade plane, as peaks of the density of signed offsets."""

import numpy as np
from scipy import ndimage, signal

from frontage.facades.cells import CellMap
from frontage.geometry.arrays import Array, Float, Int
from frontage.geometry.ring import convex_ring
from frontage.model.facade import Layer

_LEAST_AREA = 1.0  # m2: a window of frames, a strip of plinth
_LEAST_SHARE = 0.02  # of the wall
_MOST_LAYERS = 8  # plinth, wall, pilasters, frames, panes, balcony fronts, cornice, recess
_BIC_GAIN = 10.0  # "very strong" evidence (Kass and Raftery 1995)
_FINEST = 0.002  # m, least width of a bin


def find_layers(
    y: Float, flat: Int, cells: CellMap, sigma: float, reach: tuple[float, float]
) -> tuple[Layer, ...]:
    """Layers of points at offsets y (n,) m in cells `flat` (n,) of the raster, with y in `reach` (front < 0 <
    back), nearest first.

    Area is counted: every cell counts once per bin of sigma / 2. A peak of the kernel density (bandwidth
    sigma) is a layer when a Gaussian on a locally constant background beats the background alone by a BIC
    gain above 10, it covers a square metre and 2 % of the wall, and no stronger layer is within 3 sigma.
    At most eight, those with the most evidence.
    """
    if len(y) == 0:
        return ()
    width = max(0.5 * sigma, _FINEST)
    bins = int(np.ceil((reach[1] - reach[0]) / width)) + 1
    held = _occupancy(y, flat, cells.whole.size, reach[0], width, bins)
    density = ndimage.gaussian_filter1d(held.sum(1).astype(np.float64), sigma / width, mode="constant")
    background = ndimage.median_filter(density, size=2 * round(10 * sigma / width) + 1, mode="nearest")
    peaks, _ = signal.find_peaks(density, distance=max(1, round(3 * sigma / width)))
    # the wall itself is at y = 0 by construction, whatever the smoothing makes of its neighbours
    here = int(-reach[0] / width)
    half = round(2.5 * sigma / width)
    found = [(np.inf, here)]
    for p in peaks[np.abs(peaks - here) * width > 3.0 * sigma]:
        number = int(np.count_nonzero(held[max(p - half, 0) : p + half + 1].any(0)))
        gain = _gain(number, float(background[p]) * (2 * half + 1), len(y))
        least = max(_LEAST_AREA, _LEAST_SHARE * cells.area)
        if gain > _BIC_GAIN and number * cells.cell**2 >= least:
            found.append((gain, int(p)))
    kept: list[int] = []
    for _, p in sorted(found, key=lambda f: (-f[0], f[1])):
        if len(kept) < _MOST_LAYERS and all(abs(p - other) * width > 3.0 * sigma for other in kept):
            kept.append(p)
    index = np.flatnonzero(np.bincount(flat, minlength=cells.whole.size))
    found_layers = (_layer(p, here, y, held, index, cells, sigma, reach[0], width) for p in sorted(kept))
    return tuple(layer for layer in found_layers if layer is not None)


def _occupancy(y: Float, flat: Int, size: int, low: float, width: float, bins: int) -> Array:
    """(bins, k) bool: whether a cell that holds points, in cell order, holds one in each bin of offsets."""
    number = np.cumsum(np.bincount(flat, minlength=size) > 0) - 1
    level = np.clip(((y - low) * (1.0 / width)).astype(np.int64), 0, bins - 1)
    occupied = int(number[-1]) + 1
    held = np.zeros(bins * occupied, np.bool_)
    level *= occupied
    level += number[flat]
    held[level] = True
    return held.reshape(bins, occupied)


def _gain(number: int, expected: float, points: int) -> float:
    """BIC gain of `number` cells over the `expected` ones of the background (Poisson); -inf when less than
    half more.
    """
    expected = max(expected, 1.0)
    if number < 1.5 * expected:
        return -np.inf
    return float(
        2.0 * (number * np.log(number / expected) - (number - expected)) - 2.0 * np.log(max(points, 2))
    )


def _layer(
    peak: int,
    here: int,
    y: Float,
    held: Array,
    index: Int,
    cells: CellMap,
    sigma: float,
    low: float,
    width: float,
) -> Layer | None:
    """The layer at the bin `peak`; held, index: occupied bins (bins, k) of the cells `index` (k,)."""
    at = 0.0 if peak == here else low + (peak + 0.5) * width
    half = round(2.5 * sigma / width)
    distinct = index[held[max(peak - half, 0) : peak + half + 1].any(0)]
    inside = y[np.abs(y - at) < 2.5 * sigma]
    if len(inside) == 0 or len(distinct) == 0:
        return None
    r, c = np.divmod(distinct, cells.whole.shape[1])
    height = 0.0 if peak == here else float(np.median(inside))
    spread = float(np.std(inside)) / np.sqrt(len(distinct))
    return Layer(height, spread, len(distinct) * cells.cell**2, _ring(r, c, cells))


def _ring(row: Int, column: Int, cells: CellMap) -> Float:
    """Convex ring of cells: a layer (all frames of a front) is rarely one piece."""
    h = cells.wall.shape[0]
    first, last = np.full(h, np.iinfo(np.int64).max), np.full(h, -1)
    np.minimum.at(first, row, column)
    np.maximum.at(last, row, column)
    used = np.flatnonzero(last >= 0)
    ends = np.concatenate(
        [np.column_stack([c, used + up]) for c in (first[used], last[used] + 1) for up in (0, 1)]
    )
    return convex_ring(ends * cells.cell + np.asarray(cells.corner))
