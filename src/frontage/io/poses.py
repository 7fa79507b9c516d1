"""Poses from files, with the uncertainty that the user states for them."""

import numpy as np

from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Provenance


def given_pose(pose: Rigid3, sigmas: tuple[float, ...] | None = None) -> Estimate[Rigid3]:
    """A pose taken from a file: exact, or with six sigmas (translation m, then rotation rad)."""
    covariance = np.zeros((6, 6)) if sigmas is None else np.diag(np.square(sigmas))
    return Estimate(pose, covariance, 0.0, Provenance.GIVEN)


def nearest_rotation(R: np.ndarray, tolerance: float = 5e-3) -> np.ndarray:
    """The rotation nearest to a matrix (3, 3) that was printed with few digits.

    Raises ValueError when an element differs by more than `tolerance`: the matrix is scaled, mirrored or
    damaged.
    """
    U, _, Vt = np.linalg.svd(R)
    nearest: np.ndarray = U @ Vt
    if np.abs(nearest - R).max() > tolerance or np.linalg.det(nearest) < 0:
        raise ValueError("its pose matrix is not a rotation (it is scaled, mirrored or damaged)")
    return nearest
