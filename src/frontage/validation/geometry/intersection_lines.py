"""Intersections of pairs of triangles as coordinates, in floating point with a noise threshold."""

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float, Int
from frontage.validation.geometry.distances import to_triangles, unit_normals


def intersection_lines(one: Float, other: Float, noise: float) -> list[tuple[int, Float]]:
    """Returns the index of each pair of triangles (n, 3, 3) that intersects, and their common line (k, 3).

    Pairs further apart than `noise` (m) are left out. Coplanar triangles have an area in common; its outline
    is returned.
    """
    n_one, n_other = unit_normals(one), unit_normals(other)
    side_one = np.einsum("nki,ni->nk", one - other[:, :1], n_other)
    side_other = np.einsum("nki,ni->nk", other - one[:, :1], n_one)
    coplanar = (np.abs(side_one).max(1) <= noise) | (np.abs(side_other).max(1) <= noise)
    found = _coplanar_overlaps(one, other, n_one, np.nonzero(coplanar)[0])
    cut = np.nonzero(~coplanar)[0]
    here = _pierce_points(one[cut], other[cut], side_one[cut], noise)
    there = _pierce_points(other[cut], one[cut], side_other[cut], noise)
    spots, valid = np.concatenate([here[0], there[0]], 1), np.concatenate([here[1], there[1]], 1)
    touched = valid.any(1)
    ends = _line_ends(spots[touched], valid[touched])
    found += list(zip(cut[touched].tolist(), ends, strict=True))
    return sorted(found, key=lambda f: f[0])


def _pierce_points(one: Float, other: Float, side: Float, noise: float) -> tuple[Float, Bool]:
    """Returns where edges of `one` pierce `other`, or its corners lie on it: (n, 6, 3), and which do.

    `side` (n, 3) m are the signed distances of the corners of `one` from the plane of `other`.
    """
    end, side_end = np.roll(one, -1, axis=1), np.roll(side, -1, axis=1)
    cut = side * side_end < 0
    t = np.where(cut, side, 0.0) / np.where(cut, side - side_end, 1.0)
    spots = np.concatenate([one + t[:, :, None] * (end - one), one], axis=1)
    valid = np.concatenate([cut, np.abs(side) <= noise], axis=1)
    pair, k = np.nonzero(valid)
    valid[pair, k] = to_triangles(spots[pair, k], other[pair]) <= 2 * noise
    return spots, valid


def _line_ends(spots: Float, valid: Bool) -> Float:
    """Returns the two extreme points (n, 2, 3) of collinear points (n, k, 3)."""
    row = np.arange(len(spots))
    start = spots[row, np.argmax(valid, axis=1)]
    for _ in range(2):
        away = np.where(valid, np.linalg.norm(spots - start[:, None], axis=2), -1.0)
        start, before = spots[row, np.argmax(away, axis=1)], start
    return np.stack([before, start], axis=1)


def _coplanar_overlaps(one: Float, other: Float, normal: Float, pairs: Int) -> list[tuple[int, Float]]:
    """Returns the outlines of the overlaps of coplanar triangles, with the index of the pair."""
    axis = np.argmax(np.abs(normal[pairs]), axis=1)
    keep = np.array([[1, 2], [0, 2], [0, 1]])[axis]
    drawn = [
        shapely.polygons(np.take_along_axis(corners[pairs], keep[:, None].repeat(3, 1), axis=2))
        for corners in (one, other)
    ]
    parts, which = shapely.get_parts(shapely.intersection(*drawn), return_index=True)
    found = []
    for part, k in zip(parts, which.tolist(), strict=True):
        xy = shapely.get_coordinates(part)
        if len(xy):
            base, n = one[pairs[k], 0], normal[pairs[k]]
            line = np.zeros((len(xy), 3))
            line[:, keep[k]] = xy
            line[:, axis[k]] = base[axis[k]] - (xy - base[keep[k]]) @ n[keep[k]] / n[axis[k]]
            found.append((int(pairs[k]), line))
    return found
