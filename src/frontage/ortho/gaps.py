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
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Array, Float
from frontage.ortho.orthoraster import OrthoRaster
from frontage.raster import gridding

_COARSEST_M = 0.25  # closing the gaps of a sparser cloud would close windows
_QUERIES = 40_000  # samples whose neighbours are searched, at most,
_QUERIES_PER_BLOCK = 5  # and of a block, of which the mean takes in fifty
_NEIGHBOURS = 40
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
        return np.asarray(self.px[r[:, None], c])


def local_gaps(at: Float, raster: OrthoRaster, typical: float) -> Gaps:
    """Measures the local gaps of samples (n, 2) px by blocks of about half a metre.

    A gap is given as the spacing ``1 / sqrt(density)`` of points scattered at random that leave the same gap.
    It is at least a quarter of `typical`, the spacing of the wall in px; blocks are at least eight times as
    wide as that. A block without samples nearby takes the value of the nearest block.
    """
    block = max(1, round(_BLOCK_M / raster.gsd), int(np.ceil(8 * typical)))
    blocks = raster.coarser(block)
    place, gap = _sector_gap(at, _QUERIES_PER_BLOCK * blocks.height * blocks.width)
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


def _sector_gap(at: Float, queries: int) -> tuple[Float, Float]:
    """Returns the positions (k, 2) of some of the samples (n, 2) and the gaps (k,) around them, in px.

    Several samples of one pixel count as one. A gap is infinite where there are too few samples nearby.
    `queries` is how many samples are wanted; at most `_QUERIES` are looked at.
    """
    column, row = np.floor(at).astype(np.int64).T
    first, rows = (int(row.min()), int(np.ptp(row)) + 1) if len(row) else (0, 1)
    flat = gridding.distinct_cells(column * rows + row - first, (int(column.max(initial=0)) + 1) * rows)
    pixel: Float = np.column_stack([flat // rows, flat % rows + first]).astype(np.float64) + 0.5
    place = pixel[:: max(1, len(pixel) // min(queries, _QUERIES))]
    k = min(_NEIGHBOURS, len(pixel) - 1)
    if k < _SECTORS:
        return place, np.full(len(place), np.inf)
    tree = cKDTree(pixel, balanced_tree=False, compact_nodes=False)
    distance, index = (np.asarray(a) for a in tree.query(place, k + 1, workers=1))
    offset = pixel[index[:, 1:]] - place[:, None]
    angle = np.arctan2(offset[..., 1], offset[..., 0])
    sector = np.floor((angle + np.pi) / (2 * np.pi) * _SECTORS).astype(np.int64) % _SECTORS
    nearest = np.full((len(place), _SECTORS), np.inf)
    np.minimum.at(nearest, (np.arange(len(place))[:, None], sector), distance[:, 1:])
    third: Float = np.sort(nearest, axis=1)[:, -3]
    return place, third / _POISSON
