"""Distances and winding numbers of points, segments and triangles (float64, metres)."""

import numpy as np

from frontage.geometry.arrays import Array, Float

_BLOCK = 400_000  # point-triangle pairs that are computed at a time
TINY = 1e-300  # keeps divisions by the length of a degenerate segment or normal finite


def to_segments(p: Float, a: Float, b: Float) -> Float:
    """Returns the distance (n,) of points (n, d) to their segments from a to b, each (n, d)."""
    along = b - a
    length = np.maximum(np.einsum("ni,ni->n", along, along), TINY)
    t = np.clip(np.einsum("ni,ni->n", p - a, along) / length, 0, 1)
    return np.asarray(np.linalg.norm(p - a - t[:, None] * along, axis=1))


def to_closest_triangle(points: Float, corners: Float) -> tuple[Float, Array]:
    """Returns the distance (n,) of points (n, 3) to the closest triangle (t, 3, 3), and its index (n,)."""
    best, which = np.full(len(points), np.inf), np.zeros(len(points), np.int64)
    step = max(1, _BLOCK // max(len(corners), 1))
    for start in range(0, len(points), step) if len(corners) else ():
        block = points[start : start + step]
        p = np.repeat(block, len(corners), axis=0)
        all_pairs = to_triangles(p, np.tile(corners, (len(block), 1, 1))).reshape(len(block), -1)
        which[start : start + step] = np.argmin(all_pairs, axis=1)
        best[start : start + step] = all_pairs.min(axis=1)
    return best, which


def to_triangles(points: Float, corners: Float) -> Float:
    """Returns the distance (n,) of points (n, 3) to their triangles (n, 3, 3)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    length = np.maximum(np.linalg.norm(normal, axis=1), TINY)
    normal = normal / length[:, None]
    off = np.einsum("ni,ni->n", points - a, normal)
    foot = points - off[:, None] * normal
    inside = np.ones(len(points), np.bool_)
    to_border = np.full(len(points), np.inf)
    for s, t in ((a, b), (b, c), (c, a)):
        inside &= np.einsum("ni,ni->n", np.cross(t - s, foot - s), normal) >= 0
        to_border = np.minimum(to_border, to_segments(points, s, t))
    return np.where(inside, np.abs(off), to_border)


def winding_numbers(points: Float, corners: Float) -> Float:
    """Returns how often closed triangles (t, 3, 3) go around points (n, 3): 1 inside, 0 outside.

    The sum of solid angles (Van Oosterom and Strackee 1983); undefined on the surface itself.
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


def unit_normals(corners: Float) -> Float:
    """Returns the unit normals (n, 3) of triangles (n, 3, 3); zero for degenerate ones."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1), TINY)[:, None])


def double_areas(corners: Float) -> Float:
    """Returns twice the area (n,) of triangles (n, 3, 3)."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(np.linalg.norm(normal, axis=1))
