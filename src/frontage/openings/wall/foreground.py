"""What stands before the wall at the foot of an opening: steps and balconies lead to doors."""

import numpy as np

from frontage.geometry.arrays import Float
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.evidence import Evidence

_NEAR, _FAR = 0.3, 1.3  # m before the wall, between which the fronts of steps and balconies stand
_BELOW, _ABOVE = 0.5, 0.3  # m from the foot of the opening, between which they show
_SHARE = 0.3  # share of the beams expected there that they must stop


def foreground_points(beams: Beams) -> Float:
    """Returns the places (n, 2) x, z m, sorted by x, of the points that may be steps and balconies."""
    p = beams.front
    some = p[(p[:, 2] < -_NEAR) & (p[:, 2] > -_FAR), :2]
    return np.asarray(some[np.argsort(some[:, 0])])


def is_foreground_at_foot(before: Float, evidence: Evidence, x0: float, x1: float, foot: float) -> bool:
    """Returns whether steps or a balcony stand before an opening's `foot` z m, between x0 and x1 m.

    `before` are the `foreground_points`.
    """
    low, high = foot - _BELOW, foot + _ABOVE
    z = before[slice(*np.searchsorted(before[:, 0], [x0, x1])), 1]
    some = int(((z > low) & (z < high)).sum())
    cell, corner = evidence.raster.cell, evidence.raster.corner
    c0, c1 = (np.clip(round((x - corner[0]) / cell), 0, evidence.expected_free.shape[1]) for x in (x0, x1))
    r0, r1 = (np.clip(round((z - corner[1]) / cell), 0, evidence.expected_free.shape[0]) for z in (low, high))
    return some > max(_SHARE * float(evidence.expected_free[r0:r1, c0:c1].sum()), 3.0)
