"""Maps from the pixels of a tile to a source picture, as polynomials that stand in for a costly projection.

Projecting every pixel through a lens costs several times what sampling it does. The projection is smooth,
though: over a tile it is a sum of products of Chebyshev polynomials of columns, rows and the surface's depth,
``(u, v) = sum_kij g_kij y^k T_i(row) T_j(column)``. Interpolation at the roots of the next polynomial errs
most near that polynomial's extrema (Trefethen, Approximation Theory and Approximation Practice, ch. 4 and 7),
so the projection is compared there, which makes the error a measured one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial.chebyshev import chebvander, chebvander3d

from frontage.geometry.arrays import Array, Float

_ONE_CORE = 1 << 17  # products of a matrix product that BLAS does not spread over cores, which costs more


@dataclass(frozen=True, eq=False)
class SourceMap:
    """Source positions (u, v), pixel centre at 0.5, of the pixels of a tile of `shape` (m, n).

    powers     one (p, q, 2) px of coefficients g per power of the depth; or one (m, n, 2) px, every pixel
    jacobian   (2, 2) typical d(source)/d(target)
    low, high  (2,) px, bounds of all positions; NaN when none is known
    exact      whether `powers` holds the positions themselves
    complete   whether every position is known (finite)
    depth      (m, n) float32 m, what the powers are of; None when there is one
    """

    powers: tuple[Float, ...]
    shape: tuple[int, int]
    jacobian: Float
    low: Float
    high: Float
    exact: bool = False
    complete: bool = True
    depth: Array | None = None

    @staticmethod
    def of_pixels(at: Float, jacobian: Float) -> "SourceMap":
        """The map of positions (m, n, 2) px that are given for every pixel; NaN = no place."""
        known = at[np.isfinite(at).all(-1)]
        empty = np.full(2, np.nan)
        low, high = (known.min(0), known.max(0)) if len(known) else (empty, empty)
        complete = len(known) == at.shape[0] * at.shape[1]
        return SourceMap((at,), (at.shape[0], at.shape[1]), jacobian, low, high, True, complete)

    def planes(
        self, origin: tuple[float, float], scale: float, rows: slice = slice(None)
    ) -> tuple[Array, Array]:
        """``(position - origin) scale - 0.5`` as planes u, v (m, n) float32, as `cv2.remap` counts.

        Unknown positions are -1. `rows` may choose some rows of the tile.
        """
        u, v = (self._plane(axis, origin[axis], scale, rows) for axis in (0, 1))
        return u, v

    def _plane(self, axis: int, origin: float, scale: float, rows: slice) -> Array:
        shift = origin * scale + 0.5
        if self.exact:
            every = (self.powers[0][rows, :, axis] * scale - shift).astype(np.float32)
            return every if self.complete else np.nan_to_num(every, nan=-1.0)
        factors = [power[..., axis] * scale for power in self.powers]
        factors[0][0, 0] -= shift
        total = _values(factors[-1], self.shape, rows)
        if self.depth is not None:
            y = self.depth[rows]
            for factor in factors[-2::-1]:  # Horner's scheme
                total *= y
                total += _values(factor, self.shape, rows)
        return total


@dataclass(frozen=True)
class Polynomial:
    """Coefficients (k, p, q, 2) of T_k(depth) T_i(row) T_j(column) over [-1, 1]^3; their largest error, px,
    between the nodes; the bounds low, high (2,) px of the positions there.
    """

    factors: Float
    error: float
    low: Float
    high: Float


def fitted(at: Callable[[Array, Array, Array], Float], degree: int, depth_degree: int) -> Polynomial:
    """The polynomial of `degree` in column and row that interpolates ``at(column, row, depth)``.

    `at` takes three arrays (n,) in [-1, 1] and gives positions (n, 2) px. Its error is infinite where a
    position is unknown.
    """
    points, inverse, between = _design(degree, depth_degree)
    values = at(points[:, 0], points[:, 1], points[:, 2])
    shape = (depth_degree + 1, degree + 1, degree + 1, 2)
    if not np.isfinite(values).all():
        unknown = np.full(2, np.nan)
        return Polynomial(np.zeros(shape), np.inf, unknown, unknown)
    given, wanted = values[: len(inverse)], values[len(inverse) :]
    factors = inverse @ given
    error = float(np.abs(between @ factors - wanted).max())
    return Polynomial(factors.reshape(shape), error, wanted.min(0), wanted.max(0))


def jacobian_of(at: Float) -> Float:
    """Median d(source)/d(column), d(source)/d(row), columns of a (2, 2) matrix, of positions (m, n, 2) px.

    The identity where no two neighbours are known.
    """
    columns = []
    for axis, unit in ((1, [1.0, 0.0]), (0, [0.0, 1.0])):
        slope = np.diff(at, axis=axis).reshape(-1, 2)
        known = slope[np.isfinite(slope).all(1)]
        columns.append(np.median(known, axis=0) if len(known) else np.array(unit))
    return np.column_stack(columns)


def _values(factors: Float, shape: tuple[int, int], chosen: slice) -> Array:
    """Values (k, n) float32 at pixel centres of the chosen rows of a tile (m, n), of coefficients (p, q)."""
    rows, columns = _basis(shape[0], factors.shape[0])[chosen], _basis(shape[1], factors.shape[1])
    mixed = factors.astype(np.float32) @ columns.T
    out = np.empty((len(rows), shape[1]), np.float32)
    block = max(1, _ONE_CORE // (factors.shape[0] * shape[1]))
    for first in range(0, len(rows), block):
        np.matmul(rows[first : first + block], mixed, out=out[first : first + block])
    return out


@lru_cache(maxsize=64)
def _basis(size: int, count: int) -> Array:
    """Chebyshev polynomials (size, count) float32 at pixel centres; -1 and 1 are the tile's outer edges."""
    centres = (np.arange(size) + 0.5) * (2.0 / size) - 1.0
    return np.ascontiguousarray(chebvander(centres, count - 1), np.float32)


@lru_cache(maxsize=8)
def _design(degree: int, depth_degree: int) -> tuple[Array, Array, Array]:
    """Nodes and then points between them, as (column, row, depth) (n, 3); the matrix from values at the nodes
    to coefficients; the one from coefficients to values at the points between.
    """
    nodes, between = (
        np.stack([g.ravel() for g in np.meshgrid(*axes, indexing="ij")][::-1], axis=1)
        for axes in (
            (_roots(depth_degree), _roots(degree), _roots(degree)),
            (_extrema(depth_degree), _extrema(degree), _extrema(degree)),
        )
    )
    degrees = (depth_degree, degree, degree)
    design, check = (chebvander3d(p[:, 2], p[:, 1], p[:, 0], degrees) for p in (nodes, between))
    return np.concatenate([nodes, between]), np.linalg.inv(design), check


def _roots(degree: int) -> Float:
    """The `degree` + 1 roots of the next Chebyshev polynomial."""
    return np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))


def _extrema(degree: int) -> Float:
    """The `degree` + 2 places, ends included, where the next Chebyshev polynomial is 1 or -1; else 0."""
    return np.cos(np.pi * np.arange(degree + 2) / (degree + 1)) if degree else np.zeros(1)
