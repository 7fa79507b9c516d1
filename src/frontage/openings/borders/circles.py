"""Decides whether an opening is a circle: centre and radius by the likelihood of the beams about it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.openings.borders.fan import Fan
from frontage.openings.borders.scores import side_scores
from frontage.openings.boxes import Box

_ROUND = (0.8, 1.25)  # height over width of what may be a circle
_STEPS = (0.02, 0.005, 0.001)  # m by which the centre of a circle is moved
_MOVE = 1e-6  # nats that a move must gain


@dataclass(frozen=True)
class Circle:
    """A circle: centre x, z m, radius m and its sigma m, and the nats it gains over the box around it."""

    x: float
    z: float
    radius: float
    sigma: float
    gain: float

    @property
    def box(self) -> Box:
        """The bounding box."""
        return self.x - self.radius, self.z - self.radius, self.x + self.radius, self.z + self.radius


def find_circle(fan: Fan, place: Box, blur: float) -> Circle | None:
    """Returns the likeliest circle about a box; None where the box is not square or nothing tells.

    The centre is searched for, because how straight borders lie on a circle depends on how slanted the beams
    are. Wall must show in all four corners that the circle leaves of its square: what is left of a window
    across which the scan ends may look round.
    """
    x0, z0, x1, z1 = place
    wide, high = x1 - x0, z1 - z0
    if not _ROUND[0] < high / wide < _ROUND[1]:
        return None
    x, z = (x0 + x1) / 2, (z0 + z1) / 2
    some = fan.part(np.maximum(np.abs(fan.x - x) / wide, np.abs(fan.z - z) / high) < 0.75)
    if not some.solid.any() or some.solid.all():
        return None
    radii = np.arange(0.4 * wide, 0.7 * wide, 0.0005)
    middle = float(radii[len(radii) // 2])

    def score(size: Float, area: Float) -> Float:
        """Returns the log-likelihood (k,) of all radii by the sizes of the beams' places about a centre."""
        u = middle - size
        told = side_scores(u[some.solid], u[~some.solid], middle - radii[::-1], blur)[::-1]
        return np.asarray(told + some.missing * area)

    def rings(x: float, z: float) -> Float:
        """Returns the log-likelihood (k,) of circles of all radii about a centre."""
        return score(np.hypot(some.x - x, some.z - z), np.pi * radii**2)

    square = score(np.maximum(np.abs(some.x - x), np.abs(some.z - z) * wide / high), 4.0 * radii**2)
    x, z, best = _climbed(rings, x, z)
    p = np.exp(best - best.max())
    p /= p.sum()
    mean = float(p @ radii)
    if not _cornered(some, x, z, mean):
        return None
    sigma = float(np.sqrt(p @ (radii - mean) ** 2))
    return Circle(x, z, mean, sigma, float(best.max() - square.max()))


def _cornered(fan: Fan, x: float, z: float, radius: float) -> bool:
    """Returns whether wall shows between the circle and each corner of the square around it."""
    u, v = fan.x - x, fan.z - z
    corner = fan.solid & (np.maximum(np.abs(u), np.abs(v)) < radius) & (np.hypot(u, v) > radius)
    return bool(np.bincount(2 * (u > 0.0)[corner] + (v > 0.0)[corner], minlength=4).all())


def _climbed(score: Callable[[float, float], Float], x: float, z: float) -> tuple[float, float, Float]:
    """Moves a place x, z m until no step raises the score; returns it with its scores (k,)."""
    best = score(x, z)
    for step in _STEPS:
        moved = True
        while moved:
            moved = False
            for dx, dz in ((0.0, step), (0.0, -step), (step, 0.0), (-step, 0.0)):
                trial = score(x + dx, z + dz)
                if trial.max() > best.max() + _MOVE:
                    x, z, best, moved = x + dx, z + dz, trial, True
    return x, z, best
