"""Which directions of a pose the data determine: judged by the predicted sigma, not by raw eigenvalues."""

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3, skew
from frontage.registration.result import Direction, PosePrior

_GAIN = 4.0  # information of the data, relative to the prior's, that makes a direction observed


def directions(covariance: Float, prior: PosePrior, limit: float, lever: float) -> tuple[Direction, ...]:
    """Principal directions of shift and turn of a pose with `covariance` (6, 6) about the instrument.

    A direction is unobservable when its sigma is above `limit` m (turns: times `lever` m, the median range),
    or when the data know less than four times what the prior knows.
    """
    out = []
    for kind, block, reach in (("shift", slice(0, 3), 1.0), ("turn", slice(3, 6), lever)):
        values, vectors = np.linalg.eigh(covariance[block, block])
        for value, axis in zip(values[::-1], vectors.T[::-1], strict=True):
            sigma = float(np.sqrt(max(value, 0.0)))
            known = float(1 / np.sqrt(np.sum(axis**2 / prior.sigma[block] ** 2)))
            gained = sigma * np.sqrt(1 + _GAIN) <= known
            axis = axis * np.sign(axis[np.argmax(np.abs(axis))])
            out.append(Direction(kind, axis, sigma, known, bool(gained and sigma * reach <= limit)))
    return tuple(out)


def about_frame(covariance: Float, pose: Rigid3, position: Float) -> Float:
    """Covariance (6, 6) about the instrument at `position` (3,) as that of the rigid motion's own tangent.

    ``T(xi) = (exp(w) R, t + v)``: with m the instrument, ``v = v_m + w x (t - m)``.
    """
    J = np.eye(6)
    J[:3, 3:] = -skew(pose.t - position)
    return np.asarray(J @ covariance @ J.T)
