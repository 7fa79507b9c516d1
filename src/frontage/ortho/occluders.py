"""The points that may hide a facade from a photo: everything on its street side."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.model import Facade, Scan
from frontage.ortho.options import OrthoOptions
from frontage.raster.zbuffer import local_spacing

_FEWEST_TOGETHER = 3  # points in one cube of the cloud below which they are noise and hide nothing


@dataclass(frozen=True, eq=False)
class OccluderCloud:
    """What may hide the facade.

    xyz      (n, 3) m local
    spacing  (n,) m, of the surface that a point belongs to
    free     (n,) bool, so far before the facade that it is no part of it
    """

    xyz: Float
    spacing: Float
    free: Bool


def find_occluders(
    facade: Facade, scan: Scan, surroundings: Scan | None, options: OrthoOptions
) -> OccluderCloud:
    """Returns the points in front of the back of the facade with their local spacing, without lone points."""
    clouds = [scan.xyz] if surroundings is None else [scan.xyz, surroundings.xyz]
    xyz, spacing, free = [], [], []
    for points in clouds:
        y = facade.frame.inverse.apply(points)[:, 1]
        ahead, before = points[y < options.back], y[y < options.back] < -options.front
        s, k = local_spacing(ahead)
        surface = k >= _FEWEST_TOGETHER
        xyz.append(ahead[surface])
        spacing.append(s[surface])
        free.append(before[surface])
    return OccluderCloud(np.concatenate(xyz), np.concatenate(spacing), np.concatenate(free))
