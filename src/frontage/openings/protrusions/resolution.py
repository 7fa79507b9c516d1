"""What a scan resolves before a wall: spacing of beams, noise, and the sizes that follow from both."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Float, distinct, freeze
from frontage.openings.boxes import Box
from frontage.openings.protrusions.boxes import cells_of, first_corner

_GAP = 0.15  # m: railings leave no wider gaps between their bars, so that no child falls through
_GAP_POINTS = 4.0  # spacings that points of one surface are apart, at most
_FINE = 0.03  # m, least cell in which area is counted
_HALF = 2.5  # sigmas to either side that a flat front holds
_FINEST = 0.004  # m, least of those sigmas: mouldings and paint
_LONG, _ROWS = 0.5, 3.0  # m, least length of a front; its least height in rows of beams
_LEAST_HEIGHT = 0.04  # m, least height of a front
_TILE = 1.0  # m, side of the tiles in which the spacing is measured
_CELLS = 3.0  # spacings that a cell is wide that tells whether a part of a tile was seen
_FEWEST = 30  # points of a tile that determine a spacing
_SPARSE = 80  # percentile of the tiles' spacings that connects what belongs together


@dataclass(frozen=True, eq=False)
class Resolution:
    """The resolution of a scan on a wall.

    spacing  m between beams
    sigma    m, noise of the surface
    sparse   m, spacing where it is wide
    tiles    (k, 3) m: x, z of the middles of the tiles where the spacing was measured, and the spacing
    """

    spacing: float
    sigma: float
    sparse: float
    tiles: Float

    def __post_init__(self) -> None:
        freeze(self, tiles=((None, 3), np.float64))

    @classmethod
    def of(cls, wall: Float, spacing: float, sigma: float) -> "Resolution":
        """Measures it on the points (n, 2) x, z m of a wall, by tiles: the root of the seen area per point.

        `spacing` m is that of the whole wall: no tile counts as finer.
        """
        if len(wall) == 0:
            return cls(spacing, sigma, spacing, np.empty((0, 3)))
        side, low = _CELLS * spacing, first_corner(wall, _TILE)
        tile, cell = cells_of(wall, _TILE), cells_of(wall, side)
        high, rows = int(tile[:, 1].max()) + 1, int(cell[:, 1].max()) + 1
        across, up = np.divmod(distinct(cell[:, 0] * rows + cell[:, 1]), rows)
        middle = first_corner(wall, side) + (np.column_stack([across, up]) + 0.5) * side
        own = np.clip(np.floor((middle - low) / _TILE).astype(np.int64), 0, tile.max(0))
        number = np.bincount(tile[:, 0] * high + tile[:, 1])
        seen = np.bincount(own[:, 0] * high + own[:, 1], minlength=len(number))
        full = np.flatnonzero(number >= _FEWEST)
        place = low + (np.column_stack(np.divmod(full, high)) + 0.5) * _TILE
        apart = np.maximum(np.sqrt(seen[full] * side**2 / number[full]), spacing)
        sparse = float(np.percentile(apart, _SPARSE)) if len(apart) else spacing
        return cls(spacing, sigma, sparse, np.column_stack([place, apart]))

    def near(self, box: Box) -> "Resolution":
        """Returns it with the spacing of the tiles that a box touches."""
        if len(self.tiles) == 0:
            return self
        away = np.maximum(np.array(box[:2]) - self.tiles[:, :2], self.tiles[:, :2] - np.array(box[2:]))
        distance = np.maximum(away, 0.0).max(1)
        close = distance <= max(float(distance.min()), _TILE)
        return replace(self, spacing=float(np.median(self.tiles[close, 2])))

    @property
    def half(self) -> float:
        """Half the thickness m of a flat front: how far its points lie to either side."""
        return _HALF * max(self.sigma, _FINEST)

    @property
    def gap(self) -> float:
        """Distance m within which points belong together, where the wall is seen sparsely, too."""
        return max(_GAP, _GAP_POINTS * self.sparse)

    @property
    def cell(self) -> float:
        """Side m of the cells in which area is counted."""
        return max(2.0 * self.spacing, _FINE)

    @property
    def least(self) -> tuple[float, float]:
        """Least length and height m of a front: ten points along, three rows of beams across."""
        return max(_LONG, 10.0 * self.spacing), max(_LEAST_HEIGHT, _ROWS * self.spacing)
