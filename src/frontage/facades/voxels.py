"""Number points by voxel, and thin a cloud to one point per voxel."""

import numpy as np

from frontage.geometry.arrays import Float, Int, drawn, extent
from frontage.model.canonical import steady

_BLOCK_POINTS = 16384  # points at a time, so that a block stays in the processor's cache
DENSE_CELLS = 40_000_000  # voxels, above which a table of all of them costs more than a sort


def voxel_of(xyz: Float, cell: float) -> tuple[Int, int]:
    """Numbers points (n, 3) by voxel, x fastest and z slowest; returns the numbers (n,) and their range."""
    low, high = extent(xyz)
    size = ((high - low) * (1.0 / cell)).astype(np.int64) + 1
    stride = np.array([1, size[0], size[0] * size[1]])
    flat = np.empty(len(xyz), np.int64)
    for start in range(0, len(xyz), _BLOCK_POINTS):  # a block stays in the processor's cache
        block = xyz[start : start + _BLOCK_POINTS] - low
        block *= 1.0 / cell
        flat[start : start + _BLOCK_POINTS] = block.astype(np.int64) @ stride  # truncates, as all are >= 0
    return flat, int(size[0]) * int(size[1]) * int(size[2])


def voxel_first(xyz: Float, cell: float) -> Int:
    """Returns the first point (k,) int64 of every occupied voxel, in voxel order (z slowest)."""
    flat, total = voxel_of(xyz, cell)
    if total > DENSE_CELLS:
        return np.asarray(np.unique(flat, return_index=True)[1], np.int64)
    table = np.full(total, -1, np.int32)
    # the last one written is the first point
    table[flat[::-1]] = np.arange(len(flat) - 1, -1, -1, dtype=np.int32)
    return table[np.flatnonzero(table >= 0)].astype(np.int64)


def drawn_voxels(xyz: Float, cell: float, most: int) -> Float:
    """Returns the mean (k, 3) m of the points (n, 3) m in every voxel, or in about `most` of the voxels."""
    flat, total = voxel_of(xyz, cell)
    if total > DENSE_CELLS:
        flat = np.unique(flat, return_inverse=True)[1]
    held = np.bincount(flat) > 0
    number = np.empty(len(held), np.int32)
    number[held] = np.arange(np.count_nonzero(held))
    own = number[flat]  # counted among the occupied voxels, which are few
    count = np.bincount(own)
    mean = steady(np.stack([np.bincount(own, xyz[:, k]) / count for k in range(3)], axis=1))
    return mean[drawn(mean, most)]
