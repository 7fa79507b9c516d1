"""The building's points, thinned so that every one stands for the same area,
with spacing and noise measured.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Array, Float, Int
from frontage.geometry.plane import facade_axes, plane_offsets

_BLOCK = 16_384  # points
_MOST_SEARCHED = 200_000  # points
_DENSE_CELLS = 40_000_000  # above, a table of all voxels costs more than a sort
_WELL_FILLED = 4  # points per voxel, on average, that say "dense" without measuring
_MOST_FOR_NOISE = 500_000  # points
_LEAST_IN_CUBE = 12  # points to fit a plane to
_UNKNOWN = 0.02  # m, noise of a cloud without a flat upright piece
_FINEST = 0.10  # m, cell of the facade raster where the points are dense enough


@dataclass(frozen=True, eq=False)
class Cloud:
    """What facade finding works on.

    xyz      (n, 3) m local, all points of the building; index (n,) of them in the scan
    thin     (k,) int64 into `xyz`: one point per voxel of side `cell`
    cell     m, the voxel; `raster` m, cell of the facade raster; `noise` m, range noise and local roughness
    """

    xyz: Float
    index: Int
    thin: Int
    cell: float
    raster: float
    noise: float

    def bounded(self) -> "Cloud":
        """What the search looks at: all points, or of more than 200 k one per voxel.

        A raster of such points needs cells of two voxels: a turned raster of single ones has empty cells.
        """
        if len(self.xyz) <= _MOST_SEARCHED:
            return self
        rows = np.arange(len(self.thin))
        xyz = np.take(self.xyz, self.thin, axis=0)
        return Cloud(xyz, self.index[self.thin], rows, self.cell, 2.0 * self.raster, self.noise)

    def slab(self, normal: Float, point: Float, reach: float) -> "Slab":
        """The points within `reach` m of a plane, in its coordinates: the one pass over all points."""
        offsets = plane_offsets(self.xyz, normal, point)
        rows = np.flatnonzero(np.abs(offsets, out=offsets) < reach)
        axes = facade_axes(normal)
        return Slab(rows, columns(np.take(self.xyz, rows, axis=0) - point, axes), axes, point)

    @property
    def threshold(self) -> float:
        """Inlier distance of the search in m: 3 sigma of the measured noise, 2 cm to 10 cm."""
        return float(np.clip(3.0 * self.noise, 0.02, 0.10))


@dataclass(frozen=True, eq=False)
class Slab:
    """Points beside a plane.

    rows         (k,) int64 into Cloud.xyz
    q            (k, 3) m, coordinates in the frame `axes` (3, 3), columns x, y, z, with origin `point` (3,)
    """

    rows: Int
    q: Float
    axes: Float
    point: Float

    def at(self, places: Int) -> Float:
        """Coordinates (k, 3) of the points at `places` (k,) of `rows`, stored by column."""
        return np.stack([np.take(self.q[:, k], places) for k in range(3)]).T

    def moved(self, axes: Float, point: Float) -> "Slab":
        """The same points in another frame: a small rigid motion of `q`, exact."""
        turn = self.axes.T @ axes
        q = columns(self.q, turn)
        q -= (self.axes.T @ (point - self.point)) @ turn
        return Slab(self.rows, q, axes, point)


def columns(xyz: Float, axes: Float) -> Float:
    """Points (n, 3) times axes (3, 3), stored by column: every later step reads one coordinate at a time."""
    return np.asarray((axes.T @ xyz.T).T, np.float64)


def voxel_of(xyz: Float, cell: float) -> tuple[Int, int]:
    """Voxel number (n,) of every point, x fastest, z slowest, and how many voxels their box has."""
    # column by column: numpy's reduction over the long axis of (n, 3) is three times slower
    low, high = (np.array([extreme(xyz[:, k]) for k in range(3)]) for extreme in (np.min, np.max))
    size = ((high - low) * (1.0 / cell)).astype(np.int64) + 1
    stride = np.array([1, size[0], size[0] * size[1]])
    flat = np.empty(len(xyz), np.int64)
    for start in range(0, len(xyz), _BLOCK):  # a block stays in the processor's cache
        block = xyz[start : start + _BLOCK] - low
        block *= 1.0 / cell
        flat[start : start + _BLOCK] = block.astype(np.int64) @ stride  # truncation of positive numbers
    return flat, int(size[0]) * int(size[1]) * int(size[2])


def voxel_first(xyz: Float, cell: float) -> Int:
    """First point (k,) int64 of every occupied voxel, in voxel order (z slowest)."""
    flat, total = voxel_of(xyz, cell)
    if total > _DENSE_CELLS:
        return np.asarray(np.unique(flat, return_index=True)[1], np.int64)
    table = np.full(total, -1, np.int32)
    # the last one written is the first point
    table[flat[::-1]] = np.arange(len(flat) - 1, -1, -1, dtype=np.int32)
    return table[np.flatnonzero(table >= 0)].astype(np.int64)


def surface_spacing(xyz: Float, rng: np.random.Generator, windows: int = 8, wanted: int = 400) -> float:
    """Median distance in m from a point to its nearest other one, from a few random neighbourhoods.

    Points that coincide (merged overlaps) do not count. Never needs a tree of the whole cloud.
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
    good = distance[np.isfinite(distance) & (distance > 1e-6)]
    return float(np.median(good)) if len(good) else float("nan")


def surface_noise(xyz: Float, cell: float, rng: np.random.Generator, cubes: int = 1000) -> float:
    """Robust sigma in m of points (n, 3) about upright planes fitted in cubes of side `cell`: noise with
    local roughness.

    The lower quartile over those cubes whose points are flat (thickness below a fifth of the width) and
    upright: bushes, rooms and mouldings only ever add. 2 cm when there are none.
    """
    xyz = xyz[:: len(xyz) // _MOST_FOR_NOISE + 1]
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
    start = np.flatnonzero(np.diff(flat[rows], prepend=-1))
    size = np.diff(start, append=len(rows))
    near = xyz[rows]
    near = near - np.repeat(np.add.reduceat(near, start) / size[:, None], size, axis=0)
    moments = np.add.reduceat(near[:, :, None] * near[:, None, :], start)[size >= _LEAST_IN_CUBE]
    size = size[size >= _LEAST_IN_CUBE]
    values, vectors = np.linalg.eigh(moments / size[:, None, None])
    good = (np.abs(vectors[:, 2, 0]) < 0.35) & (values[:, 0] < values[:, 1] / 25.0)
    free = size[good] - 3.0
    thickness = np.sqrt(np.maximum(values[good, 0], 0.0) * size[good] / free)
    thickness /= 1.0 - 0.6745 / np.sqrt(2.0 * free)  # the lower quartile of a sigma estimated from so few
    return float(np.quantile(thickness, 0.25)) if len(thickness) >= 5 else _UNKNOWN


def prepare(xyz: Float, index: Int, rng: np.random.Generator, sigma_range: float | None) -> Cloud:
    """Thin the points (n, 3) and measure their noise;
    the voxel is 10 cm, or two spacings of a sparser cloud.
    """
    cell = _FINEST
    thin = voxel_first(xyz, cell)
    if len(xyz) < _WELL_FILLED * len(thin):  # sparse: a cell must hold a point where there is wall
        spacing = surface_spacing(xyz, rng)
        cell = max(_FINEST, 2.0 * spacing) if np.isfinite(spacing) else _FINEST
        thin = voxel_first(xyz, cell)
    noise = surface_noise(xyz, 2.0 * cell, rng)
    return Cloud(xyz, index, thin, cell, cell, max(noise, sigma_range or 0.0, 0.001))
