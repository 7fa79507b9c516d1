"""The profile of a front: its signals from left to right, one row per bin along the wall."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from frontage.buildings.cloud import StreetCloud
from frontage.buildings.fronts.front import StreetFront
from frontage.buildings.fronts.leaves import FrontLeaves, LeafColour
from frontage.buildings.fronts.signals import (
    PROUD_M,
    colour_per_bin,
    eaves,
    intensity_per_bin,
    mean_per_bin,
    occupied_rows,
    relief,
    running_median,
    tracked_offset,
)
from frontage.buildings.fronts.wall_map import WallMap
from frontage.geometry.arrays import Bool, Float, Int
from frontage.raster.memory import require_memory

BIN_M = 0.25  # m, width of a bin along the front
_SKIN_M = 0.2  # m, half thickness of the wall's surface: mouldings belong to it
_RECESS_M = 1.5  # m: narrower recesses are openings, niches and channels of one front

_ROW_BYTES = 48  # of a bin at one height: six numbers, in the rows and while the relief is measured


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
        return self._interpolated(self.offset, s)

    def face_at(self, s: Float) -> Float:
        """Returns the offset (k,) m of the front's face at places s (k,) m along it.

        Where a door or a window shows more of the room than there is wall above and below it, the offset of
        the bin is that of the room. Recesses too narrow for a front of their own are therefore filled.
        """
        middle: Float = self.lo + (np.arange(len(self), dtype=np.float64) + 0.5) * BIN_M
        every = self._interpolated(self.offset, middle)
        filled = ndimage.grey_closing(every, (round(_RECESS_M / BIN_M),), mode="nearest")
        return self._interpolated(np.asarray(filled), s)

    def _interpolated(self, offset: Float, s: Float) -> Float:
        """Interpolates offsets (n,) m of the bins at places s (k,) m; all zero if none is measured."""
        known = np.flatnonzero(np.isfinite(offset))
        if not len(known):
            return np.zeros(len(s))
        return np.interp(s, self.lo + (known + 0.5) * BIN_M, offset[known])


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

    `wall` (k,) marks the leaves in upright, planar surroundings. Raises InputError (I322) when a front is so
    large, as in millimetres, that its profile needs more memory than there is.
    """
    n = max(1, int(np.ceil((hi - lo) / BIN_M - 1e-9)))
    bin_ = np.floor((at.s - lo) / BIN_M).astype(np.int64)
    inside = (bin_ >= 0) & (bin_ < n)
    mode = tracked_offset(bin_[inside & wall], at.d[inside & wall], n)
    rel = np.full(len(at.s), np.nan)
    rel[inside] = at.d[inside] - mode[bin_[inside]]
    near = wall & (np.abs(rel) < _SKIN_M)
    offset = mean_per_bin(bin_, at.d, near, n)
    rough = mean_per_bin(
        bin_[near], np.abs(at.d[near] - offset[bin_[near]]), np.ones(int(near.sum()), bool), n
    )
    proud = np.abs(rel) < PROUD_M
    base = float(at.z[proud].min()) if proud.any() else 0.0
    row = np.floor((at.z - base) / BIN_M).astype(np.int64)
    high = int(row[near].max()) + 1 if near.any() else 1
    front = f"a front of {hi - lo:.0f} x {high * BIN_M:.0f} m"
    require_memory(_ROW_BYTES * n * high, front)
    return FrontProfile(
        lo,
        offset,
        running_median(eaves(bin_, at, rel, wall, n), 5),
        rough,
        colour_per_bin(bin_, near, at.foot, colour, n),
        intensity_per_bin(bin_, near, colour, n),
        occupied_rows(bin_, row, near, n),
        relief(bin_, row, at.d, proud, n),
        base,
        np.bincount(bin_[near], minlength=n).astype(np.float64),
    )
