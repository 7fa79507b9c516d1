"""Measures how far apart the samples of a surface are locally, which tells a sparse wall from a hole.

A scan is dense near its station and sparse along the street, and its lines may be closer than its columns or
the other way round. What matters for filling is the *gap* between neighbours in any direction. It is taken
from the nearest neighbours in eight sectors around a sample, of which the third farthest counts: at an edge
half of the sectors are empty, and on a single line of samples six are. Holes have no samples, and returns
from inside a window are few, so the mean over two metres, in which each sample counts once, is that of the
wall.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.ortho.orthoraster import OrthoRaster
from frontage.raster import gridding

_COARSEST_M = 0.25  # closing the gaps of a sparser cloud would close windows
_QUERIES = 40_000  # samples whose neighbours are searched, at most,
_QUERIES_PER_BLOCK = 5  # and of a block, of which the mean takes in fifty
_NEIGHBOURS = 40  # around a sample: farther ones are not looked for
_CELLS_PER_SPACING = 3  # of the cells in which neighbours are looked for
_MOST_CELLS = 1 << 26
_OCTAVES = 4  # by which gaps may be wider than is typical of the wall
_SECTORS = 8
# The 75 % quantile of the distance to the nearest point of a sector, in spacings, for a Poisson process.
_POISSON = float(np.sqrt(8.0 / np.pi * np.log(1.0 / 0.25)))
_BLOCK_M = 0.5
_REACH_M = 1.0  # sigma of the Gaussian mean over the surroundings


@dataclass(frozen=True)
class Gaps:
    """Spacing of the samples (h, w) float32 px, by blocks of step x step pixels of a raster."""

    step: int
    px: Array

    def at(self, rows: Array, columns: Array) -> Array:
        """Returns the spacing (m, n) px at pixel rows (m,) and columns (n,); outside, that of the border."""
        h, w = self.px.shape
        r, c = np.clip(rows // self.step, 0, h - 1), np.clip(columns // self.step, 0, w - 1)
        return np.asarray(np.take(self.px[:, c], r, axis=0))  # whole rows are copied


def local_gaps(at: Float, raster: OrthoRaster, typical: float) -> Gaps:
    """Measures the local gaps of samples (n, 2) px by blocks of about half a metre.

    A gap is given as the spacing ``1 / sqrt(density)`` of points scattered at random that leave the same gap.
    It is at least a quarter of `typical`, the spacing of the wall in px; blocks are at least eight times as
    wide as that. A block without samples nearby takes the value of the nearest block.
    """
    block = max(1, round(_BLOCK_M / raster.gsd), int(np.ceil(8 * typical)))
    blocks = raster.coarser(block)
    place, gap = _sector_gap(at, typical, _QUERIES_PER_BLOCK * blocks.height * blocks.width)
    known = np.isfinite(gap)
    cell, inside = gridding.cell_index(place[known] / block, (blocks.height, blocks.width))
    gap = gap[known][inside]
    size = blocks.height * blocks.width
    count = np.bincount(cell, minlength=size).reshape(blocks.height, blocks.width).astype(np.float32)
    total = np.bincount(cell, np.log(gap), size).reshape(count.shape).astype(np.float32)
    sigma = _REACH_M / (raster.gsd * block)
    if sigma > 0.3:
        count, total = (
            cv2.GaussianBlur(g, (0, 0), sigma, borderType=cv2.BORDER_CONSTANT) for g in (count, total)
        )
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(count > 1e-3, np.exp(total / count), np.nan)
    filled = gridding.nearest_filled(mean.astype(np.float32))
    filled = np.where(np.isfinite(filled), filled, np.float32(typical))
    return Gaps(block, np.clip(filled, 0.25 * typical, max(_COARSEST_M / raster.gsd, 0.25 * typical)))


def _sector_gap(at: Float, typical: float, queries: int) -> tuple[Float, Float]:
    """Returns the positions (k, 2) of some of the samples (n, 2) and the gaps (k,) around them, in px.

    Several samples of one cell count as one; a cell is a third of the `typical` spacing wide, and a pixel at
    least. A gap is infinite where there are too few samples nearby. `queries` is how many samples are wanted;
    at most `_QUERIES` are looked at. Where the cells around hold too few samples to tell, cells of twice the
    size are asked.
    """
    if not len(at):
        return np.empty((0, 2)), np.empty(0)
    first = np.array([np.floor(axis.min()) for axis in at.T])  # one axis at a time is much faster
    extent = np.array([axis.max() for axis in at.T]) - first + 1.0
    size = max(1.0, np.floor(typical / _CELLS_PER_SPACING), np.ceil(np.sqrt(extent.prod() / _MOST_CELLS)))
    column, row = (((axis - start) / size).astype(np.int64) for axis, start in zip(at.T, first, strict=True))
    marked = np.zeros(tuple((extent[::-1] // size).astype(np.int64) + 1), np.bool_)
    marked[row, column] = True
    flat = np.flatnonzero(marked)
    cell = np.stack(np.divmod(flat[:: max(1, len(flat) // min(queries, _QUERIES))], marked.shape[1]))
    radius = int(np.ceil(np.sqrt(_NEIGHBOURS / np.pi) * max(typical / size, 1.0)))
    gap, left = np.full(cell.shape[1], np.inf), np.arange(cell.shape[1])
    for octave in range(_OCTAVES):
        third, count = _third_farthest(marked, cell[:, left] >> octave, radius)
        gap[left] = third * (size * (1 << octave))
        left = left[np.isinf(third) & (count < _NEIGHBOURS)]
        marked = _halved(marked)
    return first + (cell[::-1].T + 0.5) * size, gap / _POISSON


def _third_farthest(marked: Bool, cell: Int, radius: int) -> tuple[Float, Int]:
    """Returns the third farthest (k,) of the nearest marked cells in eight sectors around cells (2, k).

    Also returns how many cells (k,) within the `radius` are marked. Distances are in cells, infinite where
    none is marked.
    """
    padded = np.pad(marked, radius)
    width = padded.shape[1]
    at = (cell[0] + radius) * width + cell[1] + radius
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1].reshape(2, -1)
    distance = np.hypot(x, y)
    sector = np.floor((np.arctan2(y, x) + np.pi) / (2 * np.pi) * _SECTORS).astype(np.int64) % _SECTORS
    nearest, count = np.full((_SECTORS, len(at)), np.inf), np.zeros(len(at), np.int64)
    for number in range(_SECTORS):
        mine = np.flatnonzero((sector == number) & (distance > 0) & (distance <= radius))
        mine = mine[np.argsort(distance[mine], kind="stable")]
        hit = padded.ravel()[at[:, None] + (y * width + x)[mine]]
        first = np.argmax(hit, axis=1)
        nearest[number] = np.where(hit[np.arange(len(at)), first], distance[mine][first], np.inf)
        count += hit.sum(1)
    return np.sort(nearest, axis=0)[-3], count


def _halved(marked: Bool) -> Bool:
    """The cells of twice the size of which any quarter is marked."""
    h, w = marked.shape
    padded = np.pad(marked, ((0, h % 2), (0, w % 2)))
    rows = padded[::2] | padded[1::2]
    return rows[:, ::2] | rows[:, 1::2]
