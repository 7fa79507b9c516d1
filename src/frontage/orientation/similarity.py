"""Fits the similarity that takes a block into the scan to control points of all its photos at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from frontage.geometry.arrays import Bool, Float
from frontage.model import Photo
from frontage.orientation.control import ControlPoints
from frontage.orientation.drawnwall import Similarity
from frontage.solve.robust import mad_sigma, tukey_weights, weighted_fit

_STEPS = 30
_DELTA = 1e-6
_FLOOR_PX = 0.5


@dataclass(frozen=True, eq=False)
class FittedSimilarity:
    """A similarity, which control points (per photo) agree with it, and their robust spread in px."""

    similarity: Similarity
    inliers: tuple[Bool, ...]
    sigma: float

    @property
    def count(self) -> int:
        """The number of control points that agree."""
        return int(sum(own.sum() for own in self.inliers))


def fit_similarity(
    photos: Sequence[Photo], control: Sequence[ControlPoints], start: Similarity
) -> FittedSimilarity:
    """Improves a similarity by robust least squares (Tukey's biweight with a shrinking scale).

    `photos` have the poses of the block, `control` belongs to them in this order.
    """
    centre = start.apply(np.array([p.pose.t for p in photos])).mean(0)
    now = start
    errors = residuals(photos, control, now)
    sigma = _spread(errors)
    for _ in range(_STEPS):
        stacked = np.concatenate(errors)
        weight = tukey_weights(np.nan_to_num(np.linalg.norm(stacked, axis=1), nan=1e9), 1.5 * sigma)
        J = _jacobian(photos, control, now, centre, stacked)
        good = np.isfinite(J).all((1, 2)) & (weight > 0)
        if good.sum() < 8:
            break
        W = np.repeat(weight[good], 2)
        A, b = J[good].reshape(-1, 7), stacked[good].ravel()
        step = -weighted_fit(A, b, W)
        now = moved(now, step, centre)
        errors = residuals(photos, control, now)
        new = max(_FLOOR_PX, min(sigma, 1.1 * _spread(errors)))
        if np.abs(step).max() < 1e-7 and abs(new - sigma) < 1e-3:
            break
        sigma = new
    inliers = tuple(np.linalg.norm(np.nan_to_num(e, nan=1e9), axis=1) < 3.0 * sigma for e in errors)
    return FittedSimilarity(now, inliers, sigma)


def residuals(
    photos: Sequence[Photo], control: Sequence[ControlPoints], similarity: Similarity
) -> list[Float]:
    """Returns computed minus measured pixels (n, 2) of every photo; NaN for what it cannot see."""
    out = []
    for photo, points in zip(photos, control, strict=True):
        pose = similarity.pose(photo.pose)
        out.append(photo.camera.project(pose.inverse.apply(points.xyz)) - points.pixels)
    return out


def moved(similarity: Similarity, step: Float, centre: Float) -> Similarity:
    """Returns the similarity followed by a shift (m), a small rotation (rad) about `centre`, and log size."""
    turn = Rotation.from_rotvec(step[3:6]).as_matrix()
    size = float(np.exp(step[6]))
    t = size * turn @ (similarity.t - centre) + centre + step[:3]
    return Similarity(similarity.scale * size, turn @ similarity.R, t)


def _jacobian(
    photos: Sequence[Photo],
    control: Sequence[ControlPoints],
    now: Similarity,
    centre: Float,
    errors: Float,
) -> Float:
    columns = []
    for k in range(7):
        step = np.zeros(7)
        step[k] = _DELTA
        columns.append(
            (np.concatenate(residuals(photos, control, moved(now, step, centre))) - errors) / _DELTA
        )
    return np.stack(columns, axis=-1)


def _spread(errors: Sequence[Float]) -> float:
    """Robust sigma (px) of all residuals about zero, of the better half where outliers prevail."""
    flat = np.abs(np.concatenate(errors).ravel())
    flat = flat[np.isfinite(flat)]
    if not len(flat):
        return _FLOOR_PX
    return max(_FLOOR_PX, mad_sigma(np.concatenate([flat, -flat])))
