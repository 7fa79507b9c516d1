"""Maps from the pixels of a tile to a source picture, as polynomials that replace a costly projection.

Projecting every pixel through a lens takes several times as long as sampling it. The projection is smooth,
however, so that over a tile it is a sum of products of Chebyshev polynomials of columns, rows and the depth
of the surface, ``(u, v) = sum_kij g_kij y^k T_i(row) T_j(column)``. Interpolation at the roots of the next
polynomial has its largest errors near the extrema of that polynomial (Trefethen, Approximation Theory and
Approximation Practice, ch. 4 and 7). The projection is compared there, so that the error is measured.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import cv2
import numpy as np
from numpy.polynomial.chebyshev import chebvander3d

from frontage.geometry.arrays import Array, Float

# Matrix products of up to this many multiplications run in one thread of BLAS; larger ones start threads,
# which takes longer.
_ONE_THREAD = 1 << 17
EVERYTHING = (slice(None), slice(None))
"""The window of all rows and columns of a tile."""


@dataclass(frozen=True, eq=False)
class SourceMap:
    """The source positions (u, v), first pixel centre at 0.5, of the pixels of a tile of `shape` (m, n).

    powers     one (p, q, 2) px of coefficients g per power of the depth, p and q its own; or one
               (m, n, 2) px, every pixel
    jacobian   (2, 2) typical d(source)/d(target)
    low, high  (2,) px, bounds of all positions; NaN when none is known
    exact      whether `powers` holds the positions themselves
    complete   whether every position is known (finite)
    depth      (m, n) float32, what the powers are those of; None when there is only one power
    """

    powers: tuple[Float, ...]
    shape: tuple[int, int]
    jacobian: Float
    low: Float
    high: Float
    exact: bool = False
    complete: bool = True
    depth: Array | None = None

    @cached_property
    def known(self) -> bool:
        """Whether any position is known."""
        return bool(np.isfinite(self.low).all())

    @cached_property
    def derivatives(self) -> tuple[float, ...]:
        """The four derivatives of the Jacobian, row by row."""
        return tuple(self.jacobian.ravel().tolist())

    @cached_property
    def _evaluated(self) -> dict[tuple[tuple[float, float], float], list[Array]]:
        """What `_lines` returned for the origins and scales that were asked for."""
        return {}

    @staticmethod
    def of_pixels(at: Float, jacobian: Float) -> "SourceMap":
        """Makes the map from positions (m, n, 2) px of every pixel; NaN = unknown."""
        known = at[np.isfinite(at).all(-1)]
        empty = np.full(2, np.nan)
        low, high = (known.min(0), known.max(0)) if len(known) else (empty, empty)
        complete = len(known) == at.shape[0] * at.shape[1]
        return SourceMap((at,), (at.shape[0], at.shape[1]), jacobian, low, high, True, complete)

    def planes(
        self, origin: tuple[float, float], scale: float, window: tuple[slice, slice] = EVERYTHING
    ) -> tuple[Array, Array]:
        """Returns ``(position - origin) scale - 0.5`` as planes u, v (m, n) float32 for `cv2.remap`.

        Unknown positions are -1. `window` selects some rows and columns of the tile.
        """
        shift = (origin[0] * scale + 0.5, origin[1] * scale + 0.5)
        if self.exact:
            every = (self.powers[0][window] * scale - shift).astype(np.float32)
            u, v = cv2.split(every if self.complete else np.nan_to_num(every, nan=-1.0))
            return u, v
        key = origin, scale
        if key not in self._evaluated:
            self._evaluated[key] = _lines([power * scale for power in self.powers], shift, self.shape[1])
        rows = _basis(self.shape[0], max(map(len, self.powers)))
        lines = [power[..., window[1]] for power in self._evaluated[key]]
        return _planes(rows[window[0]], lines, None if self.depth is None else self.depth[window])


@dataclass(frozen=True)
class Polynomial:
    """A polynomial map over [-1, 1]^3.

    factors    (k, p, q, 2) px, coefficients of T_k(depth) T_i(row) T_j(column)
    error      px, its largest error between the nodes
    low, high  (2,) px, bounds of the positions there
    """

    factors: Float
    error: float
    low: Float
    high: Float


def fitted(at: Callable[[Array, Array, Array], Float], degree: int, depth_degree: int) -> Polynomial:
    """Interpolates ``at(column, row, depth)`` by a polynomial of `degree` in column and row.

    `at` takes three arrays (n,) in [-1, 1] and returns positions (n, 2) px. The error is infinite if a
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
    """Returns the Jacobian (2, 2) of positions (m, n, 2) px: median d/d(column) and d/d(row) as its columns.

    It is the identity where no two neighbours are known.
    """
    columns = []
    for axis, unit in ((1, [1.0, 0.0]), (0, [0.0, 1.0])):
        slope = np.diff(at, axis=axis).reshape(-1, 2)
        known = slope[np.isfinite(slope).all(1)]
        columns.append(np.median(known, axis=0) if len(known) else np.array(unit))
    return np.column_stack(columns)


def _lines(powers: list[Float], shift: tuple[float, float], width: int) -> list[Array]:
    """Evaluates coefficients (p, q, 2) of powers, less a shift (2,), along the `width` columns of a tile.

    Returns by which lines (p, 2, width) the polynomials of the rows are to be multiplied, for each power.
    """
    powers[0][0, 0] -= shift
    lines = []
    for factors in powers:
        p, q, _ = factors.shape
        each = np.ascontiguousarray(np.swapaxes(factors, 1, 2), np.float32).reshape(-1, q)
        lines.append((each @ _basis(width, q).T).reshape(p, 2, width))
    return lines


def _planes(rows: Array, lines: list[Array], depth: Array | None) -> tuple[Array, Array]:
    """Sums ``rows @ lines[k] depth^k`` for both coordinates, (m, n) float32 each, in one thread.

    `rows` are (m, p) and each of the lines (p, 2, n), where p may be less; without a depth (m, n) there is
    one power only. Both coordinates lie side by side in memory: small windows take half as many steps.
    """
    n = lines[0].shape[-1]
    flat = [np.ascontiguousarray(power).reshape(len(power), 2 * n) for power in lines]
    out = np.empty((len(rows), 2 * n), np.float32)
    block = max(1, _ONE_THREAD // max(power.size for power in flat))
    spare = np.empty((min(block, len(rows)), 2 * n), np.float32)
    for first in range(0, len(rows), block):
        part, total = rows[first : first + block], out[first : first + block]
        np.matmul(part[:, : len(flat[-1])], flat[-1], out=total)
        if depth is not None:
            both, deep = total.reshape(-1, 2, n), depth[first : first + block, None]
            for power in flat[-2::-1]:  # Horner's scheme
                np.multiply(both, deep, out=both)
                added = np.matmul(part[:, : len(power)], power, out=spare[: len(part)])
                np.add(total, added, out=total)
    return out[:, :n], out[:, n:]


@lru_cache(maxsize=256)
def _basis(size: int, count: int) -> Array:
    """Chebyshev polynomials (size, count) float32 at pixel centres; -1 and 1 are the tile's outer edges."""
    centres = (np.arange(size) + 0.5) * (2.0 / size) - 1.0
    values = np.ones((size, count))
    values[:, 1:2] = centres[:, None]
    for n in range(2, count):
        values[:, n] = 2.0 * centres * values[:, n - 1] - values[:, n - 2]
    return values.astype(np.float32)


@lru_cache(maxsize=8)
def _design(degree: int, depth_degree: int) -> tuple[Array, Array, Array]:
    """Returns the nodes followed by the points between them, and two matrices.

    The points are (column, row, depth) (n, 3). The first matrix takes the values at the nodes to
    coefficients, the second one takes coefficients to the values at the points between.
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
    """The `degree` + 1 roots of the next higher Chebyshev polynomial."""
    return np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))


def _extrema(degree: int) -> Float:
    """The `degree` + 2 extrema, ends included, of the next Chebyshev polynomial; 0 for degree 0."""
    return np.cos(np.pi * np.arange(degree + 2) / (degree + 1)) if degree else np.zeros(1)
