"""Mouldings and curved bays: pieces without a flat front, but with the same profile all along."""

import numpy as np

from frontage.geometry.arrays import Bool, Float, distinct
from frontage.openings.boxes import Box
from frontage.openings.protrusions.boxes import cells_of, extent
from frontage.openings.protrusions.checks import is_framed
from frontage.openings.protrusions.resolution import Resolution

_PROFILE = (0.05, 3.0)  # m and spacings, least cell of a profile
_CHUNK = 0.5  # m, least length over which profiles are compared
_CHUNKS = (4, 40)  # least and largest number of such lengths
_COMMON = 0.5  # share of the chunks that hold a cell of the common profile
_CURVE = 2.0  # cells of a profile per cell of the box around it, along both sides: more fill its area
_TAIL = 0.5  # share of the fullest line: thinner lines are not along the whole of it
_FEWEST = 60  # points of a moulding
_FRONT = 0.02  # quantile of the foremost points, strays aside


def common_profile(p: Float, axis: int, resolution: Resolution) -> Bool:
    """Returns which of the points (n, 3) m lie on a profile that is the same along an axis (0 = x, 2 = z).

    The axis is cut into chunks; a cell of the plane across it belongs to the profile when half of them hold
    it. Mouldings have a profile along x, round bays and columns one along z; foliage fills an area instead of
    a line.
    """
    length = float(np.ptp(p[:, axis])) if len(p) else 0.0
    number = min(int(length / _CHUNK), _CHUNKS[1])
    if len(p) < _FEWEST or number < _CHUNKS[0]:
        return np.zeros(len(p), np.bool_)
    cell = max(_PROFILE[0], _PROFILE[1] * resolution.spacing)
    across = cells_of(p[:, [2 - axis, 1]], cell)
    key = across[:, 0] * (across[:, 1].max() + 1) + across[:, 1]
    chunk = np.minimum(((p[:, axis] - p[:, axis].min()) / length * number).astype(np.int64), number - 1)
    held = np.bincount(distinct(key * number + chunk) // number, minlength=int(key.max()) + 1)
    on = np.asarray(held[key] >= _COMMON * number)
    sides = (np.ptp(across[on], axis=0) + 1).sum() if on.any() else 0
    return on if len(distinct(key[on])) <= _CURVE * sides else np.zeros(len(p), np.bool_)


def find_moulding(p: Float, resolution: Resolution) -> tuple[Bool, Bool, Box, float] | None:
    """Returns the moulding or round bay among points (n, 3) m, None where there is none.

    It comes as which points are on it, which are on its foremost edge, its box, and the y m of that edge.
    """
    for axis in (0, 2):
        on = common_profile(p, axis, resolution)
        if on.sum() < _FEWEST:
            continue
        box = extent(p[on], resolution.cell, _TAIL)
        long, wide = (box[2] - box[0], box[3] - box[1]) if axis == 0 else (box[3] - box[1], box[2] - box[0])
        least = resolution.least
        shaped = long >= _CHUNKS[0] * _CHUNK and wide >= least[1] and (axis == 2 or long >= 4.0 * wide)
        if shaped and is_framed(p[on], p[on], box, resolution):
            y = float(np.quantile(p[on, 1], _FRONT))
            return on, on & (p[:, 1] <= y + resolution.half), box, y
    return None
