"""Decide which directions of a pose the data determine, by predicted sigma and not by raw eigenvalues."""

from collections.abc import Sequence

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3, skew
from frontage.registration.result import Alternative, Direction, PosePrior

_LEAST_GAIN = 4.0  # information of the data, relative to the prior's, from which the data tell a direction


def principal_directions(
    covariance: Float, prior: PosePrior, limit: Float, lever: float
) -> tuple[Direction, ...]:
    """Returns the principal directions of a pose with `covariance` (6, 6) about the instrument.

    limit  (3,) m per axis: the largest sigma of an observable shift (`Problem.observable`)
    lever  m, the median range; a turn counts by how far it moves level ground and walls there

    The data tell a direction when they know at least four times what the prior knows. The direction is
    observable if they tell it within `limit`, otherwise weak.
    """
    out = []
    for kind, block in (("shift", slice(0, 3)), ("turn", slice(3, 6))):
        values, vectors = np.linalg.eigh(covariance[block, block])
        for value, axis in zip(values[::-1], vectors.T[::-1], strict=True):
            sigma = float(np.sqrt(max(value, 0.0)))
            known = float(1 / np.sqrt(np.sum(axis**2 / prior.sigma[block] ** 2)))
            told = bool(sigma * np.sqrt(1 + _LEAST_GAIN) <= known)
            axis = axis * np.sign(axis[np.argmax(np.abs(axis))])
            most = _along(axis, limit) if kind == "shift" else _about(axis, limit) / max(lever, 1e-9)
            out.append(Direction(kind, axis, sigma, known, told and sigma <= most, told and sigma > most))
    return tuple(out)


def _along(axis: Float, limit: Float) -> float:
    """Returns the limit (m) along a unit vector (3,)."""
    return float(np.sqrt(np.square(axis * limit).sum()))


def _about(axis: Float, limit: Float) -> float:
    """Returns the limit (m) of the motion that a turn about a unit vector (3,) causes at places level with
    it.

    A turn moves these places along ``axis x r``; the limit is that of the mean over all r in the plane.
    """
    heading, tilt = axis[2] ** 2, axis[0] ** 2 + axis[1] ** 2
    share = np.array([0.5 * heading, 0.5 * heading, 0.5 * tilt])
    return _along(np.sqrt(share / share.sum()), limit)


def alternatives_covariance(position: Float, alternatives: Sequence[Alternative]) -> Float:
    """Returns the covariance (6, 6) that other places add, for an instrument at `position` (3,) m.

    Where several places are possible and none is preferred, the mean square difference from the chosen place
    is that of all places about it. A shift by a building's pitch is not known, however sharp each place is.
    """
    off = np.array([a.at(position) for a in alternatives]).reshape(-1, 6)
    return np.asarray(off.T @ off / (1 + len(off)))


def about_frame(covariance: Float, pose: Rigid3, position: Float) -> Float:
    """Transforms a covariance (6, 6) about the instrument to the tangent of the rigid motion.

    ``T(xi) = (exp(w) R, t + v)``: with m the instrument at `position` (3,) m, ``v = v_m + w x (t - m)``.
    """
    J = np.eye(6)
    J[:3, 3:] = -skew(pose.t - position)
    return np.asarray(J @ covariance @ J.T)
