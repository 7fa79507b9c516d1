"""Turns scattered points into grids: quantiles by cell, interpolation between cells, closing of gaps."""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.raster.tiles import tiles

_MARKED_CELLS = 1 << 26  # as many are marked in memory; more are sorted
_SAME_PLACE = 1e-6  # pixels
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


def bilinear(grid: Array, u: Array, v: Array) -> Array:
    """Interpolates a grid (h, w) or (h, w, k) bilinearly at columns u (n,) and rows v (m,).

    Returns (m, n) or (m, n, k) float32; the edges extend outwards. Where the positions divide every cell into
    the same whole number of pixels, the grid is enlarged by it, which takes a twentieth of the time.
    """
    across, down = _divided(u, grid.shape[1]), _divided(v, grid.shape[0])
    if across is None or down is None:
        return _anywhere(grid, u, v)
    if (
        across.pixels == down.pixels == 1
        and across.within(u, grid.shape[1])
        and down.within(v, grid.shape[0])
    ):
        row, column = down.first + down.skipped, across.first + across.skipped
        return np.array(grid[row : row + len(v), column : column + len(u)], np.float32)
    part = _with_edges(grid, down, across).astype(np.float32, copy=False)
    if across.pixels > 1 or down.pixels > 1:
        size = (part.shape[1] * across.pixels, part.shape[0] * down.pixels)
        part = cv2.resize(part, size, interpolation=cv2.INTER_LINEAR)
    return np.ascontiguousarray(part[down.skipped :, across.skipped :][: len(v), : len(u)])


def _with_edges(grid: Array, down: "_Divided", across: "_Divided") -> Array:
    """Returns the part (m, n) or (m, n, k) of a grid; beyond the grid, its edges repeat."""
    h, w = grid.shape[:2]
    rows, columns = (slice(max(d.first, 0), d.last) for d in (down, across))
    part = grid[rows, columns]
    above, below, left, right = (
        max(n, 0) for n in (-down.first, down.last - h, -across.first, across.last - w)
    )
    if above or below or left or right:
        return np.asarray(cv2.copyMakeBorder(part, above, below, left, right, cv2.BORDER_REPLICATE))
    return part


class _Divided(NamedTuple):
    """Cells `first` to `last` (excluded), divided into `pixels` each; the first `skipped` are left out."""

    pixels: int
    first: int
    last: int
    skipped: int

    def within(self, at: Array, size: int) -> bool:
        """Whether cells of one pixel, at which these (n,) lie, are all among the `size` cells of a grid."""
        first = self.first + self.skipped
        return first >= 0 and first + len(at) <= size


def _divided(at: Array, size: int) -> _Divided | None:
    """The division of `size` cells into pixels of which these (n,) are the positions.

    None if they are not even, or all of them beyond the cells.
    """
    if len(at) < 2 or at[-1] <= at[0]:
        return None
    count = round(float((len(at) - 1) / (at[-1] - at[0])))
    pixel = (float(at[0]) + 0.5) * count - 0.5  # number of the first one, counted from the edge of cell 0
    drift = (at[-1] - at[0]) * count - (len(at) - 1)
    if count < 1 or abs(drift) > _SAME_PLACE or abs(pixel - round(pixel)) > _SAME_PLACE:
        return None
    number = round(pixel)
    first, last = number // count - 1, (number + len(at) - 1) // count + 2
    return _Divided(count, first, last, number - first * count) if first < size and last > 0 else None


def _anywhere(grid: Array, u: Array, v: Array) -> Array:
    """Interpolates a grid bilinearly at any columns u (n,) and rows v (m,)."""
    h, w = grid.shape[:2]
    u, v = np.clip(u, 0, w - 1), np.clip(v, 0, h - 1)
    c, r = np.minimum(u.astype(int), max(w - 2, 0)), np.minimum(v.astype(int), max(h - 2, 0))
    c1, r1 = np.minimum(c + 1, w - 1), np.minimum(r + 1, h - 1)
    s, t = (a.astype(np.float32).reshape(-1, *(1,) * (grid.ndim - 1)) for a in (u - c, v - r))
    if len(v) < h:  # only the rows in question are looked at
        low, high = (_mixed(np.take(grid, number, axis=0), c, c1, s[..., 0]) for number in (r, r1))
    else:
        lines = np.ascontiguousarray(np.swapaxes(grid, 0, 1), np.float32)  # whole lines are copied fastest
        left = lines[c]
        columns = np.ascontiguousarray(np.swapaxes(left + (lines[c1] - left) * s, 0, 1))
        low, high = columns[r], columns[r1]
    high -= low
    high *= t
    high += low
    return high


def _mixed(rows: Array, left: Int, right: Int, share: Array) -> Array:
    """The columns `left` (n,) of rows (m, w, ...), with a `share` (n, ...) of the columns `right` (n,)."""
    rows = rows.astype(np.float32, copy=False)
    first, mixed = np.take(rows, left, axis=1), np.take(rows, right, axis=1)
    mixed -= first
    mixed *= share
    mixed += first
    return mixed


def nearest(grid: Array, u: Array, v: Array) -> Array:
    """Returns the values (m, n) of the cells of a grid (h, w) nearest to columns u (n,) and rows v (m,)."""
    h, w = grid.shape
    across, down = _divided(u, w), _divided(v, h)
    if across is not None and down is not None:
        part = _with_edges(grid, down, across)
        size = (part.shape[1] * across.pixels, part.shape[0] * down.pixels)
        part = np.asarray(cv2.resize(part, size, interpolation=cv2.INTER_NEAREST))
        return part[down.skipped :, across.skipped :][: len(v), : len(u)]
    c = np.clip(np.rint(u), 0, w - 1).astype(int)
    return np.take(grid[np.clip(np.rint(v), 0, h - 1).astype(int)], c, axis=1)


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
    value_of_label = np.empty(labels.max() + 1, grid.dtype)
    value_of_label[labels[known]] = grid[known]
    filled: Array = value_of_label[labels]
    return filled
