"""Parts of a scan: cropped to bounds, thinned to a resolution; and how densely its points lie."""

from dataclasses import replace

import numpy as np

from frontage.errors import InputError
from frontage.model import Scan

_MOST_CELLS = 2.0**62  # that an int64 can number


def require_box(bounds: tuple[float, ...] | None) -> None:
    """Raises InputError unless bounds are 4 or 6 finite numbers, every minimum less than its maximum."""
    if bounds is None:
        return
    b = np.asarray(bounds)
    if b.shape not in ((4,), (6,)) or b.dtype.kind not in "iuf" or not np.isfinite(b).all():
        raise InputError(f"bounds {bounds}: give four or six finite numbers, the minima first")
    if (b[: len(b) // 2] >= b[len(b) // 2 :]).any():
        raise InputError(f"bounds {bounds}: a minimum is not less than its maximum; give the minima first")


def require_resolution(resolution: float | None) -> None:
    """Raises InputError unless a resolution is a positive, finite length."""
    if resolution is None:
        return
    r = np.asarray(resolution)
    if r.shape or r.dtype.kind not in "iuf" or not (np.isfinite(r) and r > 0):
        raise InputError(f"resolution {resolution}: give a positive length in metres")


def cropped(scan: Scan, bounds: tuple[float, ...]) -> Scan:
    """The points within (x0, y0, x1, y1) or (x0, y0, z0, x1, y1, z1) m world.

    A scan that loses points also loses its grid: a beam that was cropped away is not a beam without return.

    Raises InputError for bounds that are not finite or reversed.
    """
    require_box(bounds)
    k = len(bounds) // 2
    low = np.array(bounds[:k]) - scan.world.origin[:k]
    high = np.array(bounds[k:]) - scan.world.origin[:k]
    keep = ((scan.xyz[:, :k] >= low) & (scan.xyz[:, :k] <= high)).all(axis=1)
    return scan if keep.all() else scan.take(np.flatnonzero(keep))


def thinned(scan: Scan, resolution: float) -> Scan:
    """The first point of every cube of `resolution` m.

    Beams without return are dropped, because they could no longer be compared with the thinned returns.

    Raises InputError unless the resolution is a positive, finite length.
    """
    require_resolution(resolution)
    steps = np.floor((scan.xyz - scan.xyz.min(0)) / resolution)
    size = steps.max(0) + 1
    if np.prod(size) < _MOST_CELLS:
        cell = steps.astype(np.int64) @ np.array([size[1] * size[2], size[2], 1], np.int64)
    else:  # far more cubes than points: they are numbered axis by axis
        cell = np.unique(steps, axis=0, return_inverse=True)[1].reshape(-1)
    _, first = np.unique(cell, return_index=True)
    keep = np.zeros(len(scan), bool)
    keep[first] = True
    return replace(scan.take(np.flatnonzero(keep)), no_returns=())


def spacing(scan: Scan, sample: int = 2000) -> float:
    """Median distance in m of a point to its nearest neighbour, at about `sample` points; 0 for one point."""
    from scipy.spatial import cKDTree

    if len(scan) < 2:
        return 0.0
    tree = cKDTree(scan.xyz, balanced_tree=False, compact_nodes=False)
    distance, _ = tree.query(scan.xyz[:: max(1, len(scan) // sample)], k=2)
    return float(np.median(np.asarray(distance)[:, 1]))
