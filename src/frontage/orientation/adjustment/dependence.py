"""Errors that are alike: which observations they concern, and by how much, as nested spherical variograms.

Templates overlap, the samples of a scan lie where they lie for all photos, a piece of wall is rough. Such
errors are alike at neighbouring places, in one photo or in all of them. A unit of variance of a group is
divided into what every observation has alone, and parts that are alike over several ranges (nested
structures; Matheron 1963). The shares are estimated from residuals (`variogram`).
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Array, Float, freeze

RANGES = (1.5, 4.0, 12.0)
"""Over which errors may be alike, in units of `Dependence.reach`: what overlaps, its surroundings, a bay."""


@dataclass(frozen=True)
class Dependence:
    """Which errors may be alike.

    reach   per group of observations, m on the object: errors of neighbours are alike at least over it
    own     groups whose errors may be alike at neighbouring places of one photo
    shared  groups whose errors may be alike at neighbouring places in all photos
    whole   per group, which share of the variance that neighbours in all photos share is alike everywhere:
            what no residual shows has to be known
    """

    reach: dict[int, float]
    own: frozenset[int]
    shared: frozenset[int]
    whole: dict[int, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Variogram:
    """The shares of a unit of variance that are alike over `RANGES`; the rest every observation has alone.

    own     (r,) in one photo
    shared  (r,) in all photos
    reach   m
    whole   alike in all photos and everywhere; no residual shows it
    """

    own: Float
    shared: Float
    reach: float
    whole: float = 0.0

    def __post_init__(self) -> None:
        freeze(self, own=((len(RANGES),), np.float64), shared=((len(RANGES),), np.float64))

    @property
    def alike(self) -> float:
        """The share of the variance that is not an observation's alone."""
        return float(self.own.sum() + self.shared.sum() + self.whole)

    def between(self, distance: Float, same_photo: Array | bool) -> Float:
        """The covariance of the parts that are alike at a distance (...,) m."""
        parts = zip(structures(distance, self.reach), self.own, self.shared, strict=True)
        total = sum(k * (shared + own * np.asarray(same_photo, np.float64)) for k, own, shared in parts)
        return np.asarray(total + self.whole, np.float64)


def structures(distance: Float, reach: float) -> Iterator[Float]:
    """Spherical correlations at a distance (...,) m, for each of `RANGES`; zero beyond its range."""
    for range_ in RANGES:
        x = np.minimum(distance / (range_ * reach), 1.0)
        yield np.asarray(1.0 - 1.5 * x + 0.5 * x**3, np.float64)


def distances(a: Float, b: Float) -> Float:
    """Distances (m, n) of points (m, 3) and (n, 3)."""
    square = np.square(a).sum(1)[:, None] + np.square(b).sum(1) - 2.0 * a @ b.T
    return np.asarray(np.sqrt(np.maximum(square, 0.0)))
