"""Which part of the frame's plane the scanner sees at all: sills and reveals hide the rest of it.

A frame runs all around its window, so that every row and every column of it that beams reach returns points,
at least those of its sides. Where rows at one end of the window return none, beams do not reach them: what
is hidden there says nothing for or against bars.
"""

import numpy as np

from frontage.crossbars.candidates import Box
from frontage.geometry.arrays import Float

_SIDE_M = 0.06  # of frame that every row and every column of a window crosses at least
_STRAY = 0.05  # of it, share of points in rows that are hidden: mixed pixels at the edge of the reveal
_CELL_M = 0.02
_SURE = 3.0  # nats without which nothing is taken to be hidden


def exposed_box(ring: Float, points: Float, dense: float) -> Box:
    """Returns the part x0, z0, x1, z1 m of a window's frame that beams reach.

    ring    (k, 2) m, the outline of the opening
    points  (n, 3) m, facade frame: those near the plane of the frame
    dense   points per m2 that a surface there returns
    """
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    x, z = points[:, 0], points[:, 2]
    left, right = _hidden(x - x0, x1 - x0, dense), _hidden(x1 - x, x1 - x0, dense)
    below, above = _hidden(z - z0, z1 - z0, dense), _hidden(z1 - z, z1 - z0, dense)
    return float(x0 + left), float(z0 + below), float(max(x1 - right, x0)), float(max(z1 - above, z0))


def _hidden(at: Float, length: float, dense: float) -> float:
    """Returns how far m inwards from one side beams reach nothing; points are at distances (n,) m from it.

    The number of points is that of a Poisson process with a step in its density at the place returned.
    """
    cells = max(1, round(length / _CELL_M))
    count = np.histogram(at, cells, (0.0, length))[0]
    expected = dense * _SIDE_M * length / cells
    gain = np.cumsum((1 - _STRAY) * expected + count * np.log(_STRAY))
    k = int(gain.argmax())
    return (k + 1) * length / cells if gain[k] > _SURE else 0.0
