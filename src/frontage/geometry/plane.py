"""Planes and the facade frame's axes (paper A, section 2.2)."""

import numpy as np

from frontage.geometry.arrays import Float


def facade_axes(inward: Float) -> Float:
    """Returns the axes X, Y, Z of a facade frame as the columns of a rotation (3, 3), from its inward normal.

    These are paper A's eq. 1-4 with the azimuth phi and the zenith angle psi of the normal: ``X = (sin phi,
    -cos phi, 0)`` is horizontal and points to the right as seen from the street, ``Y`` is the unit normal
    into the building, and ``Z = X x Y`` points up in the plane. `inward` (3,) need not have unit length.

    Raises ValueError when the plane is horizontal, so that X is not defined, or `inward` is not finite.
    """
    n = np.asarray(inward, np.float64)
    length, plan = float(np.linalg.norm(n)), float(np.hypot(n[0], n[1]))
    if not np.isfinite(length) or plan < 1e-6 * length or length == 0.0:
        raise ValueError("a facade's plane must have a finite normal and must not be horizontal")
    y = n / length
    x = np.array([y[1], -y[0], 0.0]) / float(np.hypot(y[0], y[1]))
    return np.column_stack([x, y, np.cross(x, y)])


def plane_offsets(xyz: Float, normal: Float, point: Float) -> Float:
    """Returns signed distances (n,) m of points (n, 3) from the plane through `point` with unit `normal`."""
    return np.asarray(xyz @ normal - float(np.dot(normal, point)), np.float64)


def fit_upright_plane(xyz: Float, weights: Float | None = None) -> tuple[Float, Float]:
    """Fits an upright plane to points (n, 3) by total least squares in plan.

    Returns the unit normal (3,), which is horizontal and has an arbitrary sign, and the centroid (3,).
    """
    w = np.ones(len(xyz)) if weights is None else weights
    centre = (w @ xyz) / w.sum()
    q = (xyz - centre)[:, :2]
    _, vectors = np.linalg.eigh((q * w[:, None]).T @ q)
    return np.array([*vectors[:, 0], 0.0]), centre


def fit_plane(xyz: Float, weights: Float | None = None) -> tuple[Float, Float, Float]:
    """Fits a plane to points (n, 3) by total least squares.

    Returns the unit normal (3,), the centroid (3,) and the variances (3,) m2 along the principal axes,
    ascending.

    The sign of the normal is arbitrary but deterministic (its largest component is positive).
    """
    w = np.ones(len(xyz)) if weights is None else weights
    centre = (w @ xyz) / w.sum()
    q = xyz - centre
    values, vectors = np.linalg.eigh((q * w[:, None]).T @ q / w.sum())
    normal = vectors[:, 0]
    return normal * np.sign(normal[np.argmax(np.abs(normal))]), centre, np.maximum(values, 0.0)


def lean(inward: Float) -> float:
    """Returns the angle, rad, by which a wall leans; positive = its top leans towards the street."""
    n = np.asarray(inward, np.float64) / np.linalg.norm(inward)
    return float(np.arcsin(np.clip(n[2], -1.0, 1.0)))
