"""Signals of a front per bin along it: offset of the wall, eaves, relief, colour and intensity."""

import numpy as np
from scipy import ndimage

from frontage.buildings.fronts.leaves import FrontLeaves, LeafColour
from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.model.masonry import MASONRY

_LAYER_M = 0.1  # m, thickness of the layers in which the wall's offset is looked for
_STEP_BINS = 3.0  # bins full of wall that a step costs: half of the narrowest recess, which has two steps
PROUD_M = 1.0  # m, how far bays and cornices stand out from the wall
_NEAR_LAYERS = round(PROUD_M / _LAYER_M)  # about the best surface, among which a bin shows its own
_FRONT_M = MASONRY.facade_reach  # m before it, where the entablature over a recessed wall may lie
_BEHIND_M = MASONRY.relief  # m behind the wall: still its top, and not yet the roof
_CROWN_M = 1.0  # m, greatest height of a cornice or parapet above the recognised wall
_SHOP_M = 4.0  # m, height of the ground floor, whose colour may differ from that of the house


def eaves(bin_: Array, at: FrontLeaves, rel: Float, wall: Bool, n: int) -> Float:
    """Returns the top (n,) m local z of every bin: the highest wall with the cornice or parapet on it.

    What stands on the recognised wall without a gap belongs to it. NaN where there is no wall.
    """
    skin = (rel > -_BEHIND_M) & (rel < _FRONT_M)
    out = np.full(n, np.nan)
    if not (skin & wall).any():
        return out
    low = float(at.z[skin].min())
    row = np.floor((at.z[skin] - low) / at.size).astype(np.int64)
    highest = np.full((n, int(row.max()) + 3), -np.inf)
    np.maximum.at(highest, (bin_[skin], row), at.z[skin])
    top = np.full(n, -1)
    np.maximum.at(top, bin_[skin], np.where(wall[skin], row, -1))
    every = np.flatnonzero(top >= 0)
    for _ in range(int(np.ceil(_CROWN_M / at.size))):
        next_ = np.isfinite(highest[every, top[every] + 1])
        over = np.isfinite(highest[every, top[every] + 2]) & ~next_  # one leaf may be missing
        top[every] += next_ + 2 * over
    out[every] = highest[every, top[every]]
    return out


def relief(bin_: Array, row: Array, d: Float, keep: Bool, n: int) -> Float:
    """Returns the median d (n, r) m per bin and height bin; NaN where fewer than two leaves lie."""
    if not keep.any():
        return np.full((n, 1), np.nan)
    rows = int(row[keep].max()) + 1
    cell = bin_[keep] * rows + row[keep]
    order = np.lexsort((d[keep], cell))
    count = np.bincount(cell, minlength=n * rows)
    middle = np.cumsum(count) - count + count // 2
    out = np.full(n * rows, np.nan)
    out[count >= 2] = d[keep][order][middle[count >= 2]]
    return out.reshape(n, rows)


def tracked_offset(at: Array, d: Float, n: int) -> Float:
    """Returns the wall's offset (n,) m in each bin: the best surface from end to end of the front.

    Every bin tells for each layer how much of its wall lies there, with the help of its neighbours. The
    logarithm of the leaves counts, so that twice as much wall counts little more. A step costs as much as
    half of a recess that is too narrow to be more than an opening. So neither a door nor the wall of a room
    that was scanned from within, which shows more of itself than the front between its windows, draws the
    surface into the house. NaN where there is no wall.
    """
    if not len(d):
        return np.full(n, np.nan)
    low = float(d.min())
    layer = np.floor((d - low) / _LAYER_M).astype(np.int64)
    map_ = np.zeros((n, int(layer.max()) + 1))
    np.add.at(map_, (at, layer), 1.0)
    known = map_.sum(1) >= 3
    smooth = ndimage.gaussian_filter(map_, (1.0, 1.0), mode="constant")
    much = np.log1p(smooth)
    share = np.where(known[:, None], much / np.maximum(much.max(1, keepdims=True), 1e-9), 0.0)
    return np.where(known, low + (_nearest_peak(smooth, _best_path(share)) + 0.5) * _LAYER_M, np.nan)


def _best_path(share: Float) -> Int:
    """Returns the layer (n,) of every bin on the best path from end to end.

    That is the path with the largest sum of shares (n, l), from which its steps are taken off. It may change
    by one layer from bin to bin for nothing, because walls slant.
    """
    n, layers = share.shape
    total, came = share[0].copy(), np.empty((n, layers), np.int64)
    own = np.arange(layers)
    for i in range(1, n):
        beside = np.stack([np.roll(total, 1), total, np.roll(total, -1)])
        beside[0, 0] = beside[2, -1] = -np.inf
        best = int(total.argmax())
        near, far = beside.max(0), total[best] - _STEP_BINS
        came[i] = np.where(far > near, best, own + beside.argmax(0) - 1)
        total = share[i] + np.maximum(near, far)
    path = np.empty(n, np.int64)
    path[-1] = total.argmax()
    for i in range(n - 1, 0, -1):
        path[i - 1] = came[i, path[i]]
    return path


def _nearest_peak(count: Float, path: Int) -> Int:
    """Returns the fullest layer (n,) of every bin near a path (n,), from counts (n, l) of leaves."""
    near = np.abs(np.arange(count.shape[1]) - path[:, None]) <= _NEAR_LAYERS
    return np.asarray(np.where(near, count, -1.0).argmax(1), np.int64)


def mean_per_bin(at: Array, value: Float, keep: Bool, n: int) -> Float:
    """Returns the mean (n,) of the kept values per bin, NaN where there are fewer than three."""
    count = np.bincount(at[keep], minlength=n)
    total = np.bincount(at[keep], weights=value[keep], minlength=n)
    return np.where(count >= 3, total / np.maximum(count, 1), np.nan)


def colour_per_bin(at: Array, near: Bool, foot: Float, colour: LeafColour, n: int) -> Float:
    """Returns the mean Lab (n, 6) of the upper floors and of the ground floor; `foot` (k,) m above ground."""
    if colour.lab is None:
        return np.full((n, 6), np.nan)
    upper, lower = near & (foot > _SHOP_M), near & (foot <= _SHOP_M)
    return np.column_stack(
        [mean_per_bin(at, colour.lab[:, c], part, n) for part in (upper, lower) for c in range(3)]
    )


def intensity_per_bin(at: Array, near: Bool, colour: LeafColour, n: int) -> Float:
    """Returns the mean log intensity (n,) of the wall."""
    return np.full(n, np.nan) if colour.bright is None else mean_per_bin(at, colour.bright, near, n)


def occupied_rows(bin_: Array, row: Array, near: Bool, n: int) -> Float:
    """Returns the occupied wall (n, r), 0 or 1, per bin and height bin."""
    rows = np.zeros((n, int(row[near].max()) + 1 if near.any() else 1))
    rows[bin_[near], row[near]] = 1.0
    return rows


def running_median(value: Float, width: int) -> Float:
    """Returns the median (n,) of the measured values in a window of `width` bins around each measured bin."""
    padded = np.pad(value, width // 2, constant_values=np.nan)
    window = np.lib.stride_tricks.sliding_window_view(padded, width)
    out = np.full(len(value), np.nan)
    known = np.isfinite(value)
    out[known] = np.nanmedian(window[known], axis=1)
    return out
