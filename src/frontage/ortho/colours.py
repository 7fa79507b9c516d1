"""Densities of colours: how usual a colour is on the wall, behind glass, or of what stands before them."""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Int

_BINS = 32  # of the codes of a channel
_BLUR = 0.7  # bins, sigma
_FLOOR = 0.02  # share of colours that were never seen before, all alike


@dataclass(frozen=True, eq=False)
class Colours:
    """A density of colours, per unit of the cube of codes 0..1."""

    table: Array

    @classmethod
    def of(cls, codes: Array) -> "Colours":
        """The density of colours (n, 3), blurred, with a floor."""
        count = np.bincount(_bin(codes), minlength=_BINS**3).reshape((_BINS,) * 3).astype(np.float32)
        for axis in range(3):
            moved = np.ascontiguousarray(np.moveaxis(count, axis, 0)).reshape(_BINS, -1)
            moved = cv2.GaussianBlur(moved, (1, 7), sigmaX=0.01, sigmaY=_BLUR)
            count = np.moveaxis(moved.reshape((_BINS,) * 3), 0, axis)
        share = count / max(float(count.sum()), 1e-6)
        return cls((1.0 - _FLOOR) * share * _BINS**3 + _FLOOR)

    def __call__(self, codes: Array) -> Array:
        """The density (...) at colours (..., 3)."""
        return np.asarray(np.take(self.table.ravel(), _bin(codes)))


def normal_density(apart: Array, sigma: Array) -> Array:
    """The density (...) of differences of `apart` (...) standard deviations, `sigma` (...) per channel."""
    return np.asarray(np.exp(-0.5 * apart**2) / ((2.0 * np.pi) ** 1.5 * sigma**3))


def _bin(codes: Array) -> Int:
    """The numbers (...) of the cells of the cube of colours (..., 3) in which they lie."""
    number: Int = np.zeros(codes.shape[:-1], np.int64)
    for channel in range(3):
        number *= _BINS
        number += np.clip(codes[..., channel] * np.float32(_BINS), 0, _BINS - 1).astype(np.int64)
    return number
