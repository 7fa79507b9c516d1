"""Statistics of arrays by column and by group, faster than numpy's own over millions of rows."""

import numpy as np

from frontage.geometry.arrays import Array, Float, Int


def mean_of(group: Array, value: Array, count: Float) -> Float:
    """Returns the mean (m,) of `value` (n,) per group (n,) int, with `count` (m,) members each."""
    return np.bincount(group, weights=value, minlength=len(count)) / np.maximum(count, 1)


def grouped(group: Array, count: int) -> tuple[Int, Int]:
    """Sorts members by group -1 .. count - 1.

    Returns the members (n,) int64 in this order, and where each group >= 0 begins, with the end (count + 1,).
    """
    small = group.astype(np.int16) if count < 1 << 15 else group  # 16 bits are sorted by radix, in O(n)
    sort = np.argsort(small, kind="stable").astype(np.int64)
    size = np.bincount(group + 1, minlength=count + 1)
    return sort, np.cumsum(size).astype(np.int64)
