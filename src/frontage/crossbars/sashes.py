"""The planes in which bars lie: behind the front of the frame, and one behind the other in sliding sashes.

Bars stand a little behind the front of the frame, so that their own depth is swept for inside it. The lower
sash of a sliding window runs behind the upper one: where the two halves of a window agree far better at two
depths than at one, its bars lie in two planes.
"""

from collections.abc import Sequence

import numpy as np

from frontage.crossbars.candidates import Box
from frontage.crossbars.depth import StraightEdges, likelihoods
from frontage.crossbars.rectify import Grid
from frontage.model import Estimate

_BEHIND_M = 0.012  # usual distance of bars behind the front of the frame; of its standard error, twice
_SPREAD_M = 0.008
_REACH_M = (-0.03, 0.09)  # about the depth of the frame
_STEP_M = 0.004
_SASH_M = (0.015, 0.08)  # how far a lower sash can lie behind the upper one
_GAIN = -2.0  # nats by which two planes explain the views better than one; below, they are not tried
_STILE_M = 0.025  # of the stiles of sashes about the panes, whose inner edges lie in the planes of the sashes


def bar_depths(
    grid: Grid, edges: Sequence[StraightEdges], frame: Estimate[float], box: Box
) -> tuple[float, float]:
    """Returns the depths m behind the wall of the bars in the upper and in the lower half of a window.

    They are the same unless the views tell that the lower half lies behind the upper one.

    edges  of the views on the wall, see `depth.edges_of`
    frame  the depth of the front of the frame
    box    x0, z0, x1, z1 m inside the frame
    """
    if len(edges) < 2:
        return float(frame.value), float(frame.value)
    depths = frame.value + np.arange(_REACH_M[0], _REACH_M[1], _STEP_M)
    spread = np.hypot(_SPREAD_M, frame.sigma[0])
    prior = -0.5 * ((depths - frame.value - _BEHIND_M) / spread) ** 2
    middle = 0.5 * (box[1] + box[3])
    left, low, right, high = box[0] - _STILE_M, box[1] - _STILE_M, box[2] + _STILE_M, box[3] + _STILE_M
    halves = (left, middle, right, high), (left, low, right, middle)
    upper, lower = np.array([likelihoods(grid, edges, float(d), halves) for d in depths]).T
    together = upper + lower + prior
    apart = depths[None, :] - depths[:, None]
    both = (upper + prior)[:, None] + lower[None, :]
    both = np.where((apart >= _SASH_M[0]) & (apart <= _SASH_M[1]), both, -np.inf)
    if both.max() - together.max() > _GAIN:
        u, v = np.unravel_index(int(both.argmax()), both.shape)
        return float(depths[u]), float(depths[v])
    one = float(depths[int(together.argmax())])
    return one, one
