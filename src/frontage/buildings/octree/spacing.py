"""Measure how far apart the points of a cloud lie."""

import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Float, Int, distinct, drawn, extent
from frontage.model.canonical import canonical_order

_CUBES = 240  # places of the cloud that are examined
_PER_CUBE = 400  # query points of each place
_DRAWN = 50_000  # points that the places are chosen from
_CHUNK = 1 << 14  # points at a time, so that temporaries stay in the processor's cache


def measure_spacing(xyz: Float) -> tuple[float, float]:
    """Returns median and 80 % quantile (m), over places of the cloud, of the spacing of its points.

    The cloud (n, 3) m is cut along its canonical order into equally long pieces, and a few query points are
    taken from each. Every place has one vote, so the dense spot in front of the scanner does not decide for
    the whole street. Coincident points (overlapping scans) do not count as neighbours.
    """
    n = len(xyz)
    if n < 2:
        return 0.0, 0.0
    if n <= 200_000:
        distance = _nearest(xyz, xyz[drawn(xyz, 20_000)])
        return _median(distance), _quantile(distance)
    some = xyz[drawn(xyz, _DRAWN)]
    some = some[canonical_order(some)]
    seeds = some[np.linspace(0, len(some) - 1, _CUBES).astype(np.int64)]
    half = _half_width(some, seeds)
    low = extent(xyz)[0]
    wanted = distinct(_code(seeds, low, 2 * half))
    near, cube = _inside(xyz, low, 2 * half, wanted)
    order = canonical_order(xyz[near])
    order = order[np.argsort(cube[order], kind="stable")]
    near, cube = near[order], cube[order]
    start = np.searchsorted(cube, np.arange(len(wanted)))
    rank = np.arange(len(cube)) - start[cube]
    size = np.bincount(cube, minlength=len(wanted))
    query = rank % np.maximum(size // _PER_CUBE, 1)[cube] == 0
    distance = _nearest(xyz[near], xyz[near[query]])
    medians = np.array(
        [
            _median(part)
            for part in np.split(distance, np.searchsorted(cube[query], np.arange(1, len(wanted))))
        ]
    )
    medians = medians[np.isfinite(medians)]
    return _median(medians), _quantile(medians)


def _half_width(xyz: Float, seeds: Float) -> float:
    """Returns half the edge (m) of cubes that hold some hundred points, from the density at the seeds."""
    distance = np.asarray(cKDTree(xyz).query(seeds, k=5)[0])
    return max(float(np.median(distance[:, -1])), 1e-6)


def _code(xyz: Float, low: Float, edge: float) -> Int:
    """Returns the key (n,) of the cube of `edge` m, counted from `low` (3,) m, that holds each point."""
    key = np.zeros(len(xyz), np.int64)
    for a in range(3):
        key = (key << 21) + ((xyz[:, a] - low[a]) / edge).astype(np.int64)
    return key


def _inside(xyz: Float, low: Float, edge: float, wanted: Int) -> tuple[Int, Int]:
    """Returns the points (k,) in the cubes with sorted keys `wanted`, and the number of each one's cube."""
    near, cube = [], []
    for start in range(0, len(xyz), _CHUNK):
        code = _code(xyz[start : start + _CHUNK], low, edge)
        at = np.minimum(np.searchsorted(wanted, code), len(wanted) - 1)
        hit = np.flatnonzero(wanted[at] == code)
        near.append(start + hit)
        cube.append(at[hit])
    return np.concatenate(near), np.concatenate(cube)


def _nearest(xyz: Float, query: Float) -> Float:
    """Returns the distance (k,) m of each query point to its nearest neighbour; inf where there is none.

    The point itself and its copies do not count.
    """
    distance, _ = cKDTree(xyz).query(query, k=min(4, len(xyz)))
    distance = np.atleast_2d(distance)
    distance[distance < 1e-6] = np.inf
    nearest: Float = distance.min(1)
    return nearest


def _median(d: Float) -> float:
    """Median of the finite distances (m); NaN when there are none."""
    d = d[np.isfinite(d)]
    return float(np.median(d)) if len(d) else float("nan")


def _quantile(d: Float) -> float:
    """80 % quantile of the finite distances (m); NaN when there are none."""
    d = d[np.isfinite(d)]
    return float(np.quantile(d, 0.8)) if len(d) else float("nan")
