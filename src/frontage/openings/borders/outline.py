"""An opening as it was measured, before it has a kind and a number."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.estimate import Estimate
from frontage.openings.borders.locate import Border
from frontage.openings.borders.shapes import bare_ring, ring_of
from frontage.openings.boxes import Box

_IN_PLACE = (0, 2, 1, 3)  # where left, right, bottom and top stand in a place x0, z0, x1, z1


@dataclass(frozen=True, eq=False)
class Outline:
    """The borders, shape and depth of an opening.

    place       x0, z0, x1, z1 m, its bounding box
    rise        m, top less springing; 0 = straight head
    covariance  (5, 5) m2 of left, right, bottom, top and rise
    borders     left, right, bottom, top as straight borders, each by itself
    passes      share of the beams that end more than a metre behind
    wall        depth y m of the wall around it, None where nothing determines it
    pooled      whether most of what is known of a border comes from other openings
    sunken      share of the beams behind the wall that end more than half a brick behind it
    behind      beams that end behind the wall, as a share of those that wall in its place would return
    """

    shape: str
    place: Box
    rise: float
    covariance: Float
    borders: tuple[Border, ...]
    depth: Estimate[float] | None
    passes: float
    wall: float | None = None
    pooled: bool = False
    sunken: float = 0.0
    behind: float = 0.0

    @property
    def has_rays(self) -> bool:
        """Whether lines of sight are known at any border."""
        return any(b.edge.rays for b in self.borders)

    @property
    def sure(self) -> float:
        """Share of the borders that are seen beyond doubt."""
        return float(np.mean([b.is_seen for b in self.borders]))

    def with_foot(self, at: float, sigma: float) -> "Outline":
        """Returns the outline with its foot at z = `at` m, known to `sigma` m."""
        return self._moved(2, at, sigma)

    def with_border(self, side: int, at: float, sigma: float) -> "Outline":
        """Returns the outline with one of `borders`, the number `side`, at `at` m, known to `sigma` m."""
        borders = list(self.borders)
        borders[side] = replace(borders[side], at=at, sigma=sigma)
        return replace(self._moved(side, at, sigma), borders=tuple(borders))

    def _moved(self, side: int, at: float, sigma: float) -> "Outline":
        """Returns the outline with one side of its place at `at` m, and the error of that side."""
        x0, z0, x1, z1 = (at if k == _IN_PLACE[side] else v for k, v in enumerate(self.place))
        covariance = self.covariance.copy()
        covariance[side, :] = covariance[:, side] = 0.0
        covariance[side, side] = sigma**2
        return replace(self, place=(x0, z0, x1, z1), covariance=covariance)

    @property
    def bare_ring(self) -> Float:
        """The ring (k, 2) m, without its covariance."""
        return bare_ring(self.shape, self.place, self.rise)

    @property
    def ring(self) -> tuple[Float, Float]:
        """The ring (k, 2) m and its covariance (2k, 2k) m2."""
        ring, weights = ring_of(self.shape, self.place, self.rise)
        return ring, weights @ self.covariance @ weights.T
