"""The beams before, on and behind the wall of a facade, as protrusions are measured by them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from frontage.geometry.arrays import Float, Int, drawn
from frontage.geometry.sightlines import SightLines, slopes
from frontage.model.canonical import canonical_order, steady
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY, TOLERANCES
from frontage.model.scan import Scan
from frontage.openings.boxes import Box
from frontage.openings.wall.beams import sensor_positions

_CROWN = 0.6  # m above the wall that a cornice may reach
_AT_WALL = 0.05  # m before the wall: nearer points are in the support
_STEEP = 1.5  # m along the wall per m of depth: beams that slant more are looked at wherever they are
_ROUNDING = 1e-6  # m by which places may be off in the choice of beams


@dataclass(frozen=True, eq=False)
class FacadeBeams:
    """The beams before, on and behind a facade's wall; a bent wall is straightened.

    q      (3, n) m, their points as columns x, y, z in the facade frame
    slope  (2, n) dx/dy and dz/dy; 0 where the sensor is not known, so that a point stands for the place on a
           plane right before it
    """

    q: Float
    slope: Float

    @classmethod
    def of(cls, facade: Facade, scan: Scan) -> "FacadeBeams":
        """Returns the beams of the facade's support, of all that stands before it, and that stopped them.

        The support may lack parts of balconies and bays that were taken for obstacles.
        """
        inverse = facade.frame.inverse
        q, (x0, z0, x1, z1) = steady(inverse.apply(scan.xyz)), facade.extent
        origins = sensor_positions(facade, scan)
        x, y, z = q.T
        kept = (y < -_AT_WALL) & (y >= -MASONRY.facade_reach)
        kept &= (z > z0) & (z < z1 + _CROWN) & (x > x0) & (x < x1)
        kept[facade.support] = True
        far = np.flatnonzero((y < -MASONRY.facade_reach) & (scan.origin_index >= 0))
        ahead = y[far] - origins[scan.origin_index[far], 1] > 0.0
        # beams away from the wall have no place on it but their points'
        beyond, far = far[~ahead], far[ahead]
        kept[beyond[(x[beyond] >= x0) & (x[beyond] <= x1) & (z[beyond] >= z0) & (z[beyond] <= z1)]] = True
        u, v = SightLines.to_points(q[far], origins[scan.origin_index[far]]).at(0.0)
        kept[far[(u >= x0) & (v >= z0) & (u <= x1) & (v <= z1)]] = True
        rows = np.flatnonzero(kept)
        rows = rows[canonical_order(q[rows])]
        own = np.take(q, rows, axis=0)
        columns = np.ascontiguousarray(own.T)
        columns[1] -= bend(facade, columns[0])
        slope = slopes(own, np.take(origins, scan.origin_index[rows], axis=0))
        return cls(columns, np.ascontiguousarray(slope.T))

    def at(self, y: float, box: Box, margin: float) -> tuple[Float, Float]:
        """Returns the places (k, 2) x, z m in a box where beams cross the plane at y m, and depths (k,) m.

        The depths are the y of the beams' points. `margin` m is added to the box on all sides.
        """
        reach = margin + _STEEP * abs(y) + _ROUNDING
        by_axis = [
            (numbers[slice(*on_wall.searchsorted([box[k] - reach, box[k + 2] + reach]))], steep)
            for k, (on_wall, numbers, steep) in enumerate(self._by_place)
        ]
        some = np.concatenate(min(by_axis, key=lambda found: len(found[0]) + len(found[1])))
        depth = self.q[1].take(some)
        x, z = (q.take(some) for q in self.q[::2])
        if self._rays:
            x, z = (v + slope.take(some) * (y - depth) for v, slope in zip((x, z), self.slope, strict=True))
        inside = (x >= box[0] - margin) & (x <= box[2] + margin)
        inside &= (z >= box[1] - margin) & (z <= box[3] + margin)
        inside = np.flatnonzero(inside)
        inside = inside[np.argsort(some[inside])]  # the order does not depend on the axis
        return np.column_stack([x[inside], z[inside]]), depth[inside]

    @cached_property
    def _rays(self) -> bool:
        """Whether any line of sight is known."""
        return bool(self.slope.any())

    @cached_property
    def _by_place(self) -> list[tuple[Float, Int, Int]]:
        """Where beams cross the plane y = 0, rising x or z (k,) m, their numbers, and those of steep ones."""
        found = []
        for place, slope in zip(self.q[::2], self.slope, strict=True):
            flat = np.abs(slope) <= _STEEP
            rows, at = np.flatnonzero(flat), (place - slope * self.q[1])[flat]
            order = np.argsort(at)
            found.append((at[order], rows[order], np.flatnonzero(~flat)))
        return found

    def thinned(self, most: int) -> "FacadeBeams":
        """Returns about `most` beams, which are enough to tell shares, or all where there are no more."""
        if self.q.shape[1] <= most:
            return self
        # by depth and height alone: in a mirrored facade they are the same
        some = drawn(self.q[1:].T, most)
        return FacadeBeams(*(np.ascontiguousarray(v[:, some]) for v in (self.q, self.slope)))


def bend(facade: Facade, x: Float) -> Float:
    """Returns the depth y (n,) m of a bent wall at x (n,) m: a parabola that touches its plane, or 0."""
    sagitta, sigma = facade.curvature
    if abs(sagitta) < max(TOLERANCES.bent_sigmas * sigma, 3.0 * facade.roughness):
        return np.zeros_like(x)
    x0, _, x1, _ = facade.extent
    u = (x - (x0 + x1) / 2) / max((x1 - x0) / 2, 1e-9)
    return np.asarray(-sagitta * u * u)
