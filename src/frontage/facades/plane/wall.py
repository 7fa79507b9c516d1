"""A wall plane: position, direction, scatter, covariance and inliers."""

from dataclasses import dataclass

import numpy as np

from frontage.facades.cells import CellMap
from frontage.facades.cloud import Slab
from frontage.geometry.arrays import Float, Int
from frontage.geometry.plane import facade_axes

INLIER_SIGMAS = 3.0  # inliers lie within this many standard deviations of the plane


@dataclass(frozen=True, eq=False)
class WallPlane:
    """A wall plane, either sketched (covariance NaN) or refined.

    normal      (3,) unit vector
    point       (3,) m local: barycentre of the inliers, moved onto the plane
    sigma       m, robust standard deviation of the inliers; `threshold` is three times that
    covariance  (3, 3) of offset (m), slope along x (rad) and slope along z (rad) at `point`
    inliers     (k,) int64 into BuildingCloud.xyz
    dof         effective degrees of freedom of the fit
    """

    normal: Float
    point: Float
    sigma: float
    threshold: float
    covariance: Float
    inliers: Int
    dof: float

    @property
    def axes(self) -> Float:
        """(3, 3), columns X, Y, Z: the axes of the facade frame if `normal` points into the building."""
        return facade_axes(self.normal)

    def coordinates(self, xyz: Float) -> Float:
        """Transforms local points (n, 3) m to facade coordinates (n, 3) m."""
        return np.asarray((xyz - self.point) @ self.axes, np.float64)

    def flipped(self) -> "WallPlane":
        """Returns the same plane with the opposite normal."""
        # offset and lean change sign with y; the slope along x keeps its sign because x flips as well
        sign = np.diag([-1.0, 1.0, -1.0])
        return WallPlane(
            -self.normal,
            self.point,
            self.sigma,
            self.threshold,
            sign @ self.covariance @ sign,
            self.inliers,
            self.dof,
        )


def sketch_wall(slab: Slab, region: CellMap, sigma: float) -> WallPlane | None:
    """Makes a wall without covariance from the plane of `slab`, moved to the barycentre of its inliers.

    The inliers lie within 3 `sigma` m of the plane and inside `region`. Returns None for fewer than ten.
    """
    near = np.flatnonzero(np.abs(slab.q[:, 1]) < INLIER_SIGMAS * sigma)
    q = slab.at(near)
    on = region.within(q[:, 0], q[:, 2])
    if np.count_nonzero(on) < 10:
        return None
    x, z = float(q[on, 0].mean()), float(q[on, 2].mean())
    return WallPlane(
        slab.axes[:, 1],
        slab.point + slab.axes @ np.array([x, 0.0, z]),
        sigma,
        INLIER_SIGMAS * sigma,
        np.full((3, 3), np.nan),
        slab.rows[near[on]],
        0.0,
    )
