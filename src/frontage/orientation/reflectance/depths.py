"""How well a drawing of the scan tells the depth at a pixel: a plane fitted to its pixels around."""

from dataclasses import dataclass
from math import ceil

import numpy as np

from frontage.geometry.arrays import Float
from frontage.orientation.reflectance.render import FINEST, Rendering

_REACH = ceil(0.5 / FINEST)  # px of a drawing to every side: half of the usual spacing of its points
_FEWEST = 6  # known pixels that a plane is fitted to
_RIDGE = 1e-6


@dataclass(frozen=True, eq=False)
class LocalPlanes:
    """Planes fitted to the depths of a drawing around pixels of the photo; NaN where too little is known.

    depth  (m,) m along the optical axis, at the pixels
    slope  (m, 2) m per px of the photo, how depth changes across and down
    rough  (m,) m, root mean square of the depths about the plane
    """

    depth: Float
    slope: Float
    rough: Float


def local_planes(drawing: Rendering, pixels: Float) -> LocalPlanes:
    """Fits a plane to the depths around pixels (m, 2) of the photo that the drawing was made for.

    On a wall the residuals are the noise of the scan. At a step, such as a reveal, they are half of it: beams
    hit one side or the other, and the drawing does not know the border better than to half of the spacing.
    """
    h, w = drawing.known.shape
    at = np.clip(pixels / drawing.scale, 0, (w - 1e-6, h - 1e-6))
    steps = np.stack(np.meshgrid(*[np.arange(-_REACH, _REACH + 1)] * 2), axis=-1).reshape(-1, 2)
    cell = np.floor(at).astype(np.int64)[:, None] + steps
    column, row = np.clip(cell, 0, (w - 1, h - 1)).transpose(2, 0, 1)
    inside = (cell >= 0).all(-1) & (cell < (w, h)).all(-1)
    depth = drawing.depth[row, column].astype(np.float64)
    weight = (inside & drawing.known[row, column] & (depth > 0)).astype(np.float64)
    count = weight.sum(1)
    middle = (weight * depth).sum(1) / np.maximum(count, 1)
    offset = cell + 0.5 - at[:, None]
    design = np.concatenate([np.ones((*offset.shape[:2], 1)), offset], axis=2)
    off = depth - middle[:, None]  # small numbers, so that squares keep their digits
    weighted = (weight[..., None] * design).swapaxes(1, 2)
    plane = np.linalg.solve(weighted @ design + _RIDGE * np.eye(3), weighted @ off[..., None])
    left = off - (design @ plane)[..., 0]
    plane = plane[..., 0]
    rough = np.sqrt((weight * left**2).sum(1) / np.maximum(count - 3, 1))
    known = np.where(count >= _FEWEST, 1.0, np.nan)
    return LocalPlanes((middle + plane[:, 0]) * known, plane[:, 1:] / drawing.scale, rough * known)
