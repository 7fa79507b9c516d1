"""The profile of a front: its signals from left to right, one row per bin along the wall."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage

from frontage.buildings.cloud import StreetCloud
from frontage.buildings.fronts.lines import StreetFront
from frontage.buildings.fronts.wall_map import WallMap
from frontage.buildings.groups import mean_of
from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.model.masonry import MASONRY

_LAYER_M = 0.1  # m, thickness of the layers in which the wall's offset is looked for
BIN_M = 0.25  # m, width of a bin along the front
_SKIN_M = 0.2  # m, half thickness of the wall's surface: mouldings belong to it
_PROUD_M = 1.0  # m, how far bays and cornices stand out from the wall
_BEHIND_M = MASONRY.relief  # m behind the wall: still its top, and not yet the roof
_CROWN_M = 1.0  # m, greatest height of a cornice or parapet above the recognised wall
_SHOP_M = 4.0  # m, height of the ground floor, whose colour may differ from that of the house


@dataclass(frozen=True, eq=False)
class FrontProfile:
    """Signals of n bins along a front; bin i begins at ``lo + i * BIN_M``. NaN where not measured.

    lo      m along the front
    offset  (n,) m, of the wall in front of the front's line
    top     (n,) m local z, eaves with cornice and parapet
    rough   (n,) m, spread of the wall's surface
    colour  (n, 6) Lab of the upper floors, then of the ground floor
    bright  (n,) log of the intensity
    rows    (n, r) 0 or 1, occupied wall per height bin of BIN_M m
    relief  (n, r) m in front of the front's line, per height bin
    base    m local z, foot of the lowest height bin
    count   (n,) occupied leaves on the wall: how well a bin was measured
    """

    lo: float
    offset: Float
    top: Float
    rough: Float
    colour: Float
    bright: Float
    rows: Float
    relief: Float
    base: float
    count: Float

    def __len__(self) -> int:
        return len(self.offset)

    def offset_at(self, s: Float) -> Float:
        """Interpolates the offset (k,) m at places s (k,) m along the front between measured bins."""
        known = np.flatnonzero(np.isfinite(self.offset))
        if not len(known):
            return np.zeros(len(s))
        return np.interp(s, self.lo + (known + 0.5) * BIN_M, self.offset[known])


@dataclass(frozen=True, eq=False)
class FrontLeaves:
    """Leaves of edge `size` m around a front, (k,) m each.

    s, d  along the front and in front of it
    z     local; `foot` height above the ground
    """

    s: Float
    d: Float
    z: Float
    foot: Float
    size: float


@dataclass(frozen=True, eq=False)
class LeafColour:
    """Colour of every leaf: Lab (m, 3) and log intensity (m,), each None where the scan has none."""

    lab: Float | None
    bright: Float | None


def colour_of(cloud: StreetCloud) -> LeafColour:
    """Averages colour and intensity of every leaf's points."""
    scan, leaf, of_point = cloud.scan, cloud.tree.leaf, cloud.tree.of_point
    lab = bright = None
    if scan.rgb is not None:
        rgb = np.column_stack([mean_of(of_point, scan.rgb[:, c], leaf.weight) for c in range(3)]) / 255.0
        lab = cv2.cvtColor(rgb[None].astype(np.float32), cv2.COLOR_RGB2LAB)[0].astype(np.float64)
    if scan.intensity is not None:
        bright = np.log(np.maximum(mean_of(of_point, scan.intensity, leaf.weight), 1e-3))
    return LeafColour(lab, bright)


def front_profile(
    cloud: StreetCloud, walls: WallMap, front: StreetFront, own: Int, colour: LeafColour
) -> FrontProfile:
    """Measures the profile of a front from the leaves `own` (k,) around it.

    `colour` is that of all leaves. Without measured ground, heights count from the lowest of the leaves.
    """
    tree, ground = cloud.tree, cloud.ground
    mean = tree.leaf.mean[own]
    s, d = front.coordinates(mean[:, :2])
    lowest = np.min(mean[:, 2]) if len(mean) else 0.0
    foot = mean[:, 2] - lowest if ground is None else ground.height(mean)
    lab = None if colour.lab is None else colour.lab[own]
    bright = None if colour.bright is None else colour.bright[own]
    at = FrontLeaves(s, d, mean[:, 2], foot, tree.leaf.size)
    return profile_of(front.lo, front.hi, at, walls.cells[tree.of_leaf[own]], LeafColour(lab, bright))


def profile_of(lo: float, hi: float, at: FrontLeaves, wall: Bool, colour: LeafColour) -> FrontProfile:
    """Measures the signals of a front between `lo` and `hi` m from its leaves.

    `wall` (k,) marks the leaves in upright, planar surroundings.
    """
    n = max(1, int(np.ceil((hi - lo) / BIN_M - 1e-9)))
    bin_ = np.floor((at.s - lo) / BIN_M).astype(np.int64)
    inside = (bin_ >= 0) & (bin_ < n)
    mode = _mode(bin_[inside & wall], at.d[inside & wall], n)
    rel = np.full(len(at.s), np.nan)
    rel[inside] = at.d[inside] - mode[bin_[inside]]
    near = wall & (np.abs(rel) < _SKIN_M)
    offset = _mean(bin_, at.d, near, n)
    rough = _mean(bin_[near], np.abs(at.d[near] - offset[bin_[near]]), np.ones(int(near.sum()), bool), n)
    proud = np.abs(rel) < _PROUD_M
    base = float(at.z[proud].min()) if proud.any() else 0.0
    row = np.floor((at.z - base) / BIN_M).astype(np.int64)
    return FrontProfile(
        lo,
        offset,
        _running_median(_eaves(bin_, at, rel, wall, n), 5),
        rough,
        _colour(bin_, near, at.foot, colour, n),
        _bright(bin_, near, colour, n),
        _rows(bin_, row, near, n),
        _relief(bin_, row, at.d, proud, n),
        base,
        np.bincount(bin_[near], minlength=n).astype(np.float64),
    )


def _eaves(bin_: Array, at: FrontLeaves, rel: Float, wall: Bool, n: int) -> Float:
    """Returns the top (n,) m local z of every bin: the highest wall with the cornice or parapet on it.

    What stands on the recognised wall without a gap belongs to it. NaN where there is no wall.
    """
    skin = (rel > -_BEHIND_M) & (rel < _PROUD_M)
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


def _relief(bin_: Array, row: Array, d: Float, keep: Bool, n: int) -> Float:
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


def _mode(at: Array, d: Float, n: int) -> Float:
    """Returns the wall's offset (n,) m in each bin: where most leaves lie, with the help of its neighbours.

    NaN where there is no wall.
    """
    if not len(d):
        return np.full(n, np.nan)
    low = float(d.min())
    layer = np.floor((d - low) / _LAYER_M).astype(np.int64)
    map_ = np.zeros((n, int(layer.max()) + 1))
    np.add.at(map_, (at, layer), 1.0)
    smooth = ndimage.gaussian_filter(map_, (1.0, 1.0), mode="constant")
    return np.where(map_.sum(1) >= 3, low + (smooth.argmax(1) + 0.5) * _LAYER_M, np.nan)


def _mean(at: Array, value: Float, keep: Bool, n: int) -> Float:
    """Returns the mean (n,) of the kept values per bin, NaN where there are fewer than three."""
    count = np.bincount(at[keep], minlength=n)
    total = np.bincount(at[keep], weights=value[keep], minlength=n)
    return np.where(count >= 3, total / np.maximum(count, 1), np.nan)


def _colour(at: Array, near: Bool, foot: Float, colour: LeafColour, n: int) -> Float:
    """Returns the mean Lab (n, 6) of the upper floors and of the ground floor; `foot` (k,) m above ground."""
    if colour.lab is None:
        return np.full((n, 6), np.nan)
    upper, lower = near & (foot > _SHOP_M), near & (foot <= _SHOP_M)
    return np.column_stack(
        [_mean(at, colour.lab[:, c], part, n) for part in (upper, lower) for c in range(3)]
    )


def _bright(at: Array, near: Bool, colour: LeafColour, n: int) -> Float:
    """Returns the mean log intensity (n,) of the wall."""
    return np.full(n, np.nan) if colour.bright is None else _mean(at, colour.bright, near, n)


def _rows(bin_: Array, row: Array, near: Bool, n: int) -> Float:
    """Returns the occupied wall (n, r), 0 or 1, per bin and height bin."""
    rows = np.zeros((n, int(row[near].max()) + 1 if near.any() else 1))
    rows[bin_[near], row[near]] = 1.0
    return rows


def _running_median(value: Float, width: int) -> Float:
    """Returns the median (n,) of the measured values in a window of `width` bins around each measured bin."""
    padded = np.pad(value, width // 2, constant_values=np.nan)
    window = np.lib.stride_tricks.sliding_window_view(padded, width)
    out = np.full(len(value), np.nan)
    known = np.isfinite(value)
    out[known] = np.nanmedian(window[known], axis=1)
    return out
