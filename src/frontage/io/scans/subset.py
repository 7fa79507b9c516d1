"""Parts of a scan: cropped to bounds, thinned to a resolution; and how densely its points lie."""

from dataclasses import replace

import numpy as np

from frontage.model import Scan


def cropped(scan: Scan, bounds: tuple[float, ...]) -> Scan:
    """The points within (x0, y0, x1, y1) or (x0, y0, z0, x1, y1, z1) m world.

    A scan that loses points also loses its grid: a beam that was cropped away is not a beam without return.
    """
    k = len(bounds) // 2
    low = np.array(bounds[:k]) - scan.world.origin[:k]
    high = np.array(bounds[k:]) - scan.world.origin[:k]
    keep = ((scan.xyz[:, :k] >= low) & (scan.xyz[:, :k] <= high)).all(axis=1)
    return scan if keep.all() else scan.take(np.flatnonzero(keep))


def thinned(scan: Scan, resolution: float) -> Scan:
    """The first point of every cube of `resolution` m.

    Beams without return are dropped, because they could no longer be compared with the thinned returns.
    """
    cell = np.floor((scan.xyz - scan.xyz.min(0)) / resolution).astype(np.int64)
    size = cell.max(0) + 1
    _, first = np.unique((cell[:, 0] * size[1] + cell[:, 1]) * size[2] + cell[:, 2], return_index=True)
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
