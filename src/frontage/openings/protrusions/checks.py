"""Decides whether a piece in front of the wall belongs to it: straight borders, and close to the wall."""

import numpy as np

from frontage.geometry.arrays import Float
from frontage.openings.boxes import Box
from frontage.openings.protrusions.boxes import filled, occupied, shown_sides
from frontage.openings.protrusions.resolution import Resolution

_TOUCH = 0.2  # m from the wall: what belongs to it comes so near
_CONTACT = 0.1  # share of a protrusion's outline along which it must
_FREE = 0.4  # the same for what stands on the ground, as cars do: of its sides and its top
_SIDE = 0.8  # share of a side that shows points, on two sides at least
_SIDES = 0.6  # share of all sides that does: those of foliage are frayed
_FILLED = 0.2  # share of the front's cells that shows points: railings are open, foliage more so
_STRIP = 0.04  # m, least width of the strip along a border


def is_framed(own: Float, front: Float, box: Box, resolution: Resolution) -> bool:
    """Returns whether points show along the sides of a box and all over its front.

    own    (n, 3) m, all points of the piece
    front  (m, 3) m, those on its front

    What something hides in part is still framed on two sides; trees have no straight borders.
    """
    cell = max(2.0 * resolution.spacing, _STRIP)
    shares = shown_sides(own, box, cell)
    straight = sorted(shares)[-2] >= _SIDE and float(np.mean(shares)) >= _SIDES
    return straight and filled(front, box, cell) >= _FILLED


def is_attached(p: Float, box: Box, y: float, ground: float) -> bool:
    """Returns whether the points (n, 3) m of a box with its front at y m come near the wall around it.

    Cars, people, lamps and trees stand free of the wall. What stands on the ground (z m) must touch the wall
    along more of its outline, or along most of one side: the other cheek of a bay may be hidden.
    """
    if -y <= _TOUCH:
        return True
    x0, z0, x1, z1 = box
    p = p[p[:, 1] > -_TOUCH]
    step, rim, stands = _TOUCH / 2, _TOUCH, z0 < ground + _TOUCH
    upright = [occupied(p[np.abs(p[:, 0] - x) < rim, 2], step) for x in (x0, x1)]
    level = [occupied(p[np.abs(p[:, 2] - z) < rim, 0], step) for z in ([z1] if stands else [z0, z1])]
    share = sum(upright + level) * step / (2.0 * (z1 - z0) + len(level) * (x1 - x0))
    return share >= (_FREE if stands else _CONTACT) or max(upright) * step >= _SIDE * (z1 - z0)
