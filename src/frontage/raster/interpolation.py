"""Values between the cells of a grid: bilinear, or those of the nearest cell."""

from typing import NamedTuple

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Int

_SAME_PLACE = 1e-6  # pixels


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
