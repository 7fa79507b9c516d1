"""Distinct rows of integers by sorting columns: several times faster than `numpy.unique` on rows."""

import numpy as np

from frontage.geometry.arrays import Array, Bool, Int


def distinct_rows(rows: Array) -> tuple[Array, Int, Int]:
    """Returns the distinct rows (u, k) in order, which of them each row is (n,), and their counts (u,)."""
    if not len(rows):
        return rows, np.zeros(0, np.int64), np.zeros(0, np.int64)
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    fresh = np.ones(len(rows), np.bool_)
    fresh[1:] = (ordered[1:] != ordered[:-1]).any(1)
    label = np.empty(len(rows), np.int64)
    label[order] = np.cumsum(fresh) - 1
    return ordered[fresh], label, np.bincount(label)


def rows_among(rows: Int, known: Int) -> Bool:
    """Returns which rows (n, k) occur in `known` (m, k)."""
    _, label, count = distinct_rows(np.concatenate([rows, known]))
    there = np.zeros(len(count), np.bool_)
    there[label[len(rows) :]] = True
    return np.asarray(there[label[: len(rows)]])
