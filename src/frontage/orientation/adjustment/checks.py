"""Check points: control that is left out of the adjustment and compared with it afterwards."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.orientation.adjustment.network import Network, PointObservations
from frontage.orientation.adjustment.result import Adjustment


@dataclass(frozen=True, eq=False)
class CheckPoints:
    """The comparison of an adjustment with control that it did not use.

    point          (c,) int64, the points that could be compared
    difference     (c, 3) m, adjusted minus given
    squared_error  (c,) squared differences in sigmas of both together; the expectation is 3
    missing        number of points that were left out but not adjusted, because too few photos see them
    """

    point: Int
    difference: Float
    squared_error: Float
    missing: int

    @property
    def rmse(self) -> Float:
        """Root mean square difference (3,) m along the axes of the local frame."""
        return np.sqrt((self.difference**2).mean(axis=0)) if len(self.point) else np.full(3, np.nan)

    @property
    def normalised(self) -> float:
        """The mean squared error over its expectation: 1 when the standard errors are right."""
        return float(self.squared_error.mean() / 3.0) if len(self.point) else float("nan")


def split_control(network: Network, share: float, seed: int) -> tuple[Network, PointObservations]:
    """Leaves out the given `share` of the control points, drawn at random.

    Control points are the points with three rows or more, and points that two photos or more see; others
    could not be checked. Returns the network without their rows, and these rows.
    """
    rows = np.bincount(network.surfaces.point, minlength=len(network.points))
    rays = np.bincount(network.images.point, minlength=len(network.points))
    control = np.flatnonzero((rows >= 3) & (rays >= 2))
    count = round(share * len(control))
    drawn = np.random.default_rng(seed).choice(control, count, replace=False)
    out = np.isin(network.surfaces.point, drawn)
    return replace(network, surfaces=network.surfaces.take(~out)), network.surfaces.take(out)


def check_points(adjustment: Adjustment, left_out: PointObservations) -> CheckPoints:
    """Compares an adjustment with the control rows that were left out of it (see `split_control`)."""
    points, index = np.unique(left_out.point, return_inverse=True)
    weight = left_out.sigma**-2.0
    normal = np.zeros((len(points), 3, 3))
    right = np.zeros((len(points), 3))
    outer = left_out.direction[:, :, None] * left_out.direction[:, None, :]
    np.add.at(normal, index, outer * weight[:, None, None])
    np.add.at(right, index, np.einsum("kij,kj->ki", outer, left_out.at) * weight[:, None])
    found = adjustment.determined[points]
    points, covariance = points[found], np.linalg.inv(normal[found])
    difference = adjustment.points[points] - np.einsum("cij,cj->ci", covariance, right[found])
    total = adjustment.point_covariance[points] + covariance
    squared = np.einsum("ci,ci->c", difference, np.linalg.solve(total, difference[:, :, None])[:, :, 0])
    return CheckPoints(points, difference, squared, int((~found).sum()))
