"""Pictures of a facade cut into patches, and how two of them agree; see `agreement`."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from scipy import special, stats

from frontage.geometry.arrays import Array, Bool
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.points import FacadePoints
from frontage.raster import gridding
from frontage.raster.tiles import tiles

_PATCH_PX = 48  # about two metres: a window with the wall around it
_INNER_PX = 24  # of the patch that is looked for, anywhere in the other: half a metre of tolerance
_MOST_PATCHES = 40  # evenly spread; enough to tell one in ten from one in two with certainty
_OTHERS = 9  # patches from elsewhere that a patch is compared with
_FEWEST_OTHERS = 4
_CLEAR = 0.98  # share of a patch that nothing may hide
_COVERED = 0.9  # share of a patch that must hold points of the scan
_BOX_PX = 19
_TEXTURE = 2.0  # grey values, standard deviation of a patch without its shading


@dataclass(frozen=True)
class Patches:
    """The patches (48, 48) float32 of a picture by their numbers: grey values without slow variation."""

    grey: dict[int, Array]


@dataclass(frozen=True, eq=False)
class ScanPatches:
    """The patches of the colours of a scan: of all its points, and of every second one.

    They are cut from numbers of points and sums of their values (2, h, w), and when they are first asked for.
    """

    odd_sums: Array
    even_sums: Array

    @cached_property
    def whole(self) -> Patches:
        """Those of all points."""
        return _of_sums(self.odd_sums + self.even_sums)

    @cached_property
    def odd(self) -> Patches:
        """Those of every second point."""
        return _of_sums(self.odd_sums)

    @cached_property
    def even(self) -> Patches:
        """Those of the other points."""
        return _of_sums(self.even_sums)


@dataclass(frozen=True)
class Agreement:
    """In how many of the patches that two pictures share they agree, and the share that would by chance."""

    agreeing: int
    count: int
    by_chance: float

    @property
    def rate(self) -> float:
        """The share of patches that agree, between 0 and 1 exclusively (Krichevsky and Trofimov 1981)."""
        return (self.agreeing + 0.5) / (self.count + 1.0)

    @property
    def chance(self) -> float:
        """The probability that pictures without relation agree so often or more often."""
        return float(special.bdtrc(self.agreeing - 1, self.count, self.by_chance)) if self.count else 1.0

    def log_likelihood(self, rate: float) -> float:
        """The logarithm of the probability of the number found, for pictures that agree at this rate."""
        return float(stats.binom.logpmf(self.agreeing, self.count, rate))


def of_photo(codes: Array, clear: Bool) -> Patches:
    """The patches of a photo rectified on cells (h, w, 4), where these are `clear` (h, w) of occluders."""
    return _cut(cv2.cvtColor(codes, cv2.COLOR_RGBA2GRAY), clear, _CLEAR)


def of_scan(points: FacadePoints, raster: OrthoRaster) -> ScanPatches | None:
    """The patches of the colours of a scan; None without colours."""
    rgb = points.scan.rgb
    if rgb is None:
        return None
    value = np.compress(points.used, rgb, axis=0) @ np.full(3, 1.0 / 3.0)
    shape = (raster.height, raster.width)
    cell, inside = gridding.cell_index(raster.pixel(points.xyz_used), shape)
    value, size = value[inside], shape[0] * shape[1]
    odd, even = (
        np.stack([np.bincount(cell[part], weights, size) for weights in (None, value[part])])
        for part in (np.s_[1::2], np.s_[::2])
    )
    return ScanPatches(odd.reshape(2, *shape), even.reshape(2, *shape))


def _of_sums(sums: Array) -> Patches:
    """The patches of numbers of points and sums of their values (2, h, w), where most cells hold points or
    lie beside one."""
    count, total = sums.astype(np.float32)
    near, weight = cv2.GaussianBlur(total, (0, 0), 1.0), cv2.GaussianBlur(count, (0, 0), 1.0)
    grey = np.where(count > 0, total / np.maximum(count, 1.0), near / np.maximum(weight, 1e-6))
    known = cv2.dilate((count > 0).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    return _cut(grey.astype(np.float32), known, _COVERED)


def _cut(grey: Array, known: Bool, share: float) -> Patches:
    """The patches of a picture (h, w) of which at least a share is known and that have texture."""
    flat = without_shading(grey)
    whole = [t for t in tiles(grey.shape[0], grey.shape[1], _PATCH_PX) if t.shape == (_PATCH_PX, _PATCH_PX)]
    chosen = np.linspace(0, len(whole) - 1, min(len(whole), _MOST_PATCHES)).astype(int).tolist()
    found = {}
    for number in chosen:
        patch = np.ascontiguousarray(flat[whole[number].window])
        if known[whole[number].window].mean() >= share and _inner(patch).std() >= _TEXTURE:
            found[number] = patch
    return Patches(found)


def without_shading(grey: Array) -> Array:
    """Grey values (h, w), smoothed by a pixel, less their means over two boxes (sigma 7.7 px): float32.

    The means of uint8 are whole numbers, which is good enough to compare patches, and not to measure shifts.
    """
    mean = cv2.blur(cv2.blur(grey, (_BOX_PX, _BOX_PX)), (_BOX_PX, _BOX_PX))
    smooth = cv2.GaussianBlur(grey.astype(np.float32, copy=False), (0, 0), 1.0)
    return np.asarray(cv2.subtract(smooth, mean, dtype=cv2.CV_32F))


def agreement(a: Patches, b: Patches, enough: float = 0.0) -> Agreement:
    """Counts the patches of a picture that resemble the same patch of another more than several others of it.

    Of the two pictures, the one with more patches lends the others. No more patches are compared once all so
    far agree and the probability of that by chance is `enough`.
    """
    a, b = sorted((a, b), key=lambda picture: len(picture.grey))
    numbers = sorted(b.grey)
    others = min(_OTHERS, len(numbers) - 1)
    if others < _FEWEST_OTHERS:
        return Agreement(0, 0, 1.0)
    steps = np.linspace(1, len(numbers) - 1, others).astype(int)  # all different, none is zero
    agreeing = count = 0
    by_chance = 1.0 / (others + 1)
    for n in sorted(a.grey.keys() & b.grey.keys()):
        if agreeing == count and by_chance**count <= enough:
            break
        at = numbers.index(n)
        elsewhere = [numbers[(at + step) % len(numbers)] for step in steps.tolist()]
        own = _alike(a.grey[n], b.grey[n])
        agreeing += all(own > _alike(a.grey[n], b.grey[m]) for m in elsewhere)
        count += 1
    return Agreement(agreeing, count, by_chance)


def similarity(a: Patches, b: Patches) -> dict[int, float]:
    """How alike the patches are that two pictures share, -1..1, by their numbers."""
    return {n: _alike(a.grey[n], b.grey[n]) for n in sorted(a.grey.keys() & b.grey.keys())}


def _alike(a: Array, b: Array) -> float:
    """The highest correlation of the middle of a patch with any place of another."""
    return float(cv2.matchTemplate(b, np.ascontiguousarray(_inner(a)), cv2.TM_CCOEFF_NORMED).max())


def _inner(patch: Array) -> Array:
    margin = (_PATCH_PX - _INNER_PX) // 2
    return patch[margin:-margin, margin:-margin]
