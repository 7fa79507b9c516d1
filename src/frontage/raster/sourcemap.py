"""Maps from the pixels of a tile to a source picture: exact at nodes, bilinear between, polynomial in depth.

Projecting every pixel through a lens costs several times what sampling it does. The projection is smooth,
though: between nodes a few pixels apart it is bilinear, and in the depth y of the surface a low polynomial,
``(u, v)(c, r, y) = g0(c, r) + g1(c, r) y + g2(c, r) y^2``; whoever makes a map proves that by its errors.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float


@dataclass(frozen=True, eq=False)
class SourceMap:
    """Source positions (u, v), pixel centre at 0.5, of the pixels of a tile of `shape` (m, n).

    grids      one (p, q, 2) px per power of the depth, at `nodes`; or one (m, n, 2), every pixel, `step` 0
    depth      (m, n) float32 m, what the powers are of; None when there is one grid
    jacobian   (2, 2) typical d(source)/d(target)
    low, high  (2,) px, bounds of all positions; NaN when none is known
    complete   whether every position is known (finite)
    """

    grids: tuple[Float, ...]
    step: int
    shape: tuple[int, int]
    jacobian: Float
    low: Float
    high: Float
    complete: bool = True
    depth: Array | None = None

    @staticmethod
    def exact(at: Float, jacobian: Float) -> "SourceMap":
        """The map of positions (m, n, 2) px that are given for every pixel; NaN = no place."""
        known = at[np.isfinite(at).all(-1)]
        empty = np.full(2, np.nan)
        low, high = (known.min(0), known.max(0)) if len(known) else (empty, empty)
        complete = len(known) == at.shape[0] * at.shape[1]
        return SourceMap((at,), 0, (at.shape[0], at.shape[1]), jacobian, low, high, complete)

    def planes(self, origin: tuple[float, float], scale: float) -> tuple[Array, Array]:
        """``(position - origin) scale - 0.5`` as planes u, v (m, n) float32, as `cv2.remap` counts."""
        u, v = (self._plane(axis, origin[axis], scale) for axis in (0, 1))
        return u, v

    def _plane(self, axis: int, origin: float, scale: float) -> Array:
        planes = []
        for power, grid in enumerate(self.grids):
            plane = grid[..., axis] * scale
            if power == 0:
                plane -= origin * scale + 0.5
            planes.append(self._fine(plane.astype(np.float32)))
        total = planes[-1]
        for plane in planes[-2::-1]:  # Horner's scheme
            total = cv2.add(cv2.multiply(total, self.depth), plane)
        if not self.complete:
            total = np.nan_to_num(total, nan=-1.0)
        return total

    def _fine(self, grid: Array) -> Array:
        """Bilinear values (m, n) at the pixel centres between nodes (p, q)."""
        if self.step == 0:
            return grid
        h, w = grid.shape
        # cv2.resize puts node k at (k + 0.5) step - 0.5; ours begin half a step before the tile: cut a step
        fine = cv2.resize(grid, (w * self.step, h * self.step), interpolation=cv2.INTER_LINEAR)
        inner: Array = fine[self.step : self.step + self.shape[0], self.step : self.step + self.shape[1]]
        return inner


def nodes(first: int, last: int, step: int) -> Float:
    """Positions `step` px apart from half a step before `first` to at least half a step past `last`."""
    return first + step * (np.arange(-(-(last - first) // step) + 2, dtype=np.float64) - 0.5)


def bend(grid: Float) -> float:
    """Sum of the largest second differences of nodes (p, q, 2) along both axes, px; inf when one is unknown.

    An eighth of it bounds the error of bilinear interpolation between the nodes.
    """
    along = np.abs(grid[:, 2:] - 2 * grid[:, 1:-1] + grid[:, :-2]).max(initial=0.0)
    across = np.abs(grid[2:] - 2 * grid[1:-1] + grid[:-2]).max(initial=0.0)
    total = float(along + across)
    return total if np.isfinite(total) else np.inf


def mean_jacobian(grid: Float, step: int) -> Float:
    """Mean d(source)/d(column), d(source)/d(row) over the known nodes, columns of a (2, 2) matrix."""
    columns = []
    for axis in (1, 0):
        slope = (grid[:, 1:] - grid[:, :-1] if axis else grid[1:] - grid[:-1]).reshape(-1, 2)
        mean = slope.mean(0)
        if not np.isfinite(mean).all():
            known = slope[np.isfinite(slope).all(1)]
            mean = np.median(known, axis=0) if len(known) else np.full(2, float(step))
        columns.append(mean / step)
    return np.column_stack(columns)
