"""How far apart the samples of a surface are, place by place: what tells a sparse wall from a hole.

A scan is dense below its station and sparse along the street, with more lines than columns or the other way
round. What matters for filling is the *gap* between neighbours, whatever its direction: of the nearest
neighbours in eight sectors around a sample, the third farthest (an edge leaves half of the sectors empty, a
line of samples leaves six off the line). Holes have no samples and sparse returns from inside a window are
few, so the mean over two metres, each sample counting once, is the wall's.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Array, Float
from frontage.ortho.orthoraster import OrthoRaster
from frontage.raster import gridding

_COARSEST = 0.25  # m: closing the gaps of a sparser cloud would close windows
_QUERIES = 40_000  # samples asked for their neighbours
_NEIGHBOURS = 40
_SECTORS = 8
_POISSON = float(
    np.sqrt(8.0 / np.pi * np.log(1.0 / 0.25))
)  # 75 % quantile of a sector's nearest, in spacings
_BLOCK = 0.5  # m
_REACH = 1.0  # m: sigma of the mean over the surroundings


@dataclass(frozen=True)
class Gaps:
    """Spacing (h, w) px float32 by block of `step` pixels of a raster."""

    step: int
    px: Array

    def at(self, rows: Array, columns: Array) -> Array:
        """Spacing (m, n) px at rows (m,) and columns (n,) of pixels, the border's outside."""
        h, w = self.px.shape
        r, c = np.clip(rows // self.step, 0, h - 1), np.clip(columns // self.step, 0, w - 1)
        return np.asarray(self.px[r[:, None], c])


def local_gaps(at: Float, raster: OrthoRaster, typical: float) -> Gaps:
    """Local gaps of samples (n, 2) px by block of about half a metre, `typical` px being the wall's spacing.

    As spacings ``1 / sqrt(density)`` of points strewn at random that leave the same gaps; no smaller than a
    quarter of the typical one. Blocks are no smaller than eight of it. Where no sample is near, that of the
    nearest block.
    """
    block = max(1, round(_BLOCK / raster.gsd), int(np.ceil(8 * typical)))
    blocks = raster.coarser(block)
    place, gap = _sector_gap(at)
    known = np.isfinite(gap)
    cell, inside = gridding.cell_index(place[known] / block, (blocks.height, blocks.width))
    gap = gap[known][inside]
    size = blocks.height * blocks.width
    count = np.bincount(cell, minlength=size).reshape(blocks.height, blocks.width).astype(np.float32)
    total = np.bincount(cell, np.log(gap), size).reshape(count.shape).astype(np.float32)
    sigma = _REACH / (raster.gsd * block)
    if sigma > 0.3:
        count, total = (
            cv2.GaussianBlur(g, (0, 0), sigma, borderType=cv2.BORDER_CONSTANT) for g in (count, total)
        )
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(count > 1e-3, np.exp(total / count), np.nan)
    filled = gridding.nearest_filled(mean.astype(np.float32))
    filled = np.where(np.isfinite(filled), filled, np.float32(typical))
    return Gaps(block, np.clip(filled, 0.25 * typical, max(_COARSEST / raster.gsd, 0.25 * typical)))


def _sector_gap(at: Float) -> tuple[Float, Float]:
    """Positions (k, 2) of some samples of (n, 2) and the gaps (k,) around them, px; inf where few are near.

    Samples of one pixel count as one.
    """
    pixel: Float = np.unique(np.floor(at).astype(np.int64), axis=0).astype(np.float64) + 0.5
    place = pixel[:: max(1, len(pixel) // _QUERIES)]
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
