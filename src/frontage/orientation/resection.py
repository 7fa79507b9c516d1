"""Resection in closed form within RANSAC: the pose of one photo from points of the scan.

Without further knowledge three points give up to four poses (P3P, Grunert 1841). Where the direction of the
plumb line in the camera is known, two points are enough: with the camera's frame levelled, the heading
(c, s) and the position t satisfy ``r x (Rz X + t) = 0`` for the ray r of each point X, which is linear in c,
s and t; eliminating t leaves one equation ``a c + b s + d = 0`` on the unit circle (compare Kukelova, Bujnak
and Pajdla 2010).
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.model import Camera
from frontage.solve.ransac import lo_ransac

_LEAST = 6  # points that must agree
_STEPS = 8  # of the refinement
_MOST = 20_000  # hypotheses


@dataclass(frozen=True, eq=False)
class Resection:
    """The pose local_from_camera of a photo, which points (n,) agree with it, how many poses were tried."""

    pose: Rigid3
    inliers: Bool
    hypotheses: int


def resect(
    camera: Camera,
    pixels: Float,
    xyz: Float,
    threshold: float,
    *,
    up: Float | None = None,
    seed: int = 0,
) -> Resection | None:
    """Finds the pose of a camera from pixels (n, 2) of points (n, 3) m, some of which are wrong.

    threshold  px, of points that agree
    up         (3,) direction of the plumb line in the camera's frame, upwards, where it is known

    Returns None when no pose has six agreeing points.
    """
    rays = camera.ray(pixels)
    usable = np.flatnonzero(np.isfinite(rays).all(1) & (rays[:, 2] > 0.05))
    if len(usable) < _LEAST:
        return None
    focal = float(camera.params[0])
    problem = _Problem(rays[usable], np.asarray(xyz[usable], np.float64), up)
    found = lo_ransac(
        problem, threshold / focal, np.random.default_rng(seed), max_hypotheses=_MOST, confidence=0.9999
    )
    if found is None or found.inliers.sum() < _LEAST:
        return None
    inliers = np.zeros(len(pixels), np.bool_)
    inliers[usable[found.inliers]] = True
    R, t = _unpacked(found.model[None])
    return Resection(Rigid3("camera", "local", R[0], t[0]).inverse, inliers, found.hypotheses)


class _Problem:
    """Rays (n, 3) of points (n, 3) as an estimator for RANSAC; a model is camera_from_local as 12 numbers."""

    def __init__(self, rays: Float, xyz: Float, up: Float | None) -> None:
        self._rays, self._xyz = rays, xyz
        self._xy = rays[:, :2] / rays[:, 2:]
        self._level = None if up is None else _levelling(up)
        self.sample_size = 3 if up is None else 2

    def __len__(self) -> int:
        return len(self._xyz)

    def draw(self, rng: np.random.Generator, count: int) -> Int:
        """Draws samples of distinct points."""
        rows = rng.integers(0, len(self), (count, self.sample_size))
        ordered = np.sort(rows, axis=1)
        return rows[(np.diff(ordered, axis=1) > 0).all(1)].astype(np.int64)

    def minimal(self, samples: Int) -> Float:
        """Poses (j, 12) through the samples."""
        if self._level is None:
            return self._three_points(samples)
        return self._two_points(samples)

    def residuals(self, models: Float, rows: Int | slice) -> Array:
        """Distances (j, r) in the image plane at focal length 1; large behind the camera."""
        R, t = _unpacked(models)
        at = np.einsum("jab,rb->jra", R, self._xyz[rows]) + t[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            off = at[..., :2] / at[..., 2:] - self._xy[rows]
        distance = np.sqrt((off**2).sum(-1))
        return np.asarray(np.where((at[..., 2] > 0) & np.isfinite(distance), distance, 1e3), np.float32)

    def fit(self, rows: Int, weights: Float) -> Float | None:
        """Least squares on many points, starting from the best pose through three of them."""
        if len(rows) < _LEAST:
            return None
        K, none = np.eye(3), np.zeros(4)
        try:
            done, w, t = cv2.solvePnP(self._xyz[rows], self._xy[rows], K, none, flags=cv2.SOLVEPNP_SQPNP)
            if not done:
                return None
            w, t = cv2.solvePnPRefineLM(self._xyz[rows], self._xy[rows], K, none, w, t)
        except cv2.error:  # points almost on one another
            return None
        model = np.concatenate([cv2.Rodrigues(w)[0].ravel(), t.ravel()])
        return model if np.isfinite(model).all() else None

    def _three_points(self, samples: Int) -> Float:
        models = []
        for rows in samples:
            count, turns, shifts = cv2.solveP3P(
                self._xyz[rows], self._xy[rows], np.eye(3), np.zeros(4), flags=cv2.SOLVEPNP_P3P
            )
            models += [
                np.concatenate([cv2.Rodrigues(turns[k])[0].ravel(), shifts[k].ravel()]) for k in range(count)
            ]
        found = np.array(models).reshape(-1, 12)
        return np.asarray(found[np.isfinite(found).all(1)])

    def _two_points(self, samples: Int) -> Float:
        level = self._level
        assert level is not None
        ray = self._rays[samples] @ level.T  # (k, 2, 3), z up
        X = self._xyz[samples]
        # r x (Rz X + t) = 0; two of the three rows, with r scaled to its largest horizontal part.
        cs, shift, rest = _rows(ray, X)
        left = np.linalg.svd(shift)[0][:, :, 3]  # (k, 4), orthogonal to the columns of t
        a, b = (np.einsum("ki,ki->k", left, cs[:, :, j]) for j in (0, 1))
        d = np.einsum("ki,ki->k", left, rest)
        radius = np.hypot(a, b)
        with np.errstate(divide="ignore", invalid="ignore"):
            spread = np.arccos(-d / radius)
        models = []
        for side in (1.0, -1.0):
            angle = np.arctan2(b, a) + side * spread
            models.append(_poses(angle, cs, shift, rest, ray, level, X))
        found = np.concatenate(models)
        return np.asarray(found[np.isfinite(found).all(1)])


def _rows(ray: Float, X: Float) -> tuple[Float, Float, Float]:
    """Four equations of two points: coefficients of (c, s) (k, 4, 2), of t (k, 4, 3), constants (k, 4)."""
    zero = np.zeros(ray.shape[:2])
    x, y, z = (ray[..., i] for i in range(3))
    px, py, pz = (X[..., i] for i in range(3))
    # Rz X = (c px - s py, s px + c py, pz); the cross product with r, rows x and y, and row z instead of the
    # weaker of them is not needed: two rows are independent as long as r is not horizontal and level at once.
    first = np.stack([-z * py, -z * px], -1), np.stack([zero, -z, y], -1), y * pz
    second = np.stack([z * px, -z * py], -1), np.stack([z, zero, -x], -1), -x * pz
    third = np.stack([x * py - y * px, x * px + y * py], -1), np.stack([-y, x, zero], -1), zero
    use_third = np.abs(z) < 0.3
    wide = np.abs(x) > np.abs(y)
    parts = []
    for a, b, c in zip(first, second, third, strict=True):
        extra = use_third if a.ndim == 2 else use_third[..., None]
        choose = wide if a.ndim == 2 else wide[..., None]
        # Near the horizon rows x and y are nearly parallel: the third row and the larger of them are used.
        parts.append((np.where(extra, c, a), np.where(extra, np.where(choose, b, a), b)))
    merged = [np.concatenate(pair, axis=1) for pair in parts]
    return merged[0], merged[1], merged[2]


def _poses(angle: Float, cs: Float, shift: Float, rest: Float, ray: Float, level: Float, X: Float) -> Float:
    """Models (k, 12) of headings (k,); NaN where the points would lie behind the camera."""
    c, s = np.cos(angle), np.sin(angle)
    right = -(cs @ np.stack([c, s], -1)[..., None])[..., 0] - rest
    with np.errstate(invalid="ignore"):
        finite = np.isfinite(right).all(1)
    t = np.full((len(angle), 3), np.nan)
    if finite.any():
        t[finite] = (np.linalg.pinv(shift[finite]) @ right[finite, :, None])[..., 0]
    R = np.zeros((len(angle), 3, 3))
    R[:, 0, 0], R[:, 0, 1], R[:, 1, 0], R[:, 1, 1], R[:, 2, 2] = c, -s, s, c, 1.0
    at = np.einsum("kab,kib->kia", R, X) + t[:, None]
    ahead = ((at * ray).sum(-1) > 0).all(1)
    back = level.T
    R = back @ R
    t = np.where(ahead[:, None], t @ back.T, np.nan)
    return np.concatenate([R.reshape(-1, 9), t], axis=1)


def _levelling(up: Float) -> Float:
    """The rotation (3, 3) that takes the plumb line, given in the camera's frame, to the third axis."""
    z = up / np.linalg.norm(up)
    other = np.eye(3)[int(np.abs(z).argmin())]
    x = np.cross(other, z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z])


def _unpacked(models: Float) -> tuple[Float, Float]:
    return models[:, :9].reshape(-1, 3, 3), models[:, 9:]
