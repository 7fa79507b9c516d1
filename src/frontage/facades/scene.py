"""What every step of facade finding looks at: the scan, the building's cloud, its ground and the options."""

from dataclasses import dataclass, field
from functools import cached_property

from frontage.facades.cloud import BuildingCloud
from frontage.facades.options import FacadeOptions
from frontage.facades.voxels import drawn_voxels
from frontage.geometry.arrays import Float
from frontage.model.scan import Scan

_STEP_M = 0.10  # m that the last step may move the plane at the facade's ends
_MOST_AROUND = 200_000  # points of the surroundings
_AROUND_CELL_M = 0.25  # m between them


@dataclass(frozen=True, eq=False)
class FacadeScene:
    """One building in its surroundings.

    scan      the working cloud, the building and everything around it
    cloud     the building's own points
    ground_z  m local, height of the ground at the building
    """

    scan: Scan
    cloud: BuildingCloud
    ground_z: float = 0.0
    options: FacadeOptions = field(default_factory=FacadeOptions)

    @property
    def reach(self) -> float:
        """How far (m) from a plane a facade's points may lie, with room for the plane's last step."""
        return max(self.options.depth_front, self.options.depth_back) + _STEP_M

    @cached_property
    def around(self) -> Float:
        """Points (k, 3) m local of building and surroundings, evenly spaced: what lines of sight can meet."""
        return drawn_voxels(self.scan.xyz, max(_AROUND_CELL_M, self.cloud.cell), _MOST_AROUND)
