"""The points of the scan in the frame of one facade, and which of them its picture is made from."""

from dataclasses import dataclass, replace
from functools import cached_property

from frontage.geometry.arrays import Array, Bool, picked_rows
from frontage.model import Facade, Scan
from frontage.ortho.cloud import in_facade_frame
from frontage.ortho.gaps import Gaps, local_gaps
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.recess import DEEPEST_REVEAL_M
from frontage.ortho.relief import ReliefMap
from frontage.ortho.standing.find import Standing


@dataclass(frozen=True, eq=False)
class FacadePoints:
    """A scan seen from a facade.

    scan  with n points
    xyz   (n, 3) float32 m in the facade frame
    used  (n,) bool, the points that the picture is made from
    gaps  local distances between the points of the wall
    """

    scan: Scan
    xyz: Array
    used: Bool
    gaps: Gaps

    @cached_property
    def xyz_used(self) -> Array:
        """The points (k, 3) m that the picture is made from."""
        return picked_rows(self.used, self.xyz)

    def on_surface(self, relief: ReliefMap | None) -> "FacadePoints":
        """Leaves out the points behind the surface of their cell, such as those of rooms behind windows."""
        if relief is None:
            return self
        used = self.used.copy()
        used[used] = relief.in_front(self.xyz_used)
        return replace(self, used=used)


def facade_points(
    scan: Scan,
    facade: Facade,
    raster: OrthoRaster,
    standing: Standing,
    options: OrthoOptions,
    xyz: Array | None = None,
) -> FacadePoints:
    """Finds the points of a scan that lie within the raster and within the depth range of the facade.

    Those of what is `standing` free before the facade are no part of it, however near they are. The gaps are
    those of the wall: points in rooms and far in front of the plane do not count. `xyz` are the points
    `in_facade_frame`, where they are known already.
    """
    xyz = in_facade_frame(scan, facade) if xyz is None else xyz
    at, y = raster.pixel(xyz), xyz[:, 1]
    column, row = at.T
    inside = (column >= 0) & (row >= 0) & (column < raster.width) & (row < raster.height)
    used = inside & (y >= -options.front) & (y <= options.back)
    used &= ~standing.holds(xyz, used)
    wall = picked_rows(used & (abs(y) <= DEEPEST_REVEAL_M), at)
    gaps = local_gaps(wall, raster, facade.spacing / raster.gsd)
    return FacadePoints(scan, xyz, used, gaps)
