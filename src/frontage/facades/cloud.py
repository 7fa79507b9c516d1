"""The cloud of one building: all points, a thinned copy of equal density, and the measured noise."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from frontage.facades.noise import surface_noise, surface_spacing
from frontage.facades.voxels import voxel_first
from frontage.geometry.arrays import Float, Int
from frontage.geometry.plane import facade_axes, plane_offsets

_MOST_SEARCHED = 200_000  # points; the search looks at one point per voxel of a larger cloud
_WELL_FILLED = 4  # points per voxel, on average, that show a dense cloud without measuring its spacing
_FINEST_CELL_M = 0.1  # m, cell of the facade raster where the points are dense enough


@dataclass(frozen=True, eq=False)
class BuildingCloud:
    """The points of one building.

    xyz     (n, 3) m local, all points; `index` (n,) int64 of them in the scan
    thin    (k,) int64 into `xyz`: one point per voxel of side `cell`
    cell    m, side of the voxels
    raster  m, side of a cell of the facade raster
    noise   m, standard deviation of range noise and local roughness together
    """

    xyz: Float
    index: Int
    thin: Int
    cell: float
    raster: float
    noise: float

    @cached_property
    def thinned(self) -> Float:
        """The thinned points (k, 3) m."""
        return np.take(self.xyz, self.thin, axis=0)

    def bounded(self) -> "BuildingCloud":
        """Returns the cloud that the search looks at: all points, or one per voxel of more than 200,000.

        The raster of such a thinned cloud has cells of two voxels, because finer cells of a turned raster
        would be empty.
        """
        if len(self.xyz) <= _MOST_SEARCHED:
            return self
        rows = np.arange(len(self.thin))
        xyz = np.take(self.xyz, self.thin, axis=0)
        return BuildingCloud(xyz, self.index[self.thin], rows, self.cell, 2.0 * self.raster, self.noise)

    def slab(self, normal: Float, point: Float, reach: float) -> "Slab":
        """Returns the points within `reach` m of a plane, in its coordinates, in one pass over all points."""
        offsets = plane_offsets(self.xyz, normal, point)
        rows = np.flatnonzero(np.abs(offsets, out=offsets) < reach)
        axes = facade_axes(normal)
        return Slab(rows, columns(np.take(self.xyz, rows, axis=0) - point, axes), axes, point)

    @property
    def threshold(self) -> float:
        """Inlier distance of the search in m: three times the measured noise, between 2 cm and 10 cm."""
        return float(np.clip(3.0 * self.noise, 0.02, 0.10))


@dataclass(frozen=True, eq=False)
class Slab:
    """The points beside a plane.

    rows   (k,) int64 into BuildingCloud.xyz
    q      (k, 3) m, their coordinates in the plane's frame
    axes   (3, 3), columns X, Y, Z of that frame; `point` (3,) m local, its origin
    """

    rows: Int
    q: Float
    axes: Float
    point: Float

    def at(self, places: Int) -> Float:
        """Returns the coordinates (k, 3) m of the points at `places` (k,) of `rows`, stored by column."""
        return np.stack([np.take(self.q[:, k], places) for k in range(3)]).T

    def moved(self, axes: Float, point: Float) -> "Slab":
        """Returns the same points in another frame; `q` undergoes a rigid motion."""
        turn = self.axes.T @ axes
        q = columns(self.q, turn)
        q -= (self.axes.T @ (point - self.point)) @ turn
        return Slab(self.rows, q, axes, point)


def columns(xyz: Float, axes: Float) -> Float:
    """Returns points (n, 3) times axes (3, 3), stored by column: later steps read one coordinate."""
    return np.asarray((axes.T @ xyz.T).T, np.float64)


def prepare(xyz: Float, index: Int, rng: np.random.Generator, sigma_range: float | None) -> BuildingCloud:
    """Thins the points (n, 3) m and measures their noise.

    The voxel is 10 cm wide, or two spacings of a sparser cloud. `sigma_range` m, the scanner's stated range
    noise, is a lower bound of the noise.
    """
    cell = _FINEST_CELL_M
    thin = voxel_first(xyz, cell)
    if len(xyz) < _WELL_FILLED * len(thin):  # sparse: a cell must hold a point where there is wall
        spacing = surface_spacing(xyz, rng)
        cell = max(_FINEST_CELL_M, 2.0 * spacing) if np.isfinite(spacing) else _FINEST_CELL_M
        thin = voxel_first(xyz, cell)
    noise = surface_noise(xyz, 2.0 * cell, rng)
    return BuildingCloud(xyz, index, thin, cell, cell, max(noise, sigma_range or 0.0, 0.001))
