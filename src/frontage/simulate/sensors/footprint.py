"""The cross-section of a laser beam, sampled by sub-rays.

A Gaussian beam of exit diameter a and divergence t (both 1/e2 of the power) has the diameter
``w(R) = sqrt(a^2 + (t R)^2)``. Straight rays follow it exactly when they are skew: the start is moved by
(a/2) q and the direction by (t/2) q', with q' at a right angle to q. They rule a hyperboloid.
"""

from functools import cache

import numpy as np

from frontage.geometry.arrays import Array, Float, readonly
from frontage.simulate.sensors.instrument import Instrument

_GOLDEN = np.pi * (3 - np.sqrt(5))  # rad: turns of the pattern from beam to beam, never the same twice


@cache
def beam_pattern(count: int) -> tuple[Float, Float]:
    """Nodes (count, 2) in units of the beam's radius and weights (count,) with sum 1.

    A hexagonal lattice of 1, 7, 19 or 37 nodes with Gaussian weights, scaled so that its second moment is the
    beam's: power exp(-2 r^2) has 1/4 per axis.
    """
    rings = {1: 0, 7: 1, 19: 2, 37: 3}[count]
    i, j = np.meshgrid(*[np.arange(-rings, rings + 1)] * 2, indexing="ij")
    inside = np.abs(i + j) <= rings
    node = np.column_stack([(i + 0.5 * j)[inside], (np.sqrt(3) / 2 * j)[inside]])
    # of all Gaussian widths this one brings the power beyond an edge nearest to the beam's (4 %, 19 nodes)
    weight = np.exp(-2 * (node**2).sum(1) / max(1.5 * rings, 1) ** 2)
    weight /= weight.sum()
    moment = (weight * (node**2).sum(1)).sum() / 2
    if rings:
        node *= np.sqrt(0.25 / moment)
    return readonly(node, (count, 2), np.float64, "node"), readonly(weight, (count,), np.float64, "weight")


def sub_rays(instrument: Instrument, origins: Float, directions: Float, first: int) -> tuple[Float, Float]:
    """Starts and directions (n, k, 3) of the sub-rays of n beams.

    origins, directions (n, 3), unit directions; `first` is the number of the first beam, which turns the
    pattern. The length of the directions differs from 1 by less than 1e-5.
    """
    node, _ = beam_pattern(instrument.subrays)
    side, up = _across(directions)
    turn = _GOLDEN * (first + np.arange(len(directions)))
    c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
    a, b = c * node[:, 0] - s * node[:, 1], s * node[:, 0] + c * node[:, 1]
    start, slope = instrument.exit_beam / 2, instrument.divergence / 2
    across = a[..., None] * side[:, None] + b[..., None] * up[:, None]
    along = a[..., None] * up[:, None] - b[..., None] * side[:, None]
    return origins[:, None] + start * across, directions[:, None] + slope * along


def _across(directions: Array) -> tuple[Float, Float]:
    """Two unit vectors (n, 3) at right angles to unit directions (n, 3)."""
    steep = np.abs(directions[:, 2]) > 0.9
    helper = np.where(steep[:, None], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    side = np.cross(directions, helper)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    return side, np.cross(side, directions)
