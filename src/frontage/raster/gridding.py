"""Turns scattered points into grids: quantiles by cell, interpolation between cells, closing of gaps."""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int


def cell_index(column_row: Float, shape: tuple[int, int]) -> tuple[Int, Bool]:
    """Returns the flat cell numbers (k,) of the positions (n, 2) (column, row) inside, and which (n,) are."""
    h, w = shape
    inside = (
        (column_row[:, 0] >= 0) & (column_row[:, 0] < w) & (column_row[:, 1] >= 0) & (column_row[:, 1] < h)
    )
    c, r = column_row[inside].astype(np.int64).T
    return r * w + c, inside


def cell_quantiles(
    cell: Int, value: Float, shape: tuple[int, int], quantiles: tuple[float, ...]
) -> tuple[Array, Array]:
    """Quantiles (q, h, w) (NaN = empty) of values (n,) by flat cell number (n,), and counts (h, w)."""
    order = np.lexsort((value, cell))
    cell, value = cell[order], value[order]
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


def bilinear(grid: Array, u: Array, v: Array) -> Array:
    """Interpolates a grid (h, w) bilinearly at columns u (n,) and rows v (m,); the edges extend outwards."""
    h, w = grid.shape
    u, v = np.clip(u, 0, w - 1), np.clip(v, 0, h - 1)
    c, r = np.minimum(u.astype(int), max(w - 2, 0)), np.minimum(v.astype(int), max(h - 2, 0))
    c1, r1 = np.minimum(c + 1, w - 1), np.minimum(r + 1, h - 1)
    s, t = (u - c).astype(np.float32)[None], (v - r).astype(np.float32)[:, None]
    low = grid[r].astype(np.float32)
    rows = low + (grid[r1] - low) * t
    left = rows[:, c]
    mixed: Array = left + (rows[:, c1] - left) * s
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
    """Distance (h, w) float32 px of every pixel to the nearest True one; 1e9 when there is none."""
    if not mask.any():
        return np.full(mask.shape, 1e9, np.float32)
    d: Array = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
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
