"""Divides a wall whose parts no wall joins: those on both sides of an avant-corps that reaches the ground."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import ndimage

from frontage.facades.candidate import FacadeCandidate
from frontage.facades.cloud import BuildingCloud
from frontage.facades.scene import FacadeScene
from frontage.facades.sequential import is_large, least_area
from frontage.geometry.arrays import Bool
from frontage.model.masonry import MASONRY


def with_parts(candidates: Sequence[FacadeCandidate], scene: FacadeScene) -> list[FacadeCandidate]:
    """Returns the walls, with the large parts of each as walls of their own, in the order of their area.

    A strip that is no higher than a step, such as a kerb in the plane of the wall, does not join parts.
    """
    least = least_area(candidates, scene.options)
    found = []
    for candidate in candidates:
        parts = [_part(candidate, whole, scene.cloud) for whole in _wholes(candidate)]
        large = [part for part in parts if is_large(part.cells, least)]
        found += large if len(large) > 1 else [candidate]
    return found


def _wholes(candidate: FacadeCandidate) -> list[Bool]:
    """Returns the cells (h, w) of every part of a wall."""
    cells = candidate.cells
    thin = int(MASONRY.threshold / cells.cell) + 2  # its border cells are half filled
    labels, number = ndimage.label(ndimage.binary_opening(cells.whole, np.ones((thin, thin), np.bool_)))
    return [labels == k for k in range(1, number + 1)] if number > 1 else []


def _part(candidate: FacadeCandidate, whole: Bool, cloud: BuildingCloud) -> FacadeCandidate:
    """Returns the part of a wall with the cells `whole` (h, w), about the barycentre of its own inliers."""
    wall, cells = candidate.wall, candidate.cells.with_outline(whole)
    q = wall.coordinates(cloud.xyz[wall.inliers])
    on = cells.within(q[:, 0], q[:, 2])
    x, _, z = (float(v) for v in q[on].mean(0)) if on.any() else (0.0, 0.0, 0.0)
    moved = np.array([[1.0, x, z], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    own = replace(
        wall,
        point=wall.point + wall.axes @ np.array([x, 0.0, z]),
        covariance=moved @ wall.covariance @ moved.T,
        inliers=wall.inliers[on],
    )
    side = replace(candidate.side, sensors=candidate.side.sensors - np.array([x, 0.0, z]))
    return FacadeCandidate(own, cells.moved(x, z), candidate.slab.moved(own.axes, own.point), side)
