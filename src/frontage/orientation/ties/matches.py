"""Matching of descriptors: nearest neighbours by products of matrices, in blocks that stay in the cache."""

from collections.abc import Callable

import numpy as np

from frontage.geometry.arrays import Array, Int

_BLOCK = 512  # rows of a product
_ALIKE = 0.75  # cosine of two descriptors of the same thing; 0.7 as a distance, as in COLMAP

Gate = Callable[[slice], Array]
"""Returns for a slice of the first key points which second ones (rows, n) bool may match."""


def unit(descriptors: Array) -> Array:
    """Returns descriptors (n, 128) as float32 vectors of length 1."""
    d = descriptors.astype(np.float32)
    unit_length: Array = d / np.maximum(np.linalg.norm(d, axis=1, keepdims=True), np.float32(1e-6))
    return unit_length


def mutual(a: Array, b: Array, ratio: float, gate: Gate | None = None) -> Int:
    """Pairs (m, 2) of descriptors that are each other's nearest, and much nearer than the second nearest.

    a (n, 128), b (k, 128)  from `unit`
    ratio                   largest distance to the nearest, per distance to the second nearest
    gate                    limits the candidates
    """
    if not len(a) or len(b) < 2:
        return np.empty((0, 2), np.int64)
    best = np.full(len(b), -1.0, np.float32)
    nearest, cosine, second = _best_two(a, b, gate, best)
    far = np.sqrt(np.maximum(2 - 2 * second, 0))
    near = np.sqrt(np.maximum(2 - 2 * cosine, 0))
    good = (cosine >= _ALIKE) & (near <= ratio * far) & (cosine >= best[nearest])
    i = np.flatnonzero(good)
    return np.column_stack([i, nearest[i]]).astype(np.int64)


def _best_two(a: Array, b: Array, gate: Gate | None, best: Array) -> tuple[Int, Array, Array]:
    """Nearest (n,) of b for each of a, its cosine (n,), the second's (n,); `best` (k,) gets each column's."""
    nearest = np.empty(len(a), np.int64)
    cosine, second = np.empty(len(a), np.float32), np.empty(len(a), np.float32)
    for k in range(0, len(a), _BLOCK):
        part = slice(k, min(k + _BLOCK, len(a)))
        table = a[part] @ b.T
        if gate is not None:
            table[~gate(part)] = -1.0
        np.maximum(best, table.max(0), out=best)
        rows = np.arange(len(table))
        nearest[part] = j = table.argmax(1)
        cosine[part] = table[rows, j]
        table[rows, j] = -1.0
        second[part] = table.max(1)
    return nearest, cosine, second


def several(a: Array, b: Array, count: int) -> Int:
    """The `count` nearest of b for every descriptor of a, however alike: pairs (m, 2), alike enough at all.

    Where a facade repeats, the true match is one of them.
    """
    pairs = []
    for k in range(0, len(a), _BLOCK):
        table = a[k : k + _BLOCK] @ b.T
        rows = np.arange(len(table))
        for _ in range(min(count, len(b))):
            j = table.argmax(1)
            good = table[rows, j] >= _ALIKE
            pairs.append(np.column_stack([k + rows[good], j[good]]))
            table[rows, j] = -1.0
    return np.concatenate(pairs).astype(np.int64) if pairs else np.empty((0, 2), np.int64)
