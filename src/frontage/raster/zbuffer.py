"""Depth buffers of point clouds."""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float, Int
from frontage.raster.gridding import OCTAGON

_COUNTED_CUBES = 1 << 23  # as many are counted in memory; more are sorted
_ENOUGH = 100_000  # points, whose median is as good as that of all
MAX_RADIUS_PX = 24  # very close points would cover the picture; no gap between samples is that wide


def splat_depth(xy: Array, depth: Array, radius: Array, shape: tuple[int, int]) -> Array:
    """Returns the nearest depth (h, w) at every pixel, and where there is no point inf or, of uint16, 65535.

    Depths are float32, unless they are given as whole numbers uint16, which take half of the time.

    Each point covers a disc: xy (n, 2) px (first pixel centre at 0.5), depth (n,) m, radius (n,) px, rounded.
    The largest discs come first. What is drawn grows by a pixel before the next smaller ones are added, so
    that every point has grown by its radius in the end, and the time does not depend on the sizes. Growing by
    crosses and squares in turn makes octagons, which are discs to 8 %.
    """
    h, w = shape
    x, y = xy.T
    with np.errstate(invalid="ignore"):
        inside = (x >= 0) & (x < w) & (y >= 0) & (y < h) & (depth > 0)
    depth = depth if depth.dtype == np.uint16 else depth.astype(np.float32, copy=False)
    nothing = np.inf if depth.dtype == np.float32 else np.iinfo(depth.dtype).max
    if not inside.any():
        return np.full(shape, nothing, depth.dtype)
    if not inside.all():
        chosen = np.flatnonzero(inside)
        x, y, depth, radius = (np.take(a, chosen) for a in (x, y, depth, radius))
    column, row = x.astype(np.int32), y.astype(np.int32)
    size = np.clip(np.rint(radius), 0, MAX_RADIUS_PX).astype(np.uint8)
    reach = int(size.max())
    r0, c0 = max(int(row.min()) - reach, 0), max(int(column.min()) - reach, 0)
    r1, c1 = min(int(row.max()) + reach + 1, h), min(int(column.max()) + reach + 1, w)
    drawn = np.full((r1 - r0, c1 - c0), nothing, depth.dtype)  # the part of the picture that the discs reach
    cell = np.multiply(row - r0, drawn.shape[1], dtype=np.intp)
    cell += column - c0
    for r in range(reach, -1, -1):
        own = np.flatnonzero(size == r)
        np.minimum.at(drawn.reshape(-1), cell[own], depth[own])
        if r > 0:
            drawn = cv2.erode(drawn, OCTAGON[r % len(OCTAGON)], borderType=cv2.BORDER_REPLICATE)
    beyond = (r0, h - r1, c0, w - c1)
    if any(beyond):
        drawn = cv2.copyMakeBorder(drawn, *beyond, cv2.BORDER_CONSTANT, value=float(nothing))
    return drawn


def local_spacing(xyz: Array, samples_per_cell: int = 8, of: Int | None = None) -> tuple[Float, Float]:
    """Returns the spacing (n,) m of a cloud (n, 3) of surfaces and the number of points (n,) around each.

    With `of`, the numbers (k,) of some points, it returns those of these points.

    Points are counted in cubes. A surface that crosses a cube of edge e with k points has a spacing of
    ``e / sqrt(k)``. The edge doubles from 25 cm until the median cube holds `samples_per_cell` points.
    """
    edge = 0.25
    if len(xyz) == 0:
        return np.empty(0), np.empty(0)
    corner = [axis.min() for axis in xyz.T]
    while True:
        x, y, z = (((a - c) * (1.0 / edge)).astype(np.int32) for a, c in zip(xyz.T, corner, strict=True))
        rows, layers = int(y.max()) + 1, int(z.max()) + 1
        cube = x.astype(np.int64)
        cube *= rows
        cube += y
        cube *= layers
        cube += z
        number, count = _counted(cube, (int(x.max()) + 1) * rows * layers)
        if edge >= 8.0 or np.median(count[number[:: 1 + len(number) // _ENOUGH]]) >= samples_per_cell:
            k = count[number if of is None else number[of]].astype(np.float64)
            return edge / np.sqrt(k), k
        edge *= 2.0


def _counted(cube: Int, cubes: int) -> tuple[Int, Int]:
    """The numbers (n,) of the cubes of points, and how many of them each cube holds."""
    if cubes <= _COUNTED_CUBES:
        return cube, np.bincount(cube, minlength=cubes)
    _, inverse, count = np.unique(cube, return_inverse=True, return_counts=True)
    return inverse, count
