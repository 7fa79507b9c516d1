"""Fills what nothing saw from the mirrored half of a symmetric facade: by option only, marked as inferred.

The axis is the vertical line about which the picture resembles its mirror image most. The correlation of a
picture with its mirror image about every axis is a convolution of the picture with itself, weighted by what
both halves show. An axis is believed if that correlation is high and far beyond chance.
"""

import cv2
import numpy as np
from scipy import stats

from frontage.geometry.arrays import Array, Bool
from frontage.model import INFERRED, NOT_SEEN
from frontage.ortho.bands import TILE_PX, Bands
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import OrthoRaster

_CELL_M = 0.04  # of the picture that is compared
_MAX_CELLS = 4_000_000
_DETAIL_M = 0.5  # wider structures, such as shadows, are no sign of symmetry; also the size of one element
_OVERLAP = 0.5  # share of the seen facade that must have a seen mirror image
_ALIKE = 0.6  # correlation from which one half shows what the other looks like
_CHANCE = 1e-4  # probability at which an axis may be found on a facade without symmetry


def fill_by_symmetry(bands: Bands, raster: OrthoRaster, options: OrthoOptions) -> None:
    """Fills the pixels `NOT_SEEN` whose mirror image was seen, with the source `INFERRED`.

    Does nothing unless the options ask for it, and on a facade without an axis of symmetry.
    """
    if options.fill != "symmetry":
        return
    least = np.sqrt(raster.width * raster.height / _MAX_CELLS)
    step = max(1, round(_CELL_M / raster.gsd), int(np.ceil(least)))
    first = step // 2
    grey = cv2.cvtColor(np.ascontiguousarray(bands.pixels[first::step, first::step, :3]), cv2.COLOR_RGB2GRAY)
    seen = _seen(bands.source[first::step, first::step])
    axis = _axis(grey.astype(np.float32), seen, _DETAIL_M / (raster.gsd * step))
    if axis is None:
        return
    mirrored = round(axis * step + 2 * first) - np.arange(raster.width)
    inside = (mirrored >= 0) & (mirrored < raster.width)
    mirrored = np.clip(mirrored, 0, raster.width - 1)
    for row in range(0, raster.height, TILE_PX):
        rows = slice(row, min(row + TILE_PX, raster.height))
        source = bands.source[rows]
        empty = (source == NOT_SEEN) & inside & _seen(source[:, mirrored])
        for band in (bands.pixels[rows], bands.gsd[rows]):
            band[empty] = band[:, mirrored][empty]
        source[empty] = INFERRED


def _seen(source: Array) -> Bool:
    """Which pixels show something that was seen."""
    return np.asarray((source > 0) & (source < INFERRED))


def _axis(grey: Array, seen: Bool, detail: float) -> float | None:
    """Sum of the columns of a cell and its mirror image, in cells; None without a symmetry.

    `grey` (h, w) is compared where it was `seen`, after everything wider than `detail` cells was removed.
    """
    if not seen.any():
        return None
    weight = seen.astype(np.float32)
    mean = cv2.GaussianBlur(grey * weight, (0, 0), detail)
    mean /= np.maximum(cv2.GaussianBlur(weight, (0, 0), detail), 1e-6)
    value = np.where(seen, grey - mean, 0.0)
    length = 2 * grey.shape[1]
    shown, own, square = (np.fft.rfft(v, length, axis=1) for v in (weight, value, value * value))
    product, energy, count = (
        np.fft.irfft((a * b).sum(0), length) for a, b in ((own, own), (square, shown), (shown, shown))
    )
    enough = count >= _OVERLAP * seen.sum()
    likeness = np.where(enough, product / np.maximum(energy, 1e-6), -1.0)
    best = int(np.argmax(likeness))
    alike, elements = float(likeness[best]), count[best] / (2.0 * detail**2)  # every pair counts twice
    if alike < _ALIKE or elements <= 4.0:
        return None
    beyond = float(np.arctanh(min(alike, 0.999)) * np.sqrt(elements - 3.0))  # Fisher's transformation
    if stats.norm.sf(beyond) * enough.sum() > _CHANCE:
        return None
    left, right = (likeness[(best + d) % length] for d in (-1, 1))
    bend = left - 2.0 * alike + right
    return best + (float(0.5 * (left - right) / bend) if bend < 0.0 and min(left, right) > -1.0 else 0.0)
