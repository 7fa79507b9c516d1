"""Measure the spacing and the noise of a building's points."""

import numpy as np
from scipy.spatial import cKDTree

from frontage.facades.voxels import DENSE_CELLS, voxel_of
from frontage.geometry.arrays import Array, Float, Int

_MOST_FOR_NOISE = 500_000  # points that the noise is measured on
_LEAST_IN_CUBE = 12  # points that a plane is fitted to
_UNKNOWN_NOISE_M = 0.02  # m, assumed for a cloud without a flat upright piece


def surface_spacing(xyz: Float, rng: np.random.Generator, windows: int = 8, wanted: int = 400) -> float:
    """Estimates the median distance (m) from a point to its nearest neighbour.

    A few random neighbourhoods are examined, without a tree of the whole cloud. Coincident points (merged
    overlaps) do not count.
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
    if total > DENSE_CELLS:
        held = np.isin(flat, seeds)
    else:
        table = np.zeros(total, np.bool_)
        table[seeds] = True
        held = table[flat]
    rows = np.flatnonzero(held)
    rows = rows[np.argsort(flat[rows], kind="stable")]
    return rows, np.flatnonzero(np.diff(flat[rows], prepend=-1))
