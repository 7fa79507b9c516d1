"""Thin a building's points to equal area, and measure their spacing and noise."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Array, Float, Int
from frontage.geometry.plane import facade_axes, plane_offsets
from frontage.model.building import Building
from frontage.model.scan import Scan

_BLOCK_POINTS = 16384  # points at a time, so that a block stays in the processor's cache
_MOST_SEARCHED = 200_000  # points; the search looks at one point per voxel of a larger cloud
_DENSE_CELLS = 40_000_000  # voxels, above which a table of all of them costs more than a sort
_WELL_FILLED = 4  # points per voxel, on average, that show a dense cloud without measuring its spacing
_MOST_FOR_NOISE = 500_000  # points that the noise is measured on
_LEAST_IN_CUBE = 12  # points that a plane is fitted to
_UNKNOWN_NOISE_M = 0.02  # m, assumed for a cloud without a flat upright piece
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
        """Returns the points within `reach` m of a plane in its coordinates. This is the one pass over all
        points.
        """
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


def building_points(scan: Scan, building: Building) -> tuple[Float, Int]:
    """Returns the finite points (n, 3) m local of a building and their indices (n,) in the scan."""
    index = building.index
    is_whole_scan = len(index) == len(scan) and np.array_equal(index, np.arange(len(scan)))
    xyz = scan.xyz if is_whole_scan else np.take(scan.xyz, index, axis=0)
    if not np.isfinite(xyz.sum()):  # any NaN or infinity makes the sum one too
        finite = np.isfinite(xyz).all(1)
        index, xyz = index[finite], xyz[finite]
    return xyz, index


def columns(xyz: Float, axes: Float) -> Float:
    """Returns points (n, 3) times axes (3, 3), stored by column, because every later step reads one
    coordinate.
    """
    return np.asarray((axes.T @ xyz.T).T, np.float64)


def voxel_of(xyz: Float, cell: float) -> tuple[Int, int]:
    """Returns the voxel number (n,) of every point (x fastest, z slowest) and how many voxels their box has."""
    # column by column: numpy's reduction over the long axis of (n, 3) is three times slower
    low, high = (np.array([extreme(xyz[:, k]) for k in range(3)]) for extreme in (np.min, np.max))
    size = ((high - low) * (1.0 / cell)).astype(np.int64) + 1
    stride = np.array([1, size[0], size[0] * size[1]])
    flat = np.empty(len(xyz), np.int64)
    for start in range(0, len(xyz), _BLOCK_POINTS):  # a block stays in the processor's cache
        block = xyz[start : start + _BLOCK_POINTS] - low
        block *= 1.0 / cell
        flat[start : start + _BLOCK_POINTS] = block.astype(np.int64) @ stride  # truncates, as all are >= 0
    return flat, int(size[0]) * int(size[1]) * int(size[2])


def voxel_first(xyz: Float, cell: float) -> Int:
    """Returns the first point (k,) int64 of every occupied voxel, in voxel order (z slowest)."""
    flat, total = voxel_of(xyz, cell)
    if total > _DENSE_CELLS:
        return np.asarray(np.unique(flat, return_index=True)[1], np.int64)
    table = np.full(total, -1, np.int32)
    # the last one written is the first point
    table[flat[::-1]] = np.arange(len(flat) - 1, -1, -1, dtype=np.int32)
    return table[np.flatnonzero(table >= 0)].astype(np.int64)


def surface_spacing(xyz: Float, rng: np.random.Generator, windows: int = 8, wanted: int = 400) -> float:
    """Estimates the median distance (m) from a point to its nearest neighbour, in a few random
    neighbourhoods.

    Coincident points (merged overlaps) do not count. A tree of the whole cloud is never needed.
    """
    if len(xyz) <= 20_000:
        return _median_positive(np.asarray(cKDTree(xyz).query(xyz, k=2)[0])[:, 1])
    some = xyz[:: max(1, len(xyz) // 50_000)]
    rank = min(max(int(wanted * len(some) / len(xyz)), 8), len(some) - 1)
    found = []
    for seed in xyz[rng.choice(len(xyz), windows, replace=False)]:
        reach = float(np.partition(((some - seed) ** 2).sum(1), rank)[rank]) ** 0.5
        near = xyz[np.abs(xyz[:, 0] - seed[0]) < reach]
        near = near[(np.abs(near[:, 1:] - seed[1:]) < reach).all(1)]
        inner = near[(np.abs(near - seed) < 0.7 * reach).all(1)]
        if len(near) > 2 and len(inner):
            found.append(np.asarray(cKDTree(near).query(inner, k=2)[0])[:, 1])
    return _median_positive(np.concatenate(found)) if found else float("nan")


def _median_positive(distance: Array) -> float:
    """Median (m) of the finite distances between points that do not coincide; NaN when there are none."""
    good = distance[np.isfinite(distance) & (distance > 1e-6)]
    return float(np.median(good)) if len(good) else float("nan")


def surface_noise(xyz: Float, cell: float, rng: np.random.Generator, cubes: int = 1000) -> float:
    """Estimates the robust sigma (m) of points (n, 3) about upright planes fitted in cubes of side `cell` m.

    This is range noise with local roughness. It is the lower quartile over those cubes whose points are
    upright and flat (thickness below a fifth of the width), because bushes, rooms and mouldings can only add
    to it. Returns 2 cm when there are no such cubes.
    """
    xyz = xyz[:: len(xyz) // _MOST_FOR_NOISE + 1]
    rows, start = _cubes(xyz, cell, rng, cubes)
    size = np.diff(start, append=len(rows))
    near = xyz[rows]
    near = near - np.repeat(np.add.reduceat(near, start) / size[:, None], size, axis=0)
    moments = np.add.reduceat(near[:, :, None] * near[:, None, :], start)[size >= _LEAST_IN_CUBE]
    size = size[size >= _LEAST_IN_CUBE]
    values, vectors = np.linalg.eigh(moments / size[:, None, None])
    upright_and_flat = (np.abs(vectors[:, 2, 0]) < 0.35) & (values[:, 0] < values[:, 1] / 25.0)
    free = size[upright_and_flat] - 3.0
    thickness = np.sqrt(np.maximum(values[upright_and_flat, 0], 0.0) * size[upright_and_flat] / free)
    thickness /= 1.0 - 0.6745 / np.sqrt(2.0 * free)  # the lower quartile of a sigma estimated from so few
    return float(np.quantile(thickness, 0.25)) if len(thickness) >= 5 else _UNKNOWN_NOISE_M


def _cubes(xyz: Float, cell: float, rng: np.random.Generator, cubes: int) -> tuple[Int, Int]:
    """Draws cubes by random points; returns their points (k,) sorted by cube and where each cube begins."""
    flat, total = voxel_of(xyz, cell)
    seeds = flat[rng.integers(0, len(flat), cubes)]
    if total > _DENSE_CELLS:
        held = np.isin(flat, seeds)
    else:
        table = np.zeros(total, np.bool_)
        table[seeds] = True
        held = table[flat]
    rows = np.flatnonzero(held)
    rows = rows[np.argsort(flat[rows], kind="stable")]
    return rows, np.flatnonzero(np.diff(flat[rows], prepend=-1))


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
