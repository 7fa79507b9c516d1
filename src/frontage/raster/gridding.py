"""Turns scattered points into grids: quantiles by cell, closing of gaps, distances."""

from collections.abc import Callable
from functools import lru_cache

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.raster.tiles import tiles

_MARKED_CELLS = 1 << 26  # as many are marked in memory; more are sorted
_BAND_ROWS = 64
_CROSS, _SQUARE = (cv2.getStructuringElement(kind, (3, 3)) for kind in (cv2.MORPH_CROSS, cv2.MORPH_RECT))
OCTAGON = (_CROSS, _CROSS, _SQUARE, _CROSS, _SQUARE)
"""By what to grow in turn, a pixel at a time; two squares in five steps make the rounder octagon."""
_BLOCK_PX = 256  # over which the radii of discs hardly change
_SAMPLE_PX = 16  # between the radii of which the mean of a block is taken
_LARGEST_DISC_PX = 8.0  # the time of a disc grows with its area, that of distances does not


def cell_index(column_row: Array, shape: tuple[int, int]) -> tuple[Int, Bool]:
    """Returns the flat cell numbers (k,) of the positions (n, 2) (column, row) inside, and which (n,) are."""
    h, w = shape
    c, r = column_row.T
    inside = (c >= 0) & (c < w) & (r >= 0) & (r < h)
    if not inside.all():
        chosen = np.flatnonzero(inside)
        c, r = np.take(c, chosen), np.take(r, chosen)
    cell = r.astype(np.int64)
    cell *= w
    cell += c.astype(np.int64)
    return cell, inside


def by_rows(row: Float) -> tuple[Int, Array]:
    """Returns the order (n,) of positions by bands of rows, and their bands (n,) in that order."""
    band = np.floor(row / _BAND_ROWS).astype(np.int16)  # numbers of two bytes are sorted in linear time
    order = np.argsort(band, kind="stable")
    return order, band[order]


def of_rows(band: Array, first: int, last: int) -> slice:
    """Returns which of the positions, ordered as by `by_rows`, may lie in the rows `first` to `last`."""
    return slice(
        int(np.searchsorted(band, band.dtype.type(first // _BAND_ROWS), "left")),
        int(np.searchsorted(band, band.dtype.type(last // _BAND_ROWS), "right")),
    )


def distinct_cells(cell: Int, size: int) -> Int:
    """Returns the sorted different numbers among flat cell numbers (n,) below `size`."""
    if size <= _MARKED_CELLS:
        marked = np.zeros(size, bool)
        marked[cell] = True
        return np.flatnonzero(marked)
    ordered = np.sort(cell)
    return np.asarray(ordered[np.r_[True, ordered[1:] != ordered[:-1]]] if len(ordered) else ordered)


def cell_quantiles(
    cell: Int, value: Float, shape: tuple[int, int], quantiles: tuple[float, ...]
) -> tuple[Array, Array]:
    """Quantiles (q, h, w) (NaN = empty) of values (n,) by flat cell number (n,), and counts (h, w)."""
    cell, value = _in_order(cell, value)
    count = np.bincount(cell, minlength=shape[0] * shape[1])
    used = np.flatnonzero(count)
    last = count[used]
    first = np.cumsum(last) - last
    last -= 1
    out = np.full((len(quantiles), shape[0] * shape[1]), np.nan)
    for i, q in enumerate(quantiles):
        at = q * last
        low = at.astype(np.int64)
        share = at - low
        low += first
        high = low + (share > 0.0)
        out[i, used] = np.take(value, low) * (1 - share) + np.take(value, high) * share
    return out.reshape(len(quantiles), *shape), count.reshape(shape)


def _in_order(cell: Int, value: Float) -> tuple[Int, Float]:
    """Sorts values (n,) of flat cells (n,) by cell and value.

    Cell number and value are sorted as one number, which takes a fifth of the time of sorting by two keys;
    the values are good to a billionth of their range.
    """
    low, high = (float(value.min()), float(value.max())) if len(value) else (0.0, 0.0)
    span = 1.001 * (high - low) or 1.0
    both = np.sort(cell + (value - low) / span)
    cell = both.astype(np.int64)
    return cell, low + (both - cell) * span


def closed(occupied: Bool, radius: Array) -> Bool:
    """Closes a mask by discs of `radius` (h, w) px: fills gaps up to 2 r wide and does not grow edges.

    Small radii are taken to vary slowly: a block of pixels is closed by the disc of its mean radius.
    """
    return _by_blocks(occupied, radius, _closed_by_disc, _closed_by_distance)


def grown(occupied: Bool, radius: Array) -> Bool:
    """Grows a mask by discs of `radius` (h, w) px; small radii are taken to vary slowly, as in `closed`."""
    return _by_blocks(occupied, radius, _grown_by_disc, lambda mask, r: distance_to(mask) <= r)


def _by_blocks(
    occupied: Bool,
    radius: Array,
    by_disc: Callable[[Bool, float], Bool],
    by_distance: Callable[[Bool, Array], Bool],
) -> Bool:
    """Applies an operation with small discs block by block, and one with distances where discs are large."""
    if float(radius.max(initial=0.0)) > _LARGEST_DISC_PX:
        return by_distance(occupied, radius)
    out = np.empty_like(occupied)
    for tile in tiles(occupied.shape[0], occupied.shape[1], _BLOCK_PX):
        r = float(radius[tile.window][::_SAMPLE_PX, ::_SAMPLE_PX].mean())
        reach = 2 * int(np.ceil(r)) + 2
        r0, c0 = max(tile.r0 - reach, 0), max(tile.c0 - reach, 0)
        whole = by_disc(occupied[r0 : tile.r1 + reach, c0 : tile.c1 + reach], r)
        out[tile.window] = whole[tile.r0 - r0 :, tile.c0 - c0 :][: tile.shape[0], : tile.shape[1]]
    return out


def _closed_by_disc(occupied: Bool, radius: float) -> Bool:
    disc = _disc(radius)
    reach = len(disc) // 2
    padded = cv2.copyMakeBorder(occupied.view(np.uint8), reach, reach, reach, reach, cv2.BORDER_CONSTANT)
    whole: Array = cv2.morphologyEx(padded, cv2.MORPH_CLOSE, disc)
    return whole[reach:, reach:][: len(occupied), : occupied.shape[1]].view(np.bool_)


def _grown_by_disc(occupied: Bool, radius: float) -> Bool:
    return np.asarray(cv2.dilate(occupied.view(np.uint8), _disc(radius)).view(np.bool_))


@lru_cache(maxsize=256)
def _disc(radius: float) -> Array:
    """The pixels (2 r + 1, 2 r + 1) uint8 within a radius px of the middle one."""
    reach = int(radius)
    square = np.arange(-reach, reach + 1) ** 2
    return (square[:, None] + square <= radius * radius).astype(np.uint8)


def _closed_by_distance(occupied: Bool, radius: Array) -> Bool:
    reach = int(np.ceil(radius.max())) + 2
    padded = np.pad(occupied, reach)
    r = np.pad(radius.astype(np.float32), reach, mode="edge")
    wide = distance_to(padded) <= r
    back = distance_to(~wide) > r
    return (back | padded)[reach:-reach, reach:-reach]


def distance_within(mask: Bool, most: float) -> Array:
    """Distance (h, w) uint8 px of every pixel to the nearest True one, no larger than `most` rounded up.

    Pixels grow by crosses and squares in turn: octagons, which are discs to 8 %. Up to twenty steps or so,
    this takes a fraction of the time of `distance_to`.
    """
    away: Array = (~mask).view(np.uint8)
    distance = away.copy()
    for step in range(min(int(np.ceil(most)), 255) - 1):
        away = cv2.erode(away, OCTAGON[step % len(OCTAGON)])
        cv2.add(distance, away, dst=distance)
    return distance


def distance_to(mask: Bool) -> Array:
    """Distance (h, w) float32 px of every pixel to the nearest True one; 1e9 when there is none.

    It is good to two per cent (Borgefors, Distance transformations in digital images, CVGIP 1986).
    """
    if not mask.any():
        return np.full(mask.shape, 1e9, np.float32)
    d: Array = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
    return d


def nearest_filled(grid: Array) -> Array:
    """Replaces every NaN by the value of the nearest known cell; a grid (h, w) of NaN stays as it is."""
    known = np.isfinite(grid)
    if known.all() or not known.any():
        return grid
    _, labels = cv2.distanceTransformWithLabels(
        (~known).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    flat, at = labels.ravel(), np.flatnonzero(known)
    value_of_label = np.empty(len(at) + 1, grid.dtype)
    value_of_label[flat[at]] = grid.ravel()[at]
    return np.asarray(np.take(value_of_label, labels))
