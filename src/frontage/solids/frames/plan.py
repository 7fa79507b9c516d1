"""What stands in an opening, drawn in the plane of its surface, and the ends of its bars."""

from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.model import FRAME_THICKNESS_M

VERTICAL, HORIZONTAL = 0, 1
_PROUD_M = 0.001  # the front stands before the opening's surface, so that the two are not in one plane
DEPTHS_M = (-_PROUD_M, FRAME_THICKNESS_M - _PROUD_M)
"""Of the front and the back of a frame and its bars behind the surface of the opening."""
_RASTER = 10.0  # 0.1 mm: sides of bars that lie closer become one line, or are this far apart


@dataclass(frozen=True, eq=False)
class WindowPlan:
    """The frame and the bars of one opening, in 0.1 mm (x, z) of the plane of its surface.

    pose     of the plane in the local frame, m
    outline  the surface
    frame    how far the frame reaches in from the outline; 0 = no frame
    axis     (n,) of every bar, VERTICAL or HORIZONTAL
    position (n,) of the centre lines, across their axis
    ends     (n, 2) of the centre lines, along their axis, the lower one first
    width    (n,)
    """

    pose: Rigid3
    outline: BaseGeometry
    frame: float
    axis: Int
    position: Float
    ends: Float
    width: Float


def bar_boxes(plan: WindowPlan, clear: BaseGeometry, reach: float) -> Array:
    """Returns every bar as a rectangle whose ends reach what they end at.

    The centre line of a bar ends where it meets the frame or another bar, or a little before or behind that.
    An end within `reach` of the border of `clear`, the area inside the frame, is prolonged into the frame, so
    that both corners of the bar meet an arch; one within `reach` of a bar that crosses ends on its centre
    line.
    """
    ends, held = _ends_at_bars(plan, reach)
    outwards = np.array([-1.0, 1.0])
    along = ends + outwards * reach
    across = np.repeat(plan.position[:, None], 2, axis=1)
    upright = (plan.axis == VERTICAL)[:, None]
    inside = shapely.contains_xy(clear, np.where(upright, across, along), np.where(upright, along, across))
    longer = ends + outwards * (plan.frame + 2 * plan.width[:, None] + reach)
    low, high = np.where(held | inside, ends, longer).T
    left, right = plan.position - plan.width / 2, plan.position + plan.width / 2
    sides = np.where(upright, np.stack([left, low, right, high], 1), np.stack([low, left, high, right], 1))
    return np.atleast_1d(shapely.box(*(np.rint(sides / _RASTER) * _RASTER).T))


def _ends_at_bars(plan: WindowPlan, reach: float) -> tuple[Float, Bool]:
    """Returns the ends (n, 2) moved onto the crossing bars that they lie at, and which of them were."""
    spans = (plan.position[:, None] >= plan.ends[:, 0] - reach) & (
        plan.position[:, None] <= plan.ends[:, 1] + reach
    )
    crossing = spans & (plan.axis[:, None] != plan.axis)
    away = np.abs(plan.ends[:, :, None] - plan.position)
    near = crossing[:, None] & (away <= plan.width / 2 + reach)
    nearest = np.where(near, away, np.inf).argmin(2) if len(plan.axis) else np.zeros((0, 2), np.int64)
    held = near.any(2)
    return np.where(held, plan.position[nearest], plan.ends), held
