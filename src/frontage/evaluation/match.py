"""Matches polygons one to one by intersection over union (IoU)."""

from collections.abc import Sequence

import numpy as np
import shapely
from scipy.optimize import linear_sum_assignment

from frontage.geometry.arrays import Float, Int

_LEAST_IOU = 0.1  # below which two polygons are unrelated


def overlap(a: Sequence[Float], b: Sequence[Float]) -> Float:
    """Returns the IoU (len(a), len(b)) of two sets of rings (k, 2)."""
    out = np.zeros((len(a), len(b)))
    if not len(a) or not len(b):
        return out
    p, q = _polygons(a), _polygons(b)
    j, i = shapely.STRtree(p).query(q, predicate="intersects")
    shared = shapely.area(shapely.intersection(p[i], q[j]))
    whole = shapely.area(p[i]) + shapely.area(q[j]) - shared
    out[i, j] = np.where(whole > 0, shared / np.maximum(whole, 1e-12), 0.0)
    return out


def _polygons(rings: Sequence[Float]) -> np.ndarray:
    return np.asarray(shapely.make_valid([shapely.Polygon(r) for r in rings]))


def assign(iou: Float) -> tuple[Int, Int]:
    """Returns rows and columns (m,) of the one-to-one matching of largest total IoU; each IoU is >= 0.1."""
    row, column = linear_sum_assignment(-np.where(iou >= _LEAST_IOU, iou, 0.0))
    kept = iou[row, column] >= _LEAST_IOU
    return row[kept].astype(np.int64), column[kept].astype(np.int64)
