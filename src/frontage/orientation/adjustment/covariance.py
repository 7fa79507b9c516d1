"""The inverse of the normal equations: marginal covariances, and the redundancy of every observation.

With ``Q = S^-1`` and ``Z = V^-1 W`` per point, the marginal covariance of a point is ``V^-1 + Z Q Z^T`` (its
uncertainty with the cameras known, plus what the cameras add), and between point and columns ``-Z Q``.
"""

from dataclasses import dataclass

import numpy as np

from frontage.errors import FrontageError
from frontage.geometry.arrays import Bool, Float
from frontage.orientation.adjustment.datum import Datum
from frontage.orientation.adjustment.layout import Chunk, Layout
from frontage.orientation.adjustment.linearise import Linearised
from frontage.orientation.adjustment.normal import NormalEquations, inverse_blocks

_SINGULAR = 1e-12  # least eigenvalue of the scaled reduced equations; rounding errors are below 1e-14
_SHARE = 0.1  # of the largest part in a direction that is not determined, from which a body is named
_POINT_SINGULAR = 1e-10  # ratio of the eigenvalues of a point's block: rays that meet at less than 1e-5 rad
_LEAST_PARALLAX = 4.0  # standard errors: of the parallax of the rays that meet in a point


class NotDetermined(FrontageError):
    """The observations do not determine some bodies, cameras or mounts, whose numbers it carries."""

    code = "O100"

    def __init__(
        self, bodies: tuple[int, ...], cameras: tuple[int, ...], mounts: tuple[int, ...] = ()
    ) -> None:
        self.bodies, self.cameras, self.mounts = bodies, cameras, mounts
        parts = [
            f"{what} {_listed(numbers)}"
            for what, numbers in (("bodies", bodies), ("cameras", cameras), ("mounts", mounts))
            if numbers
        ]
        super().__init__(
            f"the observations do not determine {' and '.join(parts)}; add image points, control or priors, "
            "or hold camera parameters fixed"
        )


def _listed(numbers: tuple[int, ...]) -> str:
    return ", ".join(map(str, numbers[:10])) + (f" and {len(numbers) - 10} more" if len(numbers) > 10 else "")


@dataclass(frozen=True, eq=False)
class Precision:
    """Covariances and redundancies at the end of a minimisation, in the units of the weights.

    wide      (u, u) joint covariance of bodies, camera parameters and mounts
    points    (a, 3, 3) marginal covariances of the active points
    images    (m_a, 2, 2) redundancy matrices of the active image rows: covariance of the residuals in sigmas
    surfaces  (k_a,) redundancies
    priors    (b,) sum over the rows of each prior; `cameras` (f,) of the priors of camera parameters
    mounts    redundancy of the priors of all mounts together
    """

    wide: Float
    points: Float
    images: Float
    surfaces: Float
    priors: Float
    cameras: Float
    mounts: float


def degenerate_points(V: Float, reach: Float) -> Bool:
    """Which points (a,) are not determined, from their blocks (a, 3, 3) and the distance (a,) m of a camera.

    Either a block is numerically singular, or the parallax of the rays is not significant: the distance is
    known to no better than a quarter of itself. Such a point is not near any minimum, it walks off to
    infinity, and what it would give the poses is biased.
    """
    values = np.linalg.eigvalsh(V)
    singular = values[:, 0] <= _POINT_SINGULAR * values[:, 2]
    return np.asarray(singular | (values[:, 0] * reach**2 < _LEAST_PARALLAX**2))


def precision(equations: NormalEquations, datum: Datum) -> Precision:
    """Inverts the normal equations. Raises NotDetermined with the bodies and cameras that are not."""
    inverse_points = inverse_blocks(equations.V)
    S, _ = equations.reduce(inverse_points, equations.U)
    wide = _inverse(S, equations, datum)
    layout, rows = equations.layout, equations.rows
    points = np.empty_like(equations.V)
    along = np.empty((len(layout.rows), 3, layout.width))
    for chunk, W in equations.between():
        Z = inverse_points[chunk.points] @ W
        inner = wide[np.ix_(chunk.columns, chunk.columns)]
        across = (Z.reshape(3 * chunk.size, len(chunk.columns)) @ inner).reshape(Z.shape)
        points[chunk.points] = inverse_points[chunk.points] + across @ Z.transpose(0, 2, 1)
        along[chunk.rows] = _own_columns(layout, chunk, across)
    images = np.eye(2) - image_variance(layout, rows, wide, points, along)
    spread = np.einsum("ki,kij,kj->k", rows.surface, points[layout.surface_slot], rows.surface)
    priors = np.zeros(layout.bodies)
    for body, prior in enumerate(rows.priors):
        if prior is not None:
            block = wide[6 * body : 6 * body + 6, 6 * body : 6 * body + 6]
            priors[body] = len(prior[1]) - np.einsum("ri,ij,rj->", prior[0], block, prior[0])
    cameras = (rows.cameras > 0) - rows.cameras**2 * np.diag(wide)[layout.all_cameras]
    spanned = rows.mounts @ wide[layout.all_mounts, layout.all_mounts] @ rows.mounts.T
    mounts = float(len(rows.mount_miss) - np.trace(spanned))
    return Precision(wide, points, images, 1.0 - spread, priors, cameras, mounts)


def _own_columns(layout: Layout, chunk: Chunk, across: Float) -> Float:
    """From (g, 3, c) of a chunk, the columns (r, 3, k) of the photo of every row."""
    padded = np.concatenate([across, np.zeros((*across.shape[:2], 1))], axis=2)
    slot = layout.slot[chunk.rows] - chunk.points.start
    return np.asarray(padded[slot[:, None, None], np.arange(3)[:, None], chunk.local[:, None, :]], np.float64)


def image_variance(layout: Layout, rows: Linearised, wide: Float, points: Float, along: Float) -> Float:
    """The covariance (m_a, 2, 2) of the adjusted image points in sigmas."""
    padded = np.zeros((layout.columns + 1, layout.columns + 1))
    padded[:-1, :-1] = wide
    turned = np.empty_like(rows.wide)
    for columns, mine in zip(layout.photo_columns, layout.rows_of_photo, strict=True):
        turned[mine] = rows.wide[mine] @ padded[np.ix_(columns, columns)]
    # The covariance of point and columns is -`along`: it enters twice, once transposed.
    mixed = (rows.wide @ along.transpose(0, 2, 1)) @ rows.point.transpose(0, 2, 1)
    own = (rows.point @ points[layout.slot]) @ rows.point.transpose(0, 2, 1)
    return np.asarray(
        turned @ rows.wide.transpose(0, 2, 1) + own - mixed - mixed.transpose(0, 2, 1), np.float64
    )


def _inverse(S: Float, equations: NormalEquations, datum: Datum) -> Float:
    """The inverse (u, u) of S under the constraints of the datum."""
    diagonal = np.diag(equations.U)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    held, free = np.linalg.qr(datum.constraints * scale[:, None])[0], datum.freedoms / scale[:, None]
    values, vectors = np.linalg.eigh(S * scale[:, None] * scale + held @ held.T)
    weak = values <= _SINGULAR
    if weak.any():
        raise _not_determined(equations.layout, np.abs(vectors[:, weak]).max(axis=1))
    inverse = (vectors / values) @ vectors.T
    if datum.defect:
        # The constraints add N (C^T N)^-1 (N^T C)^-1 N^T, which is no part of the covariance.
        drift = free @ np.linalg.inv(held.T @ free)
        inverse -= drift @ drift.T
    return np.asarray(inverse * scale[:, None] * scale, np.float64)


def _not_determined(layout: Layout, part: Float) -> NotDetermined:
    """Names the bodies, cameras and mounts with a large `part` (u,) in directions that are not determined."""
    large = part >= _SHARE * part.max()
    bodies = large[: 6 * layout.bodies].reshape(-1, 6).any(axis=1)
    cameras = [i for i in range(len(layout.free)) if large[layout.camera_columns(i)].any()]
    mounts = [i for i in range(len(layout.mounted)) if large[layout.mount_columns(i)].any()]
    return NotDetermined(tuple(np.flatnonzero(bodies).tolist()), tuple(cameras), tuple(mounts))
