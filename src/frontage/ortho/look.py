"""One look for all pictures of a street: what photos that several of them share say of their light.

The photos of a building were brought to one light, the mean of their own (`mosaic.radiometry`): the next
house, painted from photos that were exposed longer, has another. A photo that shows both tells by how much
they differ, and all such photos are adjusted together.
"""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.ortho.mosaic.radiometry import STOPS, robust_adjustment

_MEAN_R2, _MEAN_R4 = 1.0 / 3.0, 0.15  # of a picture, when its corners lie at r = 1


def common_look(light: Mapping[str, Mapping[str, Array]]) -> dict[str, Float]:
    """Returns by how much pictures have to be brightened so that they look alike.

    `light` holds, for every picture, the rows (3, 3) of `OrthoImage.light` of its photos. Returns logarithms
    of linear light (3,), red, green, blue; their mean over pictures that hang together is zero, and a picture
    that shares no photo with another stays as it is.
    """
    names = list(light)
    shared: dict[str, list[int]] = {}
    for k, name in enumerate(names):
        for photo in light[name]:
            shared.setdefault(photo, []).append(k)
    pairs = [(p, a, b) for p, own in sorted(shared.items()) for a, b in pairwise(own)]
    design, value = np.zeros((len(pairs), len(names))), np.zeros((len(pairs), 3))
    for row, (photo, a, b) in enumerate(pairs):
        design[row, [a, b]] = 1.0, -1.0
        value[row] = _mean(light[names[a]][photo]) - _mean(light[names[b]][photo])
    sigma = np.full(len(names), STOPS)
    zero = np.zeros(len(names))
    found = np.column_stack([robust_adjustment(design, value[:, c], zero, sigma) for c in range(3)])
    return dict(zip(names, found, strict=True))


def _mean(rows: Array) -> Float:
    """The mean (3,) over a photo of what its rows (3, 3) add to the logarithm of its light."""
    return np.asarray(rows[0] + _MEAN_R2 * rows[1] + _MEAN_R4 * rows[2], np.float64)
