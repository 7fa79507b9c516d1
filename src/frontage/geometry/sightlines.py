"""Lines of sight: where the line from a sensor to a point crosses a surface across it."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from frontage.geometry.arrays import Float, Int

_LEAST_RUN_M = 1e-3  # m along y between sensor and point below which a line counts as parallel to the wall


@dataclass(frozen=True, eq=False)
class SightLines:
    """Lines of sight (n,) in a frame whose y axis points into the wall, x along it and z up.

    place  (2, n) m, x and z where each line has the depth `level`
    slope  (2, n) m along x and z per m of depth; 0 where the sensor is unknown, so that the point stands for
           the place on the wall right before it
    level  (n,) m, depth y of the places
    """

    place: Float
    slope: Float
    level: Float

    @classmethod
    def to_points(cls, points: Float, eyes: Float, least_run: float = _LEAST_RUN_M) -> "SightLines":
        """The lines from sensors `eyes` (n, 3) or (3,) m, NaN where unknown, to `points` (n, 3) m.

        A line that covers no more than `least_run` m of depth on its way to the point has slope 0.
        """
        return SightLines(points[:, [0, 2]].T, slopes(points, eyes, least_run).T, points[:, 1])

    def at(self, y: Float | float) -> Float:
        """Returns the places (2, n) m where the lines have the depths `y`, a scalar or (n,), m."""
        return np.asarray(self.place + self.slope * (y - self.level))

    def along(self, axis: int, y: float) -> Float:
        """Returns one coordinate (n,) m of `at(y)`: x for axis 0, z for axis 1."""
        return np.asarray(self.place[axis] + self.slope[axis] * (y - self.level))

    def shifted(self, step: Float | float) -> Float:
        """Returns the places (2, n) m that lie `step` m, a scalar or (n,), further along y."""
        return np.asarray(self.place + self.slope * step)

    def moved_to(self, y: Float) -> Self:
        """Returns the same lines with their places at the depths `y` (n,) m."""
        return replace(self, place=self.at(y), level=y)

    def take(self, k: Int) -> "SightLines":
        """Returns the lines with the numbers `k` (m,)."""
        return SightLines(self.place.take(k, 1), self.slope.take(k, 1), self.level[k])


def slopes(points: Float, eyes: Float, least_run: float = _LEAST_RUN_M) -> Float:
    """Returns dx/dy and dz/dy (n, 2) of the lines from `eyes` to `points` (n, 3); 0 without a known eye."""
    run = points[:, 1] - eyes[..., 1]
    with np.errstate(invalid="ignore"):
        known = run > least_run
    run = np.where(known, run, 1.0)
    found = np.empty((2, len(points)))
    for row, axis in zip(found, (0, 2), strict=True):
        np.copyto(row, np.where(known, (points[:, axis] - eyes[..., axis]) / run, 0.0))
    return found.T
