"""Exact signs of areas and volumes on integer coordinates, behind a floating-point filter.

The filter is that of Shewchuk (Adaptive Precision Floating-Point Arithmetic, 1997): a determinant larger than
its rounding error has the right sign; the few others are computed again with Python's integers.
"""

import numpy as np
from numpy.typing import NDArray

from frontage.geometry.arrays import Array, Int

Sign = NDArray[np.int8]
_ERROR_3D = 1e-15  # share of the permanent: Shewchuk's 7 epsilon, with room for differences beyond 2^53
_ERROR_2D = 5e-16  # the same for areas: 3 epsilon, with room


def orient3d(grid: Int, a: Int, b: Int, c: Int, d: Int) -> Sign:
    """Returns the sign (n,) of the volume of tetrahedra: +1 if d sees a, b, c counter-clockwise.

    `grid` (v, 3) are integer coordinates; a, b, c and d (n,) are vertex ids.
    """
    u, v, w = grid[a] - grid[d], grid[b] - grid[d], grid[c] - grid[d]
    det, size = _volume(u.astype(np.float64), v.astype(np.float64), w.astype(np.float64))
    sign = np.sign(det).astype(np.int8)
    doubt = np.nonzero((np.abs(det) <= _ERROR_3D * size) & (size > 0))[0]
    if len(doubt):
        exact, _ = _volume(u[doubt].astype(object), v[doubt].astype(object), w[doubt].astype(object))
        sign[doubt] = np.sign(exact).astype(np.int8)
    return -sign


def _volume(u: Array, v: Array, w: Array) -> tuple[Array, Array]:
    """Returns the determinants (n,) of rows u, v, w (n, 3), and the sums of the magnitudes of their terms."""
    terms = [
        (u[:, 0], v[:, 1] * w[:, 2], v[:, 2] * w[:, 1]),
        (u[:, 1], v[:, 2] * w[:, 0], v[:, 0] * w[:, 2]),
        (u[:, 2], v[:, 0] * w[:, 1], v[:, 1] * w[:, 0]),
    ]
    det = sum((f * (p - q) for f, p, q in terms[1:]), terms[0][0] * (terms[0][1] - terms[0][2]))
    size = sum(
        (abs(f) * (abs(p) + abs(q)) for f, p, q in terms[1:]),
        abs(terms[0][0]) * (abs(terms[0][1]) + abs(terms[0][2])),
    )
    return np.asarray(det), np.asarray(size)


def orient2d(a: Int, b: Int, c: Int) -> Sign:
    """Returns the sign (n,) of the area of triangles, integer coordinates (n, 2): +1 if counter-clockwise."""
    u, v = a - c, b - c
    uf, vf = u.astype(np.float64), v.astype(np.float64)
    left, right = uf[:, 0] * vf[:, 1], uf[:, 1] * vf[:, 0]
    det = left - right
    sign = np.sign(det).astype(np.int8)
    size = np.abs(left) + np.abs(right)
    doubt = np.nonzero((np.abs(det) <= _ERROR_2D * size) & (size > 0))[0]
    if len(doubt):
        uo, vo = u[doubt].astype(object), v[doubt].astype(object)
        sign[doubt] = np.sign(uo[:, 0] * vo[:, 1] - uo[:, 1] * vo[:, 0]).astype(np.int8)
    return sign


def drop_axis(grid: Int, a: Int, b: Int, c: Int) -> Int:
    """Returns the axis (n,) along which triangles can be projected: the largest component of their normal."""
    u, v = (grid[b] - grid[a]).astype(np.float64), (grid[c] - grid[a]).astype(np.float64)
    return np.asarray(np.argmax(np.abs(np.cross(u, v)), axis=1))


def without_axis(points: Int, axis: Int) -> Int:
    """Removes one coordinate of each point (n, 3): (n, 2)."""
    keep = np.array([[1, 2], [0, 2], [0, 1]])[axis]
    return np.asarray(np.take_along_axis(points, keep, axis=1))
