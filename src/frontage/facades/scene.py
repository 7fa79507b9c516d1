"""What every step of facade finding looks at: the scan, the building's cloud, its ground and the options."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from frontage.facades.cloud import BuildingCloud
from frontage.facades.options import FacadeOptions
from frontage.facades.voxels import drawn_voxels
from frontage.geometry.arrays import Float, Int
from frontage.model.canonical import steady
from frontage.model.scan import Scan

_STEP_M = 0.10  # m that the last step may move the plane at the facade's ends
_MOST_AROUND = 200_000  # points of the surroundings
_AROUND_CELL_M = 0.25  # m between them


@dataclass(frozen=True, eq=False)
class FacadeScene:
    """One building in its surroundings.

    scan      the working cloud, the building and everything around it, in its own frame
    axes      (3, 3), columns: the canonical frame, in which everything else is
    cloud     the building's own points
    ground_z  m, height of the ground at the building
    """

    scan: Scan
    axes: Float
    cloud: BuildingCloud
    ground_z: float = 0.0
    options: FacadeOptions = field(default_factory=FacadeOptions)

    @property
    def reach(self) -> float:
        """How far (m) from a plane a facade's points may lie, with room for the plane's last step."""
        return max(self.options.depth_front, self.options.depth_back) + _STEP_M

    @cached_property
    def around(self) -> Float:
        """Points (k, 3) m of building and surroundings, evenly spaced: what lines of sight can meet."""
        xyz = steady(self.scan.xyz @ self.axes)
        return drawn_voxels(xyz, max(_AROUND_CELL_M, self.cloud.cell), _MOST_AROUND)

    def sensors(self, rows: Int) -> Float:
        """Returns where the sensor stood (k, 3) m for the building's points `rows`; NaN where unknown."""
        return np.asarray(self.scan.sensor_of(self.cloud.index[rows]) @ self.axes)
