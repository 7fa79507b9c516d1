"""The link between local coordinates, in which everything is computed, and the world."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, Int, freeze


@dataclass(frozen=True, eq=False)
class WorldRef:
    """World = local + origin, in a projected metric CRS with z up.

    `origin` (3,) int64, whole metres, so that float64 local coordinates lose nothing at UTM size.
    `crs` is an authority code ("EPSG:25832", "EPSG:25832+7837") or WKT; None when the data has no CRS.
    """

    origin: Int
    crs: str | None = None

    def __post_init__(self) -> None:
        freeze(self, origin=((3,), np.int64))

    def to_world(self, xyz_local: Float) -> Float:
        """Local (..., 3) m to world (..., 3) m."""
        return np.asarray(xyz_local, np.float64) + self.origin

    def to_local(self, xyz_world: Float) -> Float:
        """World (..., 3) m to local (..., 3) m."""
        return np.asarray(xyz_world, np.float64) - self.origin
