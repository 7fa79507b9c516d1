"""Where, and at which size, does one picture of a wall lie in another? An exhaustive search by FFT.

For every relative size the correlation of oriented gradients is computed at all shifts. It is normalised by
the energy of both pictures within their overlap. A coefficient r over n independent samples raises the
likelihood over that of unrelated pictures by ``-n/2 log(1 - r^2)``, which makes small and large overlaps
comparable. How many samples are independent is told by the scatter of the coefficients over all shifts.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from scipy import fft

from frontage.geometry.arrays import Array, Float
from frontage.orientation.gradients import Channels

_LEAST_OVERLAP = 600.0  # px
_APART_PX = 5  # peaks nearer to a higher one are the same
_PEAKS = 4  # per size


@dataclass(frozen=True)
class Place:
    """Where a picture lies in a map.

    size         px of the map per px of the picture
    column, row  px, place of the picture's upper left corner in the map
    score        correlation coefficient
    gain         log likelihood over chance
    """

    size: float
    column: float
    row: float
    score: float
    gain: float


def find_places(map_: Channels, picture: Channels, sizes: Float) -> list[Place]:
    """Returns the best places of a picture in a map, the most likely first, for all `sizes` (k,)."""
    found = [place for size in sizes for place in _at_size(map_, picture, float(size))]
    return sorted(found, key=lambda p: -p.gain)


def _at_size(map_: Channels, picture: Channels, size: float) -> Iterator[Place]:
    h, w = (max(4, round(side * size)) for side in picture.shape)
    small = _resized(picture, (h, w))
    rows, columns = map_.shape
    # Every shift with any overlap: the picture's corner runs from -h..rows and -w..columns.
    shape = (fft.next_fast_len(rows + h, real=True), fft.next_fast_len(columns + w, real=True))
    score, overlap = _correlation(map_, small, shape)
    enough = overlap > _LEAST_OVERLAP
    if not enough.any():
        return
    n, usable = overlap / _per_sample(score[enough], overlap[enough]), enough & (score > 0)
    gain = np.where(usable, -0.5 * n * np.log1p(-(np.clip(score, 0.0, 0.999) ** 2)), 0.0).astype(np.float32)
    highest = cv2.dilate(gain, np.ones((2 * _APART_PX + 1,) * 2, np.uint8))
    r, c = np.nonzero((gain == highest) & (gain > 0))
    for k in np.argsort(-gain[r, c], kind="stable")[:_PEAKS]:
        row = r[k] if r[k] < rows else r[k] - shape[0]
        column = c[k] if c[k] < columns else c[k] - shape[1]
        yield Place(
            w / picture.shape[1], float(column), float(row), float(score[r[k], c[k]]), float(gain[r[k], c[k]])
        )


def _per_sample(score: Array, overlap: Array) -> float:
    """Returns how many pixels count as one independent sample, from coefficients (n,) and overlaps (n,) px.

    The coefficient of unrelated pictures has the variance 1/n over n independent samples. Nearly all shifts
    are wrong, so that their mean square tells n. Long lines, repetition and enlargement leave few samples.
    """
    return float((score**2 * overlap**2).sum() / overlap.sum())


def _resized(picture: Channels, shape: tuple[int, int]) -> Channels:
    h, w = shape
    how = cv2.INTER_AREA if h < picture.shape[0] else cv2.INTER_LINEAR
    values = np.stack([cv2.resize(v, (w, h), interpolation=how) for v in picture.values])
    known = cv2.resize(picture.known.astype(np.float32), (w, h), interpolation=how) > 0.5
    return Channels(values * known, known)


def _correlation(map_: Channels, small: Channels, shape: tuple[int, int]) -> tuple[Array, Array]:
    """Normalised correlation and overlap in px at every circular shift of the padded shape."""

    def spectrum(picture: Array) -> Array:
        return np.asarray(fft.rfft2(picture.astype(np.float32), shape, workers=-1))

    def back(product: Array) -> Array:
        return np.asarray(fft.irfft2(product, shape, workers=-1))

    product = sum(spectrum(a) * np.conj(spectrum(b)) for a, b in zip(map_.values, small.values, strict=True))
    own, other = spectrum(map_.known), spectrum(small.known)
    energy_map = back(spectrum((map_.values**2).sum(0)) * np.conj(other))
    energy_small = back(own * np.conj(spectrum((small.values**2).sum(0))))
    overlap = back(own * np.conj(other))
    energy = np.maximum(energy_map, 1e-3) * np.maximum(energy_small, 1e-3)
    return back(np.asarray(product)) / np.sqrt(energy), overlap
