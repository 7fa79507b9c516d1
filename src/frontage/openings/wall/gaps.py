"""Fills the gaps of maps over a wall."""

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float


def filled(values: Float, gap: Bool) -> Float:
    """Fills the gaps in the values (h, w) with the nearest others, of two as near with the lesser."""
    near = ndimage.distance_transform_edt(gap, return_distances=False, return_indices=True)
    far = ndimage.distance_transform_edt(gap[:, ::-1], return_distances=False, return_indices=True)
    right = values[:, ::-1][tuple(far)][:, ::-1]
    return np.asarray(np.minimum(values[tuple(near)], right), np.float64)


def between(values: Float, held: Bool) -> Float:
    """Interpolates the values (h, w) that are not `held` between the next held ones of their row."""
    w = values.shape[1]
    at = np.broadcast_to(np.arange(w), values.shape)
    left = np.maximum.accumulate(np.where(held, at, -1), axis=1)
    right = np.minimum.accumulate(np.where(held, at, w)[:, ::-1], axis=1)[:, ::-1]
    before, after = (np.take_along_axis(values, np.clip(k, 0, w - 1), 1) for k in (left, right))
    line = before + (after - before) * (at - left) / np.maximum(right - left, 1)
    return np.where((left < 0) | (right >= w), values, line)
