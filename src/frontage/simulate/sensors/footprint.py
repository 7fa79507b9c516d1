"""The cross-section of a laser beam, sampled by sub-rays.

A Gaussian beam of exit diameter a and divergence t (both at 1/e2 of the power) has the diameter
``w(R) = sqrt(a^2 + (t R)^2)`` at range R. Straight rays follow it exactly if they are skew, the rulings of a
hyperboloid: their start is moved by (a/2) q and their direction by (t/2) q', with q' at a right angle to q.
"""

from functools import cache

import numpy as np

from frontage.geometry.arrays import Array, Float, readonly
from frontage.simulate.sensors.instrument import Instrument

_GOLDEN_RAD = np.pi * (3 - np.sqrt(5))  # by which the pattern turns from beam to beam, so that none repeats


@cache
def beam_pattern(count: int) -> tuple[Float, Float]:
    """Return nodes (count, 2), in units of the beam's radius, and weights (count,) with sum 1.

    They form a hexagonal lattice of 1, 7, 19 or 37 nodes with Gaussian weights, scaled so that its second
    moment is that of the beam: 1/4 per axis for a power of exp(-2 r^2).
    """
    rings = {1: 0, 7: 1, 19: 2, 37: 3}[count]
    i, j = np.meshgrid(*[np.arange(-rings, rings + 1)] * 2, indexing="ij")
    inside = np.abs(i + j) <= rings
    node = np.column_stack([(i + 0.5 * j)[inside], (np.sqrt(3) / 2 * j)[inside]])
    # this Gaussian width reproduces the power beyond a straight edge best (to 4 % with 19 nodes)
    weight = np.exp(-2 * (node**2).sum(1) / max(1.5 * rings, 1) ** 2)
    weight /= weight.sum()
    moment = (weight * (node**2).sum(1)).sum() / 2
    if rings:
        node *= np.sqrt(0.25 / moment)
    return readonly(node, (count, 2), np.float64, "node"), readonly(weight, (count,), np.float64, "weight")


def sub_rays(instrument: Instrument, origins: Float, directions: Float, first: int) -> tuple[Float, Float]:
    """Return the starts and directions (n, k, 3) of the k sub-rays of n beams.

    origins (n, 3) m and unit directions (n, 3) are those of the beams; `first` is the number of the first
    beam, on which the rotation of the pattern depends. The lengths of the returned directions differ from 1
    by less than 1e-5.
    """
    node, _ = beam_pattern(instrument.subrays)
    side, up = _across(directions)
    turn = _GOLDEN_RAD * (first + np.arange(len(directions)))
    c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
    a, b = c * node[:, 0] - s * node[:, 1], s * node[:, 0] + c * node[:, 1]
    start, slope = instrument.exit_beam / 2, instrument.divergence / 2
    across = a[..., None] * side[:, None] + b[..., None] * up[:, None]
    along = a[..., None] * up[:, None] - b[..., None] * side[:, None]
    return origins[:, None] + start * across, directions[:, None] + slope * along


def _across(directions: Array) -> tuple[Float, Float]:
    """Returns two unit vectors (n, 3) at right angles to unit directions (n, 3) and to each other."""
    steep = np.abs(directions[:, 2]) > 0.9
    helper = np.where(steep[:, None], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    side = np.cross(directions, helper)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    return side, np.cross(side, directions)
