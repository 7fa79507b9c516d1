"""The leaves around a front, and their colour."""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.buildings.cloud import StreetCloud
from frontage.buildings.groups import mean_of
from frontage.geometry.arrays import Float


@dataclass(frozen=True, eq=False)
class FrontLeaves:
    """Leaves of edge `size` m around a front, (k,) m each.

    s, d  along the front and in front of it
    z     local; `foot` height above the ground
    """

    s: Float
    d: Float
    z: Float
    foot: Float
    size: float


@dataclass(frozen=True, eq=False)
class LeafColour:
    """Colour of every leaf: Lab (m, 3) and log intensity (m,), each None where the scan has none."""

    lab: Float | None
    bright: Float | None


def colour_of(cloud: StreetCloud) -> LeafColour:
    """Averages colour and intensity of every leaf's points."""
    scan, leaf, of_point = cloud.scan, cloud.tree.leaf, cloud.tree.of_point
    lab = bright = None
    if scan.rgb is not None:
        rgb = np.column_stack([mean_of(of_point, scan.rgb[:, c], leaf.weight) for c in range(3)]) / 255.0
        lab = cv2.cvtColor(rgb[None].astype(np.float32), cv2.COLOR_RGB2LAB)[0].astype(np.float64)
    if scan.intensity is not None:
        bright = np.log(np.maximum(mean_of(of_point, scan.intensity, leaf.weight), 1e-3))
    return LeafColour(lab, bright)
