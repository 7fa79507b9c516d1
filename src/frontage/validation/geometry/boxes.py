"""Finds pairs of triangles that may intersect, by their bounding boxes."""

import numpy as np
import shapely

from frontage.geometry.arrays import Float, Int


def box_pairs(xyz: Float, first: Int, second: Int | None, slack: float) -> Int:
    """Returns the pairs (n, 2) of triangles whose boxes, grown by `slack` (m), intersect.

    `first` and `second` (t, 3) are vertex ids into `xyz` (v, 3); without `second`, the pairs (i < j) within
    `first`. The boxes are aligned with the main walls rather than with the axes of the world, so that they
    are thin.
    """
    turned = xyz @ _wall_aligned(xyz, first).T
    low, high = _boxes(turned, first, slack)
    low2, high2 = (low, high) if second is None else _boxes(turned, second, slack)
    if not len(low) or not len(low2):
        return np.zeros((0, 2), np.int64)
    widest = np.sort(np.argsort(high.max(0) - low.min(0))[1:])
    x, y = (int(k) for k in widest)
    z = 3 - x - y
    tree = shapely.STRtree(shapely.box(low2[:, x], low2[:, y], high2[:, x], high2[:, y]))
    i, j = tree.query(shapely.box(low[:, x], low[:, y], high[:, x], high[:, y]))
    meet = (low[i, z] <= high2[j, z]) & (low2[j, z] <= high[i, z])
    if second is None:
        meet &= i < j
    pairs = np.stack([i[meet], j[meet]], axis=1)
    return np.asarray(pairs[np.lexsort(pairs.T[::-1])])


def _boxes(xyz: Float, triangles: Int, slack: float) -> tuple[Float, Float]:
    """Returns the lower and the upper corners (t, 3) of the boxes of triangles."""
    corners = xyz[triangles]
    return corners.min(1) - slack / 2, corners.max(1) + slack / 2


def _wall_aligned(xyz: Float, triangles: Int) -> Float:
    """Returns the rotation (3, 3) about the vertical that makes most wall area parallel to an axis."""
    a, b, c = (xyz[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    angle, weight = np.arctan2(normal[:, 1], normal[:, 0]), np.hypot(normal[:, 0], normal[:, 1])
    turn = np.arctan2(weight @ np.sin(4 * angle), weight @ np.cos(4 * angle)) / 4
    s, c2 = np.sin(turn), np.cos(turn)
    return np.array([[c2, s, 0.0], [-s, c2, 0.0], [0.0, 0.0, 1.0]])
