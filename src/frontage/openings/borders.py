"""Where exactly the border of an opening lies: a posterior from the beams on both sides of it."""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from frontage.geometry.arrays import Float
from frontage.openings.beams import Beams

_STEP = 0.001  # m, raster of the posterior
_STRAY = 0.01  # share of the beams that say the wrong thing
_SHY = 0.15  # share of the opening's side that is left out at either end: arches, corners, sills
_FLOOR = 0.001  # m: reveals are not straighter
_BEAM = 0.0045  # m: half the footprint of common scanners 10 m away; by it first echoes shift borders


@dataclass(frozen=True)
class Border:
    """Place of a border along its axis, m, one sigma, and the nats it gains over no border at all."""

    at: float
    sigma: float
    gain: float


class Strips:
    """Beams sorted along one axis (0 = x, 1 = z), to look at the strips around borders quickly."""

    def __init__(self, beams: Beams, axis: int) -> None:
        self.rays = beams.rays
        self.width = max(beams.sigma, _FLOOR)  # of the beam's own blur at an edge
        self._sorted = [p[np.argsort(p[:, axis], kind="stable")] for p in (beams.solid, beams.open)]
        self._axis = axis

    def pick(self, kind: int, low: float, high: float, across: tuple[float, float]) -> Float:
        """Places (n,) along the axis of solid (0) or open (1) beams within [low, high] and `across`."""
        p = self._sorted[kind]
        a, b = np.searchsorted(p[:, self._axis], [low, high])
        other = p[a:b, 1 - self._axis]
        return np.asarray(p[a:b, self._axis][(other >= across[0]) & (other <= across[1])])

    def around(self, kind: int, along: tuple[float, float], across: tuple[float, float]) -> Float:
        """Solid (0) or open (1) beams (n, 2) x, z m in a rectangle."""
        p = self._sorted[kind]
        a, b = np.searchsorted(p[:, self._axis], along)
        other = p[a:b, 1 - self._axis]
        return np.asarray(p[a:b][(other >= across[0]) & (other <= across[1])])

    def locate(self, at: float, sign: int, band: float, inner: float, across: tuple[float, float]) -> Border:
        """The border near `at` m whose opening lies to the side `sign` (+1: beyond it).

        band     m to either side that is searched; inner m: depth of the opening that may be looked into
        across   m, extent of the side

        Solid and open beams are Poisson processes with the rates of their own side, blurred by the beam; the
        posterior mean over a flat prior is unbiased whether or not the opening returns anything (the last
        hit, which is not, lies half a spacing off).
        """
        cut = _SHY * (across[1] - across[0])
        span = (across[0] + cut, across[1] - cut)
        reach = band + min(band, inner)
        solid = sign * (self.pick(0, at - reach, at + reach, span) - at)
        opened = sign * (self.pick(1, at - reach, at + reach, span) - at)
        if len(solid) < 3:
            return Border(at, band / np.sqrt(3.0), 0.0)
        e = np.arange(-band, band + _STEP / 2, _STEP)
        width = reach - band / 2
        wall = max((solid < -band / 2).sum() / width, 1.0 / reach)
        hole = max((opened > band / 2).sum() / width, 1.0 / reach)
        on = _log_likelihood(e, -solid, wall, (solid > band / 2).sum() / width, self.width)
        score = on[::-1] + _log_likelihood(e, opened, hole, (opened < -band / 2).sum() / width, self.width)
        p = np.exp(score - score.max())
        p /= p.sum()
        mean = float(p @ e)
        sigma = float(np.sqrt(p @ (e - mean) ** 2 + _FLOOR**2 + _BEAM**2))
        return Border(at + sign * mean, sigma, float(score.max() - max(score[0], score[-1])))


def _log_likelihood(e: Float, places: Float, rate: float, background: float, blur: float) -> Float:
    """Log-likelihood (k,) of borders at e (k,), m, beyond which places (n,) come at `rate` per m.

    Before the border they come at the `background` rate (points of rooms behind a wall, of bars level with
    it), at least 1 %; an inhomogeneous Poisson process: sum of log rates less their integral.
    """
    low = max(background, _STRAY * rate)
    if low >= rate:
        return np.zeros(len(e))
    rates = low + (rate - low) * ndtr((places[None, :] - e[:, None]) / blur)
    return np.asarray(np.log(rates).sum(1) + (rate - low) * e)
