"""Lens distortion on normalised image coordinates, and its inverse.

Every COLMAP model with a polynomial (or rational) radial part is one `Lens`: with ``q = r^2``::

    f(q)  = (1 + k1 q + k2 q^2 + ...) / (1 + d1 q + d2 q^2 + ...)
    x_d   = x f + 2 p1 x y + p2 (q + 2 x^2) + s1 q + s2 q^2
    y_d   = y f + 2 p2 x y + p1 (q + 2 y^2) + s3 q + s4 q^2

Past the first extremum of ``r f(r^2)`` the polynomial folds back, and a point far outside the picture would
appear inside it. `Lens.limit` is the radius of that extremum; everything beyond it becomes NaN.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import polynomial as poly

from frontage.geometry.arrays import Array, Float

_NEWTON_STEPS = 60
_CONVERGED = 1e-13  # normalised units: 1e-9 px at f = 10000 px


@dataclass(frozen=True)
class Lens:
    """Distortion coefficients: radial numerator and denominator, tangential (p1, p2), thin prism (s1..s4).

    `staged` applies tangential and prism terms to the radially distorted point (RAD_TAN_THIN_PRISM_FISHEYE)
    instead of the undistorted one (all others).
    """

    radial: tuple[float, ...] = ()
    divisor: tuple[float, ...] = ()
    tangential: tuple[float, float] = (0.0, 0.0)
    prism: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    staged: bool = False

    @cached_property
    def _numerator(self) -> Float:
        return np.array([1.0, *self.radial])

    @cached_property
    def _denominator(self) -> Float:
        return np.array([1.0, *self.divisor])

    @property
    def is_radial(self) -> bool:
        """Whether there is neither a tangential nor a prism part."""
        return not any(self.tangential) and not any(self.prism)

    @cached_property
    def limit(self) -> float:
        """Radius up to which ``r f(r^2)`` grows: its first extremum or pole, inf when there is none."""
        n, d = self._numerator, self._denominator
        # d/dr [r n/d] = 0  <=>  n d + 2 q (n' d - n d') = 0, a polynomial in q = r^2
        slope = poly.polysub(poly.polymul(poly.polyder(n), d), poly.polymul(n, poly.polyder(d)))
        extremum = poly.polyadd(poly.polymul(n, d), 2.0 * poly.polymulx(slope))
        return float(np.sqrt(min(_first_root(extremum), _first_root(d))))

    def _factor(self, q: Array) -> Array:
        """The radial factor f(q), q = squared radius (n,)."""
        n = poly.polyval(q, self._numerator)
        return np.asarray(n / poly.polyval(q, self._denominator) if self.divisor else n)

    def factor(self, q: Array) -> tuple[Array, Array]:
        """The radial factor f(q) and its derivative df/dq, q = squared radius (n,)."""
        n, d = poly.polyval(q, self._numerator), poly.polyval(q, self._denominator)
        dn, dd = (
            poly.polyval(q, poly.polyder(self._numerator)),
            poly.polyval(q, poly.polyder(self._denominator)),
        )
        return n / d, (dn * d - n * dd) / (d * d)

    def distort(self, xy: Float) -> Float:
        """Distorts ideal points (n, 2); NaN past the fold."""
        q = xy[:, 0] ** 2 + xy[:, 1] ** 2
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            radial = xy * self._factor(q)[:, None]
            out = radial if self.is_radial else radial + self._decentre(radial if self.staged else xy)
        if np.isfinite(self.limit):
            out[~(q < self.limit**2)] = np.nan
        return out

    def undistort(self, xy: Float) -> Float:
        """Removes the distortion of points (n, 2) by a safeguarded Newton method; NaN where nothing maps."""
        if self.staged:
            return self._undistort_radial(self._newton(xy, xy.copy(), bare=True))
        guess = self._undistort_radial(xy)
        return guess if self.is_radial else self._newton(xy, guess)

    def _decentre(self, xy: Float) -> Float:
        """The tangential and thin prism displacement (n, 2) at points (n, 2)."""
        x, y = xy.T
        q = x * x + y * y
        (p1, p2), (s1, s2, s3, s4) = self.tangential, self.prism
        moved = np.empty_like(xy)
        moved[:, 0] = 2 * p1 * x * y + p2 * (q + 2 * x * x) + q * (s1 + s2 * q)
        moved[:, 1] = 2 * p2 * x * y + p1 * (q + 2 * y * y) + q * (s3 + s4 * q)
        return moved

    def _undistort_radial(self, xy: Float) -> Float:
        """Inverts ``r f(r^2)`` on [0, limit] by Newton steps within a shrinking bracket."""
        goal = np.hypot(xy[:, 0], xy[:, 1])
        low, high = np.zeros_like(goal), self._bracket(goal)
        r = np.minimum(goal, high)
        with np.errstate(invalid="ignore"):
            for _ in range(_NEWTON_STEPS):
                f, df = self.factor(r * r)
                miss = r * f - goal
                low, high = np.where(miss < 0, r, low), np.where(miss >= 0, r, high)
                slope = f + 2 * r * r * df
                step = np.where(slope > 0, r - miss / np.where(slope > 0, slope, 1.0), np.inf)
                new = np.where((step >= low) & (step <= high), step, 0.5 * (low + high))
                done = np.abs(new - r) <= _CONVERGED * (1 + r)
                r = new
                if done[np.isfinite(high)].all():
                    break
            scale = np.where(goal > 0, r / np.where(goal > 0, goal, 1.0), 1.0)
        return np.where(np.isfinite(high), scale, np.nan)[:, None] * xy

    def _bracket(self, goal: Float) -> Float:
        """Returns radii (n,) whose distorted radius is at least `goal`; NaN where it is never reached."""
        if np.isfinite(self.limit):
            top = self.limit * (1 - 1e-12)
            reach = top * self.factor(np.array(top * top))[0]
            return np.where(goal <= reach, top, np.nan)
        high = np.maximum(goal, 1e-9)
        for _ in range(40):
            short = high * self.factor(high * high)[0] < goal
            if not short.any():
                break
            high = np.where(short, 2 * high, high)
        return np.where(high * self.factor(high * high)[0] >= goal, high, np.nan)

    def _newton(self, goal: Float, xy: Float, bare: bool = False) -> Float:
        """Solves the full two-dimensional model for points (n, 2) from a first guess; `bare` omits f."""
        for _ in range(_NEWTON_STEPS):
            value, (a, b, c, d) = self._value_and_jacobian(xy, bare)
            miss = value - goal
            with np.errstate(invalid="ignore", divide="ignore"):
                det = a * d - b * c
                step = (
                    np.column_stack([d * miss[:, 0] - b * miss[:, 1], a * miss[:, 1] - c * miss[:, 0]])
                    / det[:, None]
                )
            xy = xy - step
            if not (np.abs(step) > _CONVERGED).any():
                break
        with np.errstate(invalid="ignore"):
            good = np.max(np.abs(self._value_and_jacobian(xy, bare)[0] - goal), axis=1) < 1e-9
            inside = bare | ((xy**2).sum(1) < self.limit**2)
        return np.where(np.logical_and(good, inside)[:, None], xy, np.nan)

    def _value_and_jacobian(self, xy: Float, bare: bool) -> tuple[Float, tuple[Float, Float, Float, Float]]:
        """Distorted points (n, 2) and the four entries (n,) of their Jacobian, row by row."""
        x, y = xy.T
        q = x * x + y * y
        f, df = (np.ones_like(q), np.zeros_like(q)) if bare else self.factor(q)
        (p1, p2), (s1, s2, s3, s4) = self.tangential, self.prism
        value = xy * f[:, None] + self._decentre(xy)
        cross = 2 * x * y * df + 2 * p1 * x + 2 * p2 * y
        prism_x, prism_y = s1 + 2 * s2 * q, s3 + 2 * s4 * q
        return value, (
            f + 2 * x * x * df + 2 * p1 * y + 6 * p2 * x + 2 * x * prism_x,
            cross + 2 * y * prism_x,
            cross + 2 * x * prism_y,
            f + 2 * y * y * df + 2 * p2 * x + 6 * p1 * y + 2 * y * prism_y,
        )


def _first_root(coefficients: Float) -> float:
    """Returns the smallest real root > 0 of a polynomial (lowest order first); inf when there is none."""
    roots = poly.polyroots(poly.polytrim(coefficients)) if len(coefficients) > 1 else np.empty(0)
    size, turn = np.asarray(roots.real), np.asarray(roots.imag)
    real = size[(np.abs(turn) <= 1e-9 * (1 + np.abs(size))) & (size > 0)]
    return float(real.min()) if len(real) else float("inf")
