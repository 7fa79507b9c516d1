"""What a front looks like from left to right: one row of signals per bin along the wall."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage

from frontage.buildings.voxels import Level, mean_of
from frontage.geometry.arrays import Array, Bool, Float
from frontage.model import Scan

BIN = 0.25  # m, width of a bin along the front
_SKIN = 0.2  # m, half thickness of the wall surface: mouldings belong to it
_SHOP = 4.0  # m, height of the ground floor, whose colour is its own business


@dataclass(frozen=True, eq=False)
class Profile:
    """Signals of n bins along a front; bin i covers lo + i BIN .. lo + (i + 1) BIN. NaN = not measured.

    offset (n,) m in front of the front's line; top (n,) m local z, eaves; rough (n,) m, spread of
    the wall surface
    colour (n, 6) Lab of the upper floors, then of the ground floor; bright (n,) log of the intensity
    rows (n, r) share of occupied wall, per height bin of BIN m
    count (n,) occupied leaves on the wall: how well a bin was measured
    """

    lo: float
    offset: Float
    top: Float
    rough: Float
    colour: Float
    bright: Float
    rows: Float
    count: Float

    def __len__(self) -> int:
        return len(self.offset)

    def offset_at(self, s: Float) -> Float:
        """Offset (k,) m at places s (k,) m along the front, from the nearest measured bin."""
        known = np.flatnonzero(np.isfinite(self.offset))
        if not len(known):
            return np.zeros(len(s))
        return np.interp(s, self.lo + (known + 0.5) * BIN, self.offset[known])


@dataclass(frozen=True, eq=False)
class Paint:
    """Colour of every leaf: Lab (m, 3) and log intensity (m,), or None."""

    lab: Float | None
    bright: Float | None


def paint_of(scan: Scan, leaf: Level, of_point: Array) -> Paint:
    """Mean colour and intensity of every leaf's points."""
    lab = bright = None
    if scan.rgb is not None:
        rgb = np.column_stack([mean_of(of_point, scan.rgb[:, c], leaf.weight) for c in range(3)]) / 255.0
        lab = cv2.cvtColor(rgb[None].astype(np.float32), cv2.COLOR_RGB2LAB)[0].astype(np.float64)
    if scan.intensity is not None:
        bright = np.log(np.maximum(mean_of(of_point, scan.intensity, leaf.weight), 1e-3))
    return Paint(lab, bright)


def profile_of(lo: float, hi: float, s: Float, d: Float, z: Float, foot: Float, paint: Paint) -> Profile:
    """Signals from the wall leaves of a front: s, d (k,) m, z (k,) m local, `foot` (k,) m height
    above the ground."""
    n = max(1, int(np.ceil((hi - lo) / BIN - 1e-9)))
    at = np.floor((s - lo) / BIN).astype(np.int64)
    inside = (at >= 0) & (at < n)
    mode = _mode(at[inside], d[inside], n)
    near = np.zeros(len(s), bool)
    near[inside] = np.abs(d[inside] - mode[at[inside]]) < _SKIN
    high = np.zeros(len(s), bool)
    high[inside] = np.abs(d[inside] - mode[at[inside]]) < 1.0
    offset = _mean(at, d, near, n)
    rough = _mean(at[near], np.abs(d[near] - offset[at[near]]), np.ones(int(near.sum()), bool), n)
    top = np.full(n, -np.inf)
    np.maximum.at(top, at[high], z[high])
    top = _running_median(np.where(np.isfinite(top), top, np.nan), 5)
    return Profile(
        lo,
        offset,
        top,
        rough,
        _colour(at, near, foot, paint, n),
        _bright(at, near, paint, n),
        _rows(at, z, near, n),
        np.bincount(at[near], minlength=n).astype(np.float64),
    )


def _mode(at: Array, d: Float, n: int) -> Float:
    """Offset (n,) m of the wall in each bin: where most leaves lie, its neighbours helping; NaN = no wall."""
    if not len(d):
        return np.full(n, np.nan)
    low = float(d.min())
    layer = np.floor((d - low) / 0.1).astype(np.int64)
    map_ = np.zeros((n, int(layer.max()) + 1))
    np.add.at(map_, (at, layer), 1.0)
    smooth = ndimage.gaussian_filter(map_, (1.0, 1.0), mode="constant")
    return np.where(map_.sum(1) >= 3, low + (smooth.argmax(1) + 0.5) * 0.1, np.nan)


def _mean(at: Array, value: Float, keep: Bool, n: int) -> Float:
    """Mean (n,) of the kept values per bin, NaN where fewer than 3."""
    count = np.bincount(at[keep], minlength=n)
    total = np.bincount(at[keep], weights=value[keep], minlength=n)
    return np.where(count >= 3, total / np.maximum(count, 1), np.nan)


def _colour(at: Array, near: Bool, foot: Float, paint: Paint, n: int) -> Float:
    if paint.lab is None:
        return np.full((n, 6), np.nan)
    upper, lower = near & (foot > _SHOP), near & (foot <= _SHOP)
    return np.column_stack([_mean(at, paint.lab[:, c], part, n) for part in (upper, lower) for c in range(3)])


def _bright(at: Array, near: Bool, paint: Paint, n: int) -> Float:
    return np.full(n, np.nan) if paint.bright is None else _mean(at, paint.bright, near, n)


def _rows(at: Array, z: Float, near: Bool, n: int) -> Float:
    """Occupied wall (n, r) 0 or 1, per bin and height bin of BIN m."""
    if not near.any():
        return np.zeros((n, 1))
    row = np.floor((z[near] - z[near].min()) / BIN).astype(np.int64)
    rows = np.zeros((n, int(row.max()) + 1))
    rows[at[near], row] = 1.0
    return rows


def _running_median(value: Float, width: int) -> Float:
    """Median (n,) of the measured values in a window of `width` bins around each measured bin."""
    padded = np.pad(value, width // 2, constant_values=np.nan)
    window = np.lib.stride_tricks.sliding_window_view(padded, width)
    out = np.full(len(value), np.nan)
    known = np.isfinite(value)
    out[known] = np.nanmedian(window[known], axis=1)
    return out
