"""What pairs of triangles have in common, as coordinates: floating point, within a noise threshold."""

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float, Int
from frontage.validation.geometry.distances import pairwise


def common_lines(one: Float, other: Float, noise: float) -> list[tuple[int, Float]]:
    """For pairs of triangles (n, 3, 3): number of the pair and the line (k, 3) or outline that both have.

    Pairs apart by more than `noise` (m) are left out. Triangles in one plane have an area in common; its
    outline is given.
    """
    n_one, n_other = _normal(one), _normal(other)
    side_one = np.einsum("nki,ni->nk", one - other[:, :1], n_other)
    side_other = np.einsum("nki,ni->nk", other - one[:, :1], n_one)
    flat = (np.abs(side_one).max(1) <= noise) | (np.abs(side_other).max(1) <= noise)
    found = _flat(one, other, n_one, np.nonzero(flat)[0])
    cut = np.nonzero(~flat)[0]
    here = _pierced(one[cut], other[cut], side_one[cut], noise)
    there = _pierced(other[cut], one[cut], side_other[cut], noise)
    spots, valid = np.concatenate([here[0], there[0]], 1), np.concatenate([here[1], there[1]], 1)
    touched = valid.any(1)
    ends = _ends(spots[touched], valid[touched])
    found += list(zip(cut[touched].tolist(), ends, strict=True))
    return sorted(found, key=lambda f: f[0])


def _normal(corners: Float) -> Float:
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None])


def _pierced(one: Float, other: Float, side: Float, noise: float) -> tuple[Float, Bool]:
    """Where edges of `one` pass through `other` and corners of `one` on it: (n, 6, 3), and which count."""
    end, side_end = np.roll(one, -1, axis=1), np.roll(side, -1, axis=1)
    cut = side * side_end < 0
    t = np.where(cut, side, 0.0) / np.where(cut, side - side_end, 1.0)
    spots = np.concatenate([one + t[:, :, None] * (end - one), one], axis=1)
    valid = np.concatenate([cut, np.abs(side) <= noise], axis=1)
    pair, k = np.nonzero(valid)
    valid[pair, k] = pairwise(spots[pair, k], other[pair]) <= 2 * noise
    return spots, valid


def _ends(spots: Float, valid: Bool) -> Float:
    """The two ends (n, 2, 3) of points on one line (n, k, 3)."""
    row = np.arange(len(spots))
    start = spots[row, np.argmax(valid, axis=1)]
    for _ in range(2):
        away = np.where(valid, np.linalg.norm(spots - start[:, None], axis=2), -1.0)
        start, before = spots[row, np.argmax(away, axis=1)], start
    return np.stack([before, start], axis=1)


def _flat(one: Float, other: Float, normal: Float, pairs: Int) -> list[tuple[int, Float]]:
    """Outlines of the overlaps of triangles in one plane."""
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
