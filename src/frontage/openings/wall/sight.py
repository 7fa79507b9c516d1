"""Lines of sight at the wall: where every beam crosses it, how it slants, and how far behind it it ended."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.model.facade import Facade
from frontage.model.scan import Scan
from frontage.openings.wall.beams import Beams

_STEEPEST = 20.0  # m along the wall per m of depth: 87 degrees of incidence


@dataclass(frozen=True, eq=False)
class Sight:
    """Beams (n,) sorted by the x of their crossing.

    place   (2, n) x, z m where the beam crosses the local wall
    slope   (2, n) m along x, z that it moves per m of depth; 0 where the sensor's place is unknown
    depth   (n,) m, of its point behind the local wall (negative = before it)
    level   (n,) m, depth y of the local wall there
    range   (n,) m, from the sensor to the wall; 0 where the sensor's place is unknown
    wall    m, above 3 sigma of the wall's own points
    """

    place: Float
    slope: Float
    depth: Float
    level: Float
    range: Float
    wall: float

    def around(self, box: tuple[float, float, float, float], margin: float) -> "Sight":
        """The beams that cross a box x0, z0, x1, z1 m or the margin m about it."""
        a, b = np.searchsorted(self.place[0], [box[0] - margin, box[2] + margin])
        z = self.place[1, a:b]
        return self._part(a + np.flatnonzero((z > box[1] - margin) & (z < box[3] + margin)))

    def thinned(self, number: int) -> "Sight":
        """Every n-th beam, so that about `number` are left."""
        return self._part(np.arange(0, len(self.depth), max(len(self.depth) // number, 1)))

    def behind(self, y: float) -> "Sight":
        """The same beams where the wall lies at least at the depth y m: before it is relief."""
        step = np.maximum(y - self.level, 0.0)
        place = self.place + self.slope * step
        return Sight(place, self.slope, self.depth - step, self.level + step, self.range, self.wall)

    def _part(self, k: Int) -> "Sight":
        return Sight(
            self.place.take(k, 1),
            self.slope.take(k, 1),
            self.depth[k],
            self.level[k],
            self.range[k],
            self.wall,
        )

    def at(self, y: Float) -> Float:
        """Where the beams cross the depth y (n,) m, (2, n)."""
        return np.asarray(self.place + self.slope * y)

    @cached_property
    def own(self) -> Float:
        """x, z m of the beams' points, (2, n)."""
        return self.at(self.depth)


def sight_lines(facade: Facade, scan: Scan, beams: Beams) -> Sight:
    """Lines of sight that cross the facade's bounding box; points of unknown sensors stand for themselves.

    The wall's local depth is that of `beams`; crossings are found with the plane, then with the depth there.
    """
    lines = beams.lines
    ok = np.flatnonzero(np.abs(lines.slope).max(0) < _STEEPEST)
    lone = facade.support[scan.origin_index[facade.support] < 0]
    x, y, z = facade.frame.inverse.apply(scan.xyz[lone]).T
    place = np.hstack([lines.place[:, ok], [x, z]])
    level = np.concatenate([lines.level[ok], beams.depth_at(x, z)])
    depth = np.concatenate([lines.y[ok], y]) - level
    slope = np.hstack([lines.slope[:, ok], np.zeros((2, len(lone)))])
    away = np.concatenate([lines.range[ok], np.zeros(len(lone))])
    order = np.argsort(place[0], kind="stable")
    return Sight(
        place.take(order, 1), slope.take(order, 1), depth[order], level[order], away[order], beams.least
    )
