"""Rigid motions between named frames, and the exponential map of rotations.

Tangent order everywhere: translation (m) first, then rotation (rad), left perturbation in the `to`
frame: ``T(xi) = (exp(w) R, t + v)`` with ``xi = (v, w)``.
"""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from frontage.geometry.arrays import Float, readonly

_UNIT = np.eye(3)
_SLACK = 1e-6 + 1e-5 * _UNIT


@dataclass(frozen=True, eq=False)
class Rigid3:
    """A rigid motion ``x_to = R x_frm + t`` that knows the frames it connects.

    Variables are named ``to_from_frm``, so that neighbours match in ``camera_from_local @
    local_from_facade``. R (3, 3) is a rotation (checked to 1e-6), t (3,) is in metres.

    Raises ValueError when R is not a rotation, and for a product of motions whose frames do not meet.
    """

    to: str
    frm: str
    R: Float
    t: Float

    def __post_init__(self) -> None:
        R = readonly(self.R, (3, 3), np.float64, "R")
        if not (np.abs(R @ R.T - _UNIT) <= _SLACK).all() or np.linalg.det(R) < 0:
            raise ValueError(f"{self.to}_from_{self.frm}: R is not a rotation")
        object.__setattr__(self, "R", R)
        object.__setattr__(self, "t", readonly(self.t, (3,), np.float64, "t"))

    def __matmul__(self, other: "Rigid3") -> "Rigid3":
        if self.frm != other.to:
            raise ValueError(f"{self.to}_from_{self.frm} @ {other.to}_from_{other.frm}: frames do not meet")
        return self.after(other)

    def after(self, other: "Rigid3") -> "Rigid3":
        """Applies `other` first and then this motion, a correction within the frame that `other` leads to.

        It is the product ``@`` without its check, since `frm` and `to` of a correction are the same frame.
        """
        return Rigid3(self.to, other.frm, self.R @ other.R, self.R @ other.t + self.t)

    @property
    def inverse(self) -> "Rigid3":
        """The inverse motion, ``frm_from_to``."""
        return Rigid3(self.frm, self.to, self.R.T, -self.R.T @ self.t)

    @property
    def matrix(self) -> Float:
        """The homogeneous (4, 4) matrix."""
        M = np.eye(4)
        M[:3, :3], M[:3, 3] = self.R, self.t
        return M

    @cached_property
    def _rows(self) -> Float:
        """The upper three rows (3, 4) of the matrix."""
        return np.column_stack([self.R, self.t])

    def apply(self, xyz: Float) -> Float:
        """Transforms points (n, 3) from frame `frm` to frame `to`."""
        points = np.ascontiguousarray(xyz, np.float64)
        if points.size == 0:
            return points
        # One pass over the memory; a BLAS product of n x 3 by 3 x 3 takes three and starts threads that wait.
        moved: Float = cv2.transform(points.reshape(-1, 1, 3), self._rows)
        return moved.reshape(points.shape)

    def rotate(self, directions: Float) -> Float:
        """Rotates directions (n, 3) without translating them."""
        return np.asarray(directions, np.float64) @ self.R.T

    @staticmethod
    def identity(to: str, frm: str) -> "Rigid3":
        """Returns the motion that only renames a frame."""
        return Rigid3(to, frm, np.eye(3), np.zeros(3))


def rotation_from_quaternion(wxyz: Float) -> Float:
    """Returns the rotation (3, 3) of a quaternion (w, x, y, z) of any length; the order of COLMAP and E57."""
    w, x, y, z = np.asarray(wxyz, np.float64) / np.linalg.norm(wxyz)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_from_rotation(R: Float) -> Float:
    """Returns the unit quaternion (w, x, y, z), w >= 0, of a rotation (3, 3).

    It is an eigenvector of Bar-Itzhack's symmetric matrix (2000), which is stable for every angle.
    """
    K = np.array(
        [
            [R[0, 0] - R[1, 1] - R[2, 2], R[1, 0] + R[0, 1], R[2, 0] + R[0, 2], R[2, 1] - R[1, 2]],
            [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], R[2, 1] + R[1, 2], R[0, 2] - R[2, 0]],
            [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], R[1, 0] - R[0, 1]],
            [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R[0, 0] + R[1, 1] + R[2, 2]],
        ]
    )
    x, y, z, w = np.linalg.eigh(K)[1][:, -1]
    q = np.array([w, x, y, z])
    return q if w >= 0 else -q


def rotation_angle(R: Float) -> float:
    """Returns the angle, 0..pi rad, of a rotation (3, 3); exact for small angles too."""
    sine = float(np.linalg.norm([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2)
    return float(np.arctan2(sine, (np.trace(R) - 1) / 2))


def skew(v: Float) -> Float:
    """Returns the matrix (3, 3) of the cross product: ``skew(v) @ u = v x u``."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
