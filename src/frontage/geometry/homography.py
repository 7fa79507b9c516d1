"""The homography from a facade raster to a photograph (paper A, section 3.1).

`H` maps homogeneous facade pixels ``(column, row, 1)`` to image pixels. From a known pose it is exact for an
undistorted pinhole camera; from point pairs it is the linear system of the paper, solved with
Hartley's normalisation (In defence of the eight-point algorithm, PAMI 19(6), 1997), without which the columns
of the system differ by a factor of 10^6 at the resolution of photos.
"""

import numpy as np

from frontage.errors import InputError
from frontage.geometry.arrays import Float


def homography_from_pose(K: Float, R: Float, t: Float, facade_from_raster: Float) -> Float:
    """Returns ``H = K [R e_x, R e_z, t] A`` of the plane y = 0 seen by a camera, scaled to ``H[2, 2] = 1``.

    K (3, 3); camera_from_facade R (3, 3), t (3,) m (hence ``t = R_c (o - C)`` with the origin o of the facade
    and the centre C of the camera); facade_from_raster A (3, 3) takes ``(column, row, 1)`` to ``(x, z, 1)``
    in metres.
    """
    H = K @ np.column_stack([R[:, 0], R[:, 2], t]) @ facade_from_raster
    scaled: Float = H / H[2, 2]
    return scaled


def homography_from_pairs(source: Float, target: Float) -> Float:
    """Fits a homography (3, 3), H[2, 2] = 1, to n >= 4 pairs (n, 2) by least squares (paper A, eq. 5-7).

    The system has the rows ``[u v 1 0 0 0 -u'u -u'v]`` and ``[0 0 0 u v 1 -v'u -v'v]`` and is solved by its
    pseudo-inverse, in coordinates with zero mean and a mean distance of sqrt 2.

    Raises InputError (I311) for fewer than four pairs, or when they do not determine a homography (three of
    them on a line).
    """
    source, target = np.asarray(source, np.float64), np.asarray(target, np.float64)
    if len(source) != len(target) or len(source) < 4:
        raise InputError(
            f"a homography needs at least 4 point pairs, got {len(source)} and {len(target)}", code="I311"
        )
    S, T = _normaliser(source), _normaliser(target)
    (u, v), (up, vp) = apply_homography(S, source).T, apply_homography(T, target).T
    one, nil = np.ones_like(u), np.zeros_like(u)
    A = np.concatenate(
        [
            np.column_stack([u, v, one, nil, nil, nil, -up * u, -up * v]),
            np.column_stack([nil, nil, nil, u, v, one, -vp * u, -vp * v]),
        ]
    )
    h, _, rank, _ = np.linalg.lstsq(A, np.concatenate([up, vp]), rcond=1e-10)
    if rank < 8:
        raise InputError(
            "the point pairs do not determine a homography; spread them so that no three lie on a line",
            code="I311",
        )
    H = np.linalg.inv(T) @ np.append(h, 1.0).reshape(3, 3) @ S
    scaled: Float = H / H[2, 2]
    return scaled


def apply_homography(H: Float, xy: Float) -> Float:
    """Maps points (n, 2) by H (3, 3) (paper A, eq. 6); NaN where they go to infinity or change sides."""
    w = xy @ H[2, :2] + H[2, 2]
    mapped: Float = (xy @ H[:2, :2].T + H[:2, 2]) / np.where(w > 0, w, np.nan)[:, None]
    return mapped


def _normaliser(xy: Float) -> Float:
    """Returns the similarity (3, 3) that moves points (n, 2) to zero mean and a mean distance of sqrt 2."""
    mean = xy.mean(0)
    size = np.linalg.norm(xy - mean, axis=1).mean()
    scale = np.sqrt(2.0) / size if size > 0 else 1.0
    return np.array([[scale, 0, -scale * mean[0]], [0, scale, -scale * mean[1]], [0, 0, 1.0]])
