"""Distances and windings of points and triangles in space (float64, local metres)."""

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.validation.geometry.touching import distance

_BLOCK = 400_000  # point-triangle pairs at a time


def to_triangles(points: Float, corners: Float) -> tuple[Float, Array]:
    """Distance (n,) from points (n, 3) to the closest of triangles (t, 3, 3), and which one it is (n,)."""
    best, which = np.full(len(points), np.inf), np.zeros(len(points), np.int64)
    step = max(1, _BLOCK // max(len(corners), 1))
    for start in range(0, len(points), step) if len(corners) else ():
        block = points[start : start + step]
        p = np.repeat(block, len(corners), axis=0)
        all_pairs = pairwise(p, np.tile(corners, (len(block), 1, 1))).reshape(len(block), -1)
        which[start : start + step] = np.argmin(all_pairs, axis=1)
        best[start : start + step] = all_pairs.min(axis=1)
    return best, which


def pairwise(points: Float, corners: Float) -> Float:
    """Distance (n,) of points (n, 3) to their triangles (n, 3, 3)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    length = np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
    normal = normal / length[:, None]
    off = np.einsum("ni,ni->n", points - a, normal)
    foot = points - off[:, None] * normal
    inside = np.ones(len(points), np.bool_)
    rim = np.full(len(points), np.inf)
    for s, t in ((a, b), (b, c), (c, a)):
        inside &= np.einsum("ni,ni->n", np.cross(t - s, foot - s), normal) >= 0
        rim = np.minimum(rim, distance(points, s, t))
    return np.where(inside, np.abs(off), rim)


def winding(points: Float, corners: Float) -> Float:
    """How often closed triangles (t, 3, 3) go around points (n, 3): 1 inside, 0 outside.

    Sum of solid angles (Van Oosterom and Strackee 1983); not defined on the surface itself.
    """
    turns = np.zeros(len(points))
    step = max(1, _BLOCK // max(len(corners), 1))
    for start in range(0, len(points), step) if len(corners) else ():
        r = corners[None] - points[start : start + step, None, None]
        size = np.linalg.norm(r, axis=3)
        a, b, c = r[:, :, 0], r[:, :, 1], r[:, :, 2]
        la, lb, lc = size[:, :, 0], size[:, :, 1], size[:, :, 2]
        top = np.einsum("nti,nti->nt", a, np.cross(b, c))
        dots = [np.einsum("nti,nti->nt", p, q) for p, q in ((a, b), (b, c), (c, a))]
        bottom = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
        turns[start : start + step] = np.arctan2(top, bottom).sum(1) / (2 * np.pi)
    return turns
