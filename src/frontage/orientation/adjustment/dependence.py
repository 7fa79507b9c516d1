"""Errors that are alike: which observations they concern, and by how much, as nested spherical variograms.

Templates overlap, the samples of a scan lie where they lie for all photos, a piece of wall is rough. Such
errors are alike at neighbouring places, in one photo or in all of them. A unit of variance of a group is
divided into what every observation has alone, and parts that are alike over several ranges (nested
structures; Matheron 1963). The shares are estimated from residuals (`variogram`).
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from frontage.geometry.arrays import Array, Float, Int, freeze

RANGES = (1.5, 4.0, 12.0, 36.0)
"""Over which errors may be alike, in units of `Dependence.reach`: what overlaps, its surroundings, a bay,
a front."""

BEYOND = 40.0
"""The range of errors, in the same units, that poses absorb so well that residuals do not tell them."""

_CHUNK = 512  # cells


@dataclass(frozen=True)
class Dependence:
    """Which errors may be alike.

    reach   per group of observations, m on the object: errors of neighbours are alike at least over it
    own     groups whose errors may be alike at neighbouring places of one photo
    shared  groups whose errors may be alike at neighbouring places in all photos
    far     per group, which share of the variance that neighbours in all photos share is alike over longer
            ranges than residuals can show (`BEYOND`): what nothing shows has to be known
    least   per group, m: by how much neighbours in all photos are displaced together over the longest of
            `RANGES`, even where residuals do not show it, because poses have absorbed it
    relief  a group of surfaces and one of images whose points lie on them: both have the errors of the scan
            across its surface; None where no groups are related
    fading  groups of whose errors no more is alike over a longer range than over a shorter one, and of which
            residuals are asked for no range that is longer than the object
    """

    reach: dict[int, float]
    own: frozenset[int]
    shared: frozenset[int]
    far: dict[int, float] = field(default_factory=dict)
    least: dict[int, float] = field(default_factory=dict)
    relief: tuple[int, int] | None = None
    fading: frozenset[int] = frozenset()


@dataclass(frozen=True, eq=False)
class Variogram:
    """The shares of a unit of variance that are alike over `RANGES`; the rest every observation has alone.

    own     (r,) in one photo
    shared  (r,) in all photos
    reach   m
    far     alike in all photos over `BEYOND`; no residual shows it
    """

    own: Float
    shared: Float
    reach: float
    far: float = 0.0

    def __post_init__(self) -> None:
        freeze(self, own=((len(RANGES),), np.float64), shared=((len(RANGES),), np.float64))

    def at_least(self, share: float) -> "Variogram":
        """The same, with no less than a share alike in all photos over the longest of `RANGES`."""
        shared = self.shared.copy()
        shared[-1] = max(shared[-1], share)
        return replace(self, shared=shared)

    @property
    def alone(self) -> float:
        """The share of the variance that is an observation's alone.

        What is alike may be more than the whole: the variance of a group is taken from residuals, and where
        errors are alike residuals are smaller than errors.
        """
        return max(0.0, 1.0 - float(self.own.sum() + self.shared.sum() + self.far))

    def between(self, distance: Float, same_photo: Array | bool) -> Float:
        """The covariance of the parts that are alike at a distance (...,) m."""
        parts = zip(RANGES, self.own, self.shared, strict=True)
        same = np.asarray(same_photo, np.float64)
        total = self.far * spherical(distance, BEYOND * self.reach)
        for range_, own, shared in parts:
            total = total + spherical(distance, range_ * self.reach) * (shared + own * same)
        return np.asarray(total, np.float64)


def spherical(distance: Float, reach: float) -> Float:
    """The spherical correlation at a distance (...,) m; zero beyond its reach."""
    x = np.minimum(distance / reach, 1.0)
    return np.asarray(1.0 - 1.5 * x + 0.5 * x**3, np.float64)


def distances(a: Float, b: Float) -> Float:
    """Distances (m, n) of points (m, 3) and (n, 3)."""
    square = np.square(a).sum(1)[:, None] + np.square(b).sum(1) - 2.0 * a @ b.T
    return np.asarray(np.sqrt(np.maximum(square, 0.0)))


def alike_chunks(middle: Float, photo: Int | None, variogram: Variogram) -> Iterator[tuple[slice, Float]]:
    """Yields some cells (c,) at a time, with the covariances (g, c) of their errors with those of all cells.

    middle  (c, 3) m; photo (c,) numbers, None where errors of one photo are no more alike than others
    """
    for start in range(0, len(middle), _CHUNK):
        part = slice(start, start + _CHUNK)
        same = False if photo is None else photo[part, None] == photo
        yield part, variogram.between(distances(middle[part], middle), same)


def alike_gradient(pull: Float, middle: Float, photo: Int | None, variogram: Variogram) -> Float:
    """Returns the covariance (u, u) of the gradient from errors of cells (c,) that are alike.

    pull    (c, 3, u), what an error of each cell adds to the gradient
    middle, photo  of the cells, see `alike_chunks`
    """
    u = pull.shape[2]
    wide = pull.reshape(len(pull), -1)
    total = np.zeros((u, u))
    for chunk, k in alike_chunks(middle, photo, variogram):
        total += pull[chunk].reshape(-1, u).T @ (k @ wide).reshape(-1, u)
    return np.asarray(0.5 * (total + total.T))
