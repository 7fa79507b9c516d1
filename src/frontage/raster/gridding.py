"""Turns scattered points into grids: quantiles by cell, interpolation between cells, closing of gaps."""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int

_MARKED_CELLS = 1 << 26  # as many are marked in memory; more are sorted


def cell_index(column_row: Float, shape: tuple[int, int]) -> tuple[Int, Bool]:
    """Returns the flat cell numbers (k,) of the positions (n, 2) (column, row) inside, and which (n,) are."""
    h, w = shape
    inside = (
        (column_row[:, 0] >= 0) & (column_row[:, 0] < w) & (column_row[:, 1] >= 0) & (column_row[:, 1] < h)
    )
    c, r = column_row[inside].astype(np.int64).T
    return r * w + c, inside


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
    start = np.cumsum(count) - count
    used = np.flatnonzero(count)
    out = np.full((len(quantiles), shape[0] * shape[1]), np.nan)
    for i, q in enumerate(quantiles):
        at = q * (count[used] - 1)
        low, high = np.floor(at).astype(np.int64), np.ceil(at).astype(np.int64)
        share = at - low
        out[i, used] = value[start[used] + low] * (1 - share) + value[start[used] + high] * share
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

    Returns (m, n) or (m, n, k) float32; the edges extend outwards.
    """
    h, w = grid.shape[:2]
    u, v = np.clip(u, 0, w - 1), np.clip(v, 0, h - 1)
    c, r = np.minimum(u.astype(int), max(w - 2, 0)), np.minimum(v.astype(int), max(h - 2, 0))
    c1, r1 = np.minimum(c + 1, w - 1), np.minimum(r + 1, h - 1)
    s, t = (u - c).astype(np.float32), (v - r).astype(np.float32)
    s, t = (a.reshape(-1, *(1,) * (grid.ndim - 2)) for a in (s, t))
    low = np.take(grid, r, axis=0).astype(np.float32)
    rows = low + (np.take(grid, r1, axis=0) - low) * t[:, None]
    left = np.take(rows, c, axis=1)
    mixed: Array = np.take(rows, c1, axis=1)
    mixed -= left
    mixed *= s
    mixed += left
    return mixed


def nearest(grid: Array, u: Array, v: Array) -> Array:
    """Returns the values (m, n) of the cells of a grid (h, w) nearest to columns u (n,) and rows v (m,)."""
    h, w = grid.shape
    c = np.clip(np.rint(u), 0, w - 1).astype(int)
    return np.asarray(grid[np.clip(np.rint(v), 0, h - 1).astype(int)][:, c])


def closed(occupied: Bool, radius: Array) -> Bool:
    """Closes a mask by discs of `radius` (h, w) px: fills gaps up to 2 r wide and does not grow edges."""
    reach = int(np.ceil(radius.max())) + 2
    pad = np.pad(occupied, reach)
    r = np.pad(radius.astype(np.float32), reach, mode="edge")
    grown = distance_to(pad) <= r
    back = distance_to(~grown) > r
    return (back | pad)[reach:-reach, reach:-reach]


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
