"""The nats for an opening by its steps across four sides, in all channels together."""

from collections.abc import Iterator

import numpy as np
from scipy import special

from frontage.geometry.arrays import Bool, Float

_EXPECTED = 0.5  # nats (a factor of 1.6), one sigma of the step from wall to shutter
_UNEVEN = 0.3  # share of the step, one sigma between the four sides
_BELOW = 1  # index of the lower side among left, bottom, right, top
_TELLS = 2.0  # sigmas of the wall that a channel must differ by to tell by itself
_TAILS = 4.0  # degrees of freedom of the wall's own steps: courses, repairs and stains have heavy tails


def gains_of(own: Float, wall: Float, sills: bool) -> Float:
    """Returns the nats (n,) for one common step on the four sides against steps of the wall itself.

    own    (n, 4, c) steps; -inf nats where one is not known
    wall   (4, c, c) covariance of the wall's own steps
    sills  whether sills may hide the wall below, or show a step of their own
    """
    nats = _gains(own, wall)
    if not sills:
        return nats
    above = np.where(np.arange(4)[:, None] == _BELOW, np.nan, own)
    return np.asarray(np.logaddexp(nats, _gains(above, wall, 3)) - np.log(2.0))


def _gains(own: Float, wall: Float, sides: int = 4) -> Float:
    """Returns the same (n,), -inf where fewer than `sides` sides are known.

    The wall's own steps follow Student's t, side by side. An opening's are normal about a common one, which
    is normal about 0, in one of the channels or in all of them.
    """
    channels = own.shape[2]
    seen: Bool = np.asarray(np.isfinite(wall).all((1, 2)))
    told: Bool = np.asarray(np.isfinite(own).all(2) & seen)
    out: Float = np.full(len(own), -np.inf)
    some = np.flatnonzero(told.sum(1) >= sides)
    if len(some) == 0:
        return out
    scale = np.where(seen[:, None, None], wall, np.eye(channels))
    weight = np.linalg.inv(scale)
    known = told[some].astype(np.float64)
    own = np.where(known[..., None] > 0.0, own[some], 0.0)
    closed = (known * _log_t(np.einsum("nsc,scd,nsd->ns", own, weight, own), scale)).sum(1)
    total = (known[..., None, None] * weight).sum(1)
    mean = np.linalg.solve(total, np.einsum("ns,scd,nsd->nc", known, weight, own)[..., None])[..., 0]
    uneven = (_UNEVEN * mean) ** 2
    opened = [_log_opened(own, known, scale, uneven, prior) for prior in _priors(channels)]
    out[some] = np.logaddexp.reduce(opened, axis=0) - np.log(len(opened)) - closed
    return out


def contrasts_of(own: Float, wall: Float) -> list[tuple[Float, Float, Float]]:
    """Returns sums of channels in which the steps (4, c) are large for those of the wall (4, c, c).

    Each comes as weights (c,), one for the mean step, with the steps (4,) and one sigma (4,) of the wall's by
    them. The first takes all channels together (Fisher's discriminant); then come those that tell by
    themselves, the clearest first.
    """
    known = np.isfinite(own).all(1) & np.isfinite(wall).all((1, 2))
    weight = np.linalg.inv(wall[known])
    total = weight.sum(0)
    mean = np.linalg.solve(total, np.einsum("scd,sd->c", weight, own[known]))
    single = np.abs(own[known].mean(0)) / np.sqrt(np.diagonal(wall[known].mean(0)))
    all_weights = [total @ mean / (mean @ total @ mean)]
    for k in sorted(np.flatnonzero(single > _TELLS), key=lambda k: -single[k]):
        all_weights.append(np.eye(len(mean))[k] / own[known, k].mean())
    return [(w, own @ w, np.sqrt(np.einsum("c,scd,d->s", w, wall, w))) for w in all_weights]


def _log_t(squares: Float, scale: Float) -> Float:
    """Returns the logarithms (n, s) of Student's t density at squared distances (n, s); scales (s, c, c)."""
    channels = scale.shape[1]
    const = special.gammaln((_TAILS + channels) / 2.0) - special.gammaln(_TAILS / 2.0)
    const -= channels / 2.0 * np.log(_TAILS * np.pi) + np.linalg.slogdet(scale)[1] / 2.0
    return np.asarray(const - (_TAILS + channels) / 2.0 * np.log1p(squares / _TAILS))


def _priors(channels: int) -> Iterator[Float]:
    """Yields the variances (c,) of the step: in one of the channels, then in all."""
    for shown in [*np.eye(channels), *([np.ones(channels)] if channels > 1 else [])]:
        yield np.asarray(_EXPECTED**2 * shown)


def _log_opened(own: Float, known: Float, scale: Float, uneven: Float, prior: Float) -> Float:
    """Returns the logarithms (n,) of the density of steps (n, 4, c), the common one integrated out.

    Side by side, each with what the sides before it tell of the common step (the innovations of a Kalman
    filter).
    """
    channels = own.shape[2]
    mean, spread = np.zeros((len(own), channels)), np.tile(np.diag(prior), (len(own), 1, 1))
    log = np.zeros(len(own))
    for side in range(own.shape[1]):
        on = known[:, side] > 0.0
        total = spread + scale[side] + uneven[:, :, None] * np.eye(channels)
        rest = own[:, side] - mean
        inverse = np.linalg.inv(total)
        own_log = np.einsum("nc,ncd,nd->n", rest, inverse, rest) + np.linalg.slogdet(2.0 * np.pi * total)[1]
        log -= np.where(on, own_log / 2.0, 0.0)
        gain = spread @ inverse
        mean = mean + np.where(on[:, None], np.einsum("ncd,nd->nc", gain, rest), 0.0)
        spread = np.where(on[:, None, None], spread - gain @ spread, spread)
    return log
