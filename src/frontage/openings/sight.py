"""Lines of sight at the wall: where every beam crosses it, how it slants, and how far behind it it ended."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.facade import Facade
from frontage.model.scan import Scan
from frontage.openings.beams import Beams

_NEAR = 0.3  # m before the wall: what ends before that is stopped by something else
_FAR = 60.0  # m behind the wall that a beam may reach
_STEEPEST = 20.0  # m along the wall per m of depth: 87 degrees of incidence


@dataclass(frozen=True, eq=False)
class Sight:
    """Beams (n,) sorted by the x of their crossing.

    place   (n, 2) x, z m where the beam crosses the local wall
    slope   (n, 2) m along x, z that it moves per m of depth; 0 where the sensor's place is unknown
    depth   (n,) m, of its point behind the local wall (negative = before it)
    level   (n,) m, depth y of the local wall there
    wall    m, above 3 sigma of the wall's own points
    """

    place: Float
    slope: Float
    depth: Float
    level: Float
    wall: float

    def around(self, box: tuple[float, float, float, float], margin: float) -> "Sight":
        """The beams that cross a box x0, z0, x1, z1 m or the margin m about it."""
        a, b = np.searchsorted(self.place[:, 0], [box[0] - margin, box[2] + margin])
        z = self.place[a:b, 1]
        k = a + np.flatnonzero((z > box[1] - margin) & (z < box[3] + margin))
        return Sight(self.place[k], self.slope[k], self.depth[k], self.level[k], self.wall)

    def thinned(self, number: int) -> "Sight":
        """Every n-th beam, so that about `number` are left."""
        step = max(len(self.depth) // number, 1)
        k = slice(None, None, step)
        return Sight(self.place[k], self.slope[k], self.depth[k], self.level[k], self.wall)

    def behind(self, y: float) -> "Sight":
        """The same beams where the wall lies at least at the depth y m: before it is relief."""
        step = np.maximum(y - self.level, 0.0)
        place = self.place + self.slope * step[:, None]
        return Sight(place, self.slope, self.depth - step, self.level + step, self.wall)

    def at(self, y: Float) -> Float:
        """Where the beams cross the depth y (n,) or () m, (n, 2)."""
        return np.asarray(self.place + self.slope * np.reshape(y, (-1, 1)))


def sight_lines(facade: Facade, scan: Scan, beams: Beams) -> Sight:
    """Lines of sight that cross the facade's bounding box; points of unknown sensors stand for themselves.

    The wall's local depth is that of `beams`; crossings are found with the plane, then with the depth there.
    """
    to_facade = facade.frame.inverse
    known = np.flatnonzero(scan.origin_index >= 0)
    point = to_facade.apply(scan.xyz[known])
    eye = to_facade.apply(scan.origins)[scan.origin_index[known]]
    run = point[:, 1] - eye[:, 1]
    ok = (eye[:, 1] < -_NEAR) & (run > 1e-3) & (point[:, 1] < _FAR)
    point, run = point[ok], run[ok]
    slope = (point - eye[ok])[:, [0, 2]] / run[:, None]
    place = point[:, [0, 2]] - slope * point[:, 1:2]
    y = beams.depth_at(*place.T)
    place += slope * y[:, None]
    ok = (np.abs(slope).max(1) < _STEEPEST) & (beams.raster.flat(*place.T) >= 0)
    lone = facade.support[scan.origin_index[facade.support] < 0]
    own = to_facade.apply(scan.xyz[lone])
    level = np.concatenate([y[ok], beams.depth_at(own[:, 0], own[:, 2])])
    depth = np.concatenate([point[ok, 1], own[:, 1]]) - level
    place = np.vstack([place[ok], own[:, [0, 2]]])
    slope = np.vstack([slope[ok], np.zeros((len(own), 2))])
    order = np.argsort(place[:, 0], kind="stable")
    return Sight(place[order], slope[order], depth[order], level[order], beams.least)
