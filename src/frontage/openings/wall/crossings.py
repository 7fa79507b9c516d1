"""The beams that cross a wall: where each one crosses it, how it slants, and how far behind it it ended."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from frontage.geometry.arrays import Float, Int, drawn, rising
from frontage.geometry.sightlines import SightLines
from frontage.model.facade import Facade
from frontage.model.scan import Scan
from frontage.openings.wall.beams import Beams

_STEEPEST = 20.0  # m along the wall per m of depth: 87 degrees of incidence


@dataclass(frozen=True, eq=False)
class CrossingBeams(SightLines):
    """Beams (n,) that cross the wall, sorted by the x of their places on the local wall.

    depth   (n,) m, of the beam's point behind the local wall (negative = in front of it)
    range   (n,) m, from the sensor to the wall; 0 where the sensor is unknown
    wall    m, distance from the wall within which points count as on it: at least 3 sigma of its points
    """

    depth: Float
    range: Float
    wall: float

    def around(self, box: tuple[float, float, float, float], margin: float) -> "CrossingBeams":
        """Returns the beams that cross a box or the margin of `margin` m around it."""
        a, b = np.searchsorted(self.place[0], [box[0] - margin, box[2] + margin])
        z = self.place[1, a:b]
        return self.part(a + np.flatnonzero((z > box[1] - margin) & (z < box[3] + margin)))

    def thinned(self, number: int) -> "CrossingBeams":
        """Returns about `number` of the beams, the same ones in a mirrored facade."""
        if len(self.depth) < 2 * number:
            return self
        return self.part(drawn(np.column_stack([np.abs(self.place[0]), self.place[1]]), number))

    def behind(self, y: float) -> "CrossingBeams":
        """Returns the same beams with the wall at the depth y m where it lies before that, as relief does."""
        step = np.maximum(y - self.level, 0.0)
        return replace(self, place=self.shifted(step), level=self.level + step, depth=self.depth - step)

    def part(self, k: Int) -> "CrossingBeams":
        """Returns the beams with the numbers `k` (m,)."""
        lines = self.take(k)
        return CrossingBeams(lines.place, lines.slope, lines.level, self.depth[k], self.range[k], self.wall)

    @cached_property
    def rays(self) -> bool:
        """Whether any line of sight is known."""
        return bool(self.slope.any())

    @cached_property
    def steep(self) -> Float:
        """How far (2, n) m the beams run along x and z per m of depth, to either side."""
        return np.abs(self.slope)

    @cached_property
    def points(self) -> Float:
        """x and z (2, n) m of the beams' points."""
        return self.shifted(self.depth)


def crossing_beams(facade: Facade, scan: Scan, beams: Beams) -> CrossingBeams:
    """Returns the beams that cross the facade's bounding box; points of unknown sensors stand for themselves.

    The local depth of the wall is that of `beams`. Points that were seen from a roof do not count.
    """
    lines = beams.lines
    ok = np.flatnonzero(np.abs(lines.slope).max(0) < _STEEPEST)
    lone = np.flatnonzero(scan.origin_index[facade.support] < 0)
    x, y, z = beams.points[lone].T
    wall = beams.depth_at(x, z)
    kept = (z < beams.roof) | (y - wall <= beams.least)
    lone, x, y, z, wall = (values[kept] for values in (lone, x, y, z, wall))
    place = np.hstack([lines.place[:, ok], [x, z]])
    level = np.concatenate([lines.level[ok], wall])
    depth = np.concatenate([lines.y[ok], y]) - level
    slope = np.hstack([lines.slope[:, ok], np.zeros((2, len(lone)))])
    away = np.concatenate([lines.range[ok], np.zeros(len(lone))])
    order = rising(place[0])
    return CrossingBeams(
        place.take(order, 1), slope.take(order, 1), level[order], depth[order], away[order], beams.least
    )
