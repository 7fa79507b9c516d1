"""How far every photo disagrees with the others, cell by cell: what only one of them shows is not the wall.

Where three photos or more see a cell, the median of their colours is what stands still. The colour of a photo
is either that of the wall, with a normal error, or that of anything else, with any colour alike: moved cars,
walkers, reflections. The error grows with the contrast around the cell, because photos are a part of a cell
off (poses, relief). The negative logarithm of that likelihood is the cost of taking the photo there.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool
from frontage.ortho.mosaic.pictures import picked

_GAMMA = 2.2  # differences of codes are about equally visible in the light and in the dark
FEWEST_PHOTOS = 3
"""Photos of a cell, of which one that differs can be told from the others."""
MEDIAN_LENGTH = 1.54
"""Standard deviations: the median length of normal errors in three channels."""
_ELSE = 0.05  # share of cells in which a photo shows something else than the wall
_FINEST = 0.01  # codes 0..1; smallest standard deviation of equal colours
_OFF_CELLS = 0.5  # cells by which photos are displaced against each other
_ENOUGH = 100_000  # colours, whose median is as good as that of all
_WINDOW = 3  # cells over which costs are averaged: what is seen is larger than one cell


@dataclass(frozen=True, eq=False)
class Disagreement:
    """What speaks against the photos (k) in the cells (h, w).

    cost      (k, h, w) float32 >= 0, negative log likelihood relative to a perfect agreement
    contrast  (h, w) float32, change of the wall's colour from cell to cell in standard deviations
    accepted  (k, h, w) bool, rather the wall than something else
    wall      (h, w, 3) float32, colour of what stands still
    distance  (k, h, w) float32, of the colours of the photos from it
    sigma     (h, w) float32, standard deviation of the colour that a photo shows it in
    """

    cost: Array
    contrast: Array
    accepted: Bool
    wall: Array
    distance: Array
    sigma: Array


def even_colours(light: Array) -> Array:
    """The colours (k, h, w, 3) float32 of photos of which the even log `light` is given, as codes 0..1.

    They take the place of the light in memory.
    """
    light *= np.float32(1.0 / _GAMMA)
    flat = light.reshape(len(light), -1)
    cv2.exp(flat, dst=flat)
    return light


def compare_photos(codes: Array, clear: Bool) -> Disagreement:
    """Compares the colours (k, h, w, 3) of photos where the scan knows nothing before the wall (`clear`)."""
    count = clear.sum(0)
    wall = _median(codes, clear, count)
    known = count >= FEWEST_PHOTOS
    distance = np.stack([length(colours - wall) for colours in codes])
    noise = max(_noise(distance, clear, count), _FINEST)
    slope = _slope(wall)
    sigma = np.sqrt(noise**2 + (_OFF_CELLS * slope) ** 2)
    cost, accepted = _cost(distance, sigma)
    judged = clear & known
    accepted |= ~judged
    cost = np.stack([cv2.blur(c, (_WINDOW, _WINDOW)) for c in cost * judged])
    return Disagreement(
        cost, (slope / noise).astype(np.float32), accepted, wall, distance, sigma.astype(np.float32)
    )


def _noise(distance: Array, clear: Bool, count: Array) -> float:
    """The standard deviation of the colours of photos on the wall.

    It is that of three photos or more, of which half lie within 1.54 standard deviations of their median. Two
    photos lie half as far from their mean as from each other, and an error each makes that 0.71 of it.
    """
    several = clear & (count >= FEWEST_PHOTOS)
    if several.any():
        return _typical(distance, several) / MEDIAN_LENGTH
    return _typical(distance, clear & (count == FEWEST_PHOTOS - 1)) * 2**0.5 / MEDIAN_LENGTH


def _typical(distance: Array, judged: Bool) -> float:
    """Returns the median of the judged distances (k, h, w); if they are many, that of a regular sample."""
    at = np.flatnonzero(judged)
    return float(np.median(distance.ravel()[at[:: 1 + len(at) // _ENOUGH]])) if len(at) else 0.0


def _median(codes: Array, clear: Bool, count: Array) -> Array:
    """The median colour (h, w, 3) of the photos that see a cell; of no photo, black."""
    ordered = [np.full_like(colours, np.inf) for colours in codes]
    for colours, mask, own in zip(codes, clear, ordered, strict=True):
        cv2.copyTo(colours, mask.view(np.uint8), own)
    _sort(ordered)
    middle = np.maximum(count - 1, 0).astype(np.int16)
    median = picked(ordered, middle // 2)
    median += picked(ordered, (middle + 1) // 2)
    median *= np.float32(0.5)
    median[count == 0] = 0.0
    return median


def _sort(values: list[Array]) -> None:
    """Sorts k arrays of one shape place by place, by odd-even transpositions of whole arrays."""
    low = np.empty_like(values[0])
    for first in range(len(values)):
        for i in range(first % 2, len(values) - 1, 2):
            one, other = values[i], values[i + 1]
            np.minimum(one, other, out=low)
            np.maximum(one, other, out=other)
            values[i], low = low, one


def _slope(wall: Array) -> Array:
    """Change of colour per cell (h, w), the larger of both directions."""
    smooth = cv2.GaussianBlur(wall, (0, 0), 0.7)
    across, down = (cv2.Scharr(smooth, cv2.CV_32F, *d) / 32.0 for d in ((1, 0), (0, 1)))
    return np.maximum(length(across), length(down))


def length(vectors: Array) -> Array:
    """The lengths (h, w) float32 of vectors (h, w, 3)."""
    x, y, z = cv2.split(vectors)
    for axis in (x, y, z):
        axis *= axis
    x += y
    x += z
    return np.asarray(cv2.sqrt(x, dst=x))


def _cost(distance: Array, sigma: Array) -> tuple[Array, Bool]:
    """Negative log likelihood (k, h, w) of colours `distance` from the wall's; where the wall is likelier."""
    peak = (1.0 - _ELSE) / ((2.0 * np.pi) ** 1.5 * sigma**3)
    own = peak * np.exp(-0.5 * (distance / sigma) ** 2)
    return np.log(peak + _ELSE) - np.log(own + _ELSE), own > _ELSE
