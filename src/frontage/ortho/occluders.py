"""The points that may hide a facade from a photo: everything on its street side."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.model import Facade, Scan
from frontage.ortho.options import OrthoOptions
from frontage.ortho.standing.find import Standing
from frontage.raster.zbuffer import local_spacing

_FEWEST_TOGETHER = 3  # points in one cube of the cloud below which they are noise and hide nothing


Spaced = tuple[Array, Array]
"""Points (n, 3) float32 m in the facade frame, and the spacing (n,) float32 m of the surface of each."""


@dataclass(frozen=True, eq=False)
class OccluderCloud:
    """What may hide the facade: its own parts, and what stands free before it.

    `solid` are those of the free points that belong to things without gaps, such as cars and people.
    """

    part: Spaced
    free: Spaced
    solid: Spaced


def find_occluders(
    facade: Facade, xyz_facade: Float, standing: Standing, surroundings: Scan | None, options: OrthoOptions
) -> OccluderCloud:
    """Returns the points in front of the back of the facade with their local spacing, without lone points.

    `xyz_facade` (n, 3) m is the scan of the facade in its frame. Free are the points of what is `standing`
    before it, however near, and all points so far before it that they are no part of it.
    """
    clouds = [xyz_facade]
    if surroundings is not None:
        clouds.append(facade.frame.inverse.apply(surroundings.xyz))
    xyz, spacing = [], []
    for points in clouds:
        ahead = points[points[:, 1] < options.back]
        s, k = local_spacing(ahead)
        surface = k >= _FEWEST_TOGETHER
        xyz.append(ahead[surface].astype(np.float32))
        spacing.append(s[surface].astype(np.float32))
    every, gap = np.concatenate(xyz), np.concatenate(spacing)
    free = (every[:, 1] < -options.front) | standing.holds(every)
    solid = free & standing.holds_in_solid(every)
    return OccluderCloud(*((every[which], gap[which]) for which in (~free, free, solid)))
