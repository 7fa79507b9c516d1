"""The result of a bundle adjustment."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int, freeze
from frontage.geometry.rigid import Rigid3, skew
from frontage.model.estimate import Estimate
from frontage.model.photo import Camera
from frontage.orientation.adjustment.network import Photos


@dataclass(frozen=True, eq=False)
class Adjustment:
    """What a bundle adjustment found. Covariances use the estimated variances of the groups (`factors`).

    poses              local_from_body per body with its marginal covariance (6, 6), m and rad
    cameras            adjusted cameras; their covariances (k, k) are zero where a parameter was held fixed
    mounts             body_from_camera per mount; their covariances (6, 6) are zero where held fixed
    photos             the photos of the network
    points             (n, 3) m; points that were dropped keep their approximate values
    point_covariance   (n, 3, 3) m2, marginal; NaN for dropped points
    determined         (n,) bool, which points were adjusted
    covariance         (u, u) joint covariance: six columns per body, then the estimated
                       parameters of the cameras, then those of the mounts
    residuals          (m, 2) px, adjusted minus measured, of all image observations; NaN where not seen
    surface_residuals  (k,) m
    used               (m,) bool, `surface_used` (k,) bool
    rejected           (m,) bool, failed the test or lay far outside; `surface_rejected` (k,) bool
    redundancy         (m, 2), `surface_redundancy` (k,): share of an error of the observation that shows in
                       its own residual, 0 .. 1; NaN where not used
    prior_redundancy   (b,) sum over the rows of each pose prior; `camera_redundancy` (f,) per estimated
                       camera parameter, zero without a prior; `mount_redundancy` of all priors of mounts
    detectable_bias    (m, 2) px, `surface_detectable_bias` (k,) m: least error found in 80 of 100 cases
    factors            (g,) variance components, by which the stated variances were multiplied
    group_redundancy   (g,) redundancy behind each of them
    sigma0             standard deviation of unit weight that remains, near 1 when the weights are right
    dof                redundancy: observations minus unknowns plus datum defect
    datum_defect       0 .. 7 freedoms that no control fixes; inner constraints on the poses remove them
    unseen             number of image observations whose points their cameras cannot see
    dropped            number of observed points left out because too few rays or rows determine them
    iterations         steps of all minimisations; `rounds` of tests and variance estimation
    reason             why the last minimisation stopped
    cost               weighted sum of squares
    """

    poses: tuple[Estimate[Rigid3], ...]
    cameras: tuple[Estimate[Camera], ...]
    mounts: tuple[Estimate[Rigid3], ...]
    photos: Photos
    points: Float
    point_covariance: Float
    determined: Bool
    covariance: Float
    residuals: Float
    surface_residuals: Float
    used: Bool
    surface_used: Bool
    rejected: Bool
    surface_rejected: Bool
    redundancy: Float
    surface_redundancy: Float
    prior_redundancy: Float
    camera_redundancy: Float
    mount_redundancy: float
    detectable_bias: Float
    surface_detectable_bias: Float
    factors: Float
    group_redundancy: Float
    sigma0: float
    dof: int
    datum_defect: int
    unseen: int
    dropped: int
    iterations: int
    rounds: int
    reason: str
    cost: float

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray):
                freeze(self, **{name: (value.shape, value.dtype)})

    @property
    def poses_covariance(self) -> Float:
        """The joint covariance (6 b, 6 b) of all bodies."""
        size = 6 * len(self.poses)
        return np.asarray(self.covariance[:size, :size], np.float64)

    @property
    def sigma_points(self) -> Float:
        """Standard errors (n, 3) m of the points."""
        return np.asarray(np.sqrt(np.einsum("nii->ni", self.point_covariance)), np.float64)

    def photo_pose(self, photo: int) -> Estimate[Rigid3]:
        """The pose local_from_camera of a photo with its covariance (6, 6)."""
        number, on = int(self.photos.body[photo]), int(self.photos.mount[photo])
        body, mounted = self.poses[number], self.mounts[on].value
        # The camera is carried along at the end of its lever arm when the body turns.
        carried = np.eye(6)
        carried[:3, 3:] = -skew(body.value.rotate(mounted.t[None])[0])
        turned = np.kron(np.eye(2), body.value.R)
        own = np.diag(self.mounts[on].covariance) > 0
        both = np.hstack([carried, turned[:, own]])
        columns = np.concatenate([6 * number + np.arange(6), self._mount_columns(on)])
        covariance = both @ self.covariance[np.ix_(columns, columns)] @ both.T
        return Estimate(body.value.after(mounted), covariance, body.dof, body.provenance)

    def _mount_columns(self, mount: int) -> Int:
        """The columns of the estimated parameters of a mount; those of all mounts are the last."""
        width = [int((np.diag(m.covariance) > 0).sum()) for m in self.mounts]
        start = len(self.covariance) - sum(width[mount:])
        return start + np.arange(width[mount])

    def focal_depth_correlation(self) -> Float:
        """Correlation (p,) of the focal length with the position of each photo along its axis.

        NaN where the focal length was held fixed. Values near 1 tell that the two cannot be separated.
        """
        columns = self._focal_columns()
        result = np.full(len(self.photos), np.nan)
        for photo, camera in enumerate(self.photos.camera):
            column = columns[camera]
            if column >= 0:
                result[photo] = self._axial_correlation(photo, int(column))
        return result

    def _axial_correlation(self, photo: int, column: int) -> float:
        body = int(self.photos.body[photo])
        axis = (self.poses[body].value.R @ self.mounts[self.photos.mount[photo]].value.R)[:, 2]
        block = slice(6 * body, 6 * body + 3)
        variance = axis @ self.covariance[block, block] @ axis * self.covariance[column, column]
        return float(axis @ self.covariance[block, column] / np.sqrt(variance))

    def _focal_columns(self) -> Array:
        """The column of the first parameter of every camera, -1 where it was held fixed."""
        estimated = [np.diag(c.covariance) > 0 for c in self.cameras]
        start = np.cumsum([6 * len(self.poses), *(e.sum() for e in estimated)])[:-1]
        return np.where([e[0] for e in estimated], start, -1)
