"""Fit a plane to the connected component of it that holds most of the points."""

from dataclasses import dataclass

import numpy as np

from frontage.facades.cloud import BuildingCloud, columns
from frontage.facades.outline import largest_part, occupied
from frontage.facades.plane.curvature import tangent_at_middle
from frontage.facades.plane.robust import fit_thinned
from frontage.facades.plane.search import sharp_plane
from frontage.geometry.arrays import Bool, Float
from frontage.geometry.plane import facade_axes
from frontage.model.masonry import MASONRY

RELIEF_M = MASONRY.relief  # m: claddings, plinths and bowed parts this near the plane shape the outline too
_BOW_M = 1.5  # m from its tangent plane at one end that a bowed wall may reach at the other


@dataclass(frozen=True, eq=False)
class PlaneCandidate:
    """A plane through `point` (3,) m with unit `normal` (3,), as found among thinned points.

    sigma      m, scatter of the points about it
    own        (n,) whether each thinned point lies on its largest connected component
    area       m2 that this component covers
    available  m2 that all points near the plane would cover side by side
    """

    normal: Float
    point: Float
    sigma: float
    own: Bool
    area: float
    available: float


def connected_plane(
    normal: Float,
    point: Float,
    thin: Float,
    cloud: BuildingCloud,
    *,
    levelled: bool,
    rng: np.random.Generator,
) -> PlaneCandidate:
    """Fits a plane anew to its largest connected component among the thinned points (n, 3) m.

    normal, point  (3,), (3,) m: the plane that the search found
    levelled       whether the cloud's z axis is the plumb line, so that an upright plane may be tried
    """
    axes = facade_axes(normal)
    q = columns(thin - point, axes)
    near = np.flatnonzero(np.abs(q[:, 1]) < 2.0 * cloud.threshold)
    own, available = np.zeros(len(thin), np.bool_), len(near) * cloud.cell**2
    on = q[near]
    region = None
    if len(near) >= 10:
        cell = 2.0 * cloud.cell  # a turned raster of one point per voxel has empty cells
        count, corner, _ = occupied(on[:, 0], on[:, 2], cell)
        region = largest_part(count, corner, cell, on)
    if region is None:
        own[near] = True
        return PlaneCandidate(normal, point, cloud.noise, own, 0.0, available)
    beside = q[np.abs(q[:, 1]) < _BOW_M]
    wide = beside[np.abs(beside[:, 1]) < RELIEF_M]
    wide = wide[region.within(wide[:, 0], wide[:, 2])]
    sharp = sharp_plane(wide, cloud, rng) if levelled else None
    own[near] = region.within(on[:, 0], on[:, 2])
    fit, sigma = fit_thinned(q[own], wide, cloud.threshold, sharp)
    own |= np.abs(q @ [-fit[1], 1.0, -fit[2]] - fit[0]) < 2.0 * cloud.threshold
    own &= region.within(q[:, 0], q[:, 2])
    residual = beside @ [-fit[1], 1.0, -fit[2]] - fit[0]
    shift, slope = tangent_at_middle(beside[:, 0], residual, cloud.threshold)
    tangent = axes @ np.array([-fit[1] - slope, 1.0, -fit[2]])
    tangent /= np.linalg.norm(tangent)
    return PlaneCandidate(tangent, point + axes[:, 1] * (fit[0] + shift), sigma, own, region.area, available)
