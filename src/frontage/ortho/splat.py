"""Pixels from the scan's own points: gap-aware splatting.

Points of a pixel are averaged; where points are sparser than pixels the values are spread by a Gaussian of
half the local spacing. Gaps narrower than three spacings are closed, wider ones (windows, shadows) stay
empty, and no outer edge grows: nothing is smeared across a window.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.ortho.frame import Raster
from frontage.raster import gridding
from frontage.raster.tiles import tiles

_TILE = 1024
_CLOSING = 1.5  # spacings: discs of this radius close gaps up to three spacings wide
_SIGMA = 0.55  # spacings: Gaussian that joins the samples of a square lattice without visible dots
_OCTAVE = 1.5  # ratio of the Gaussians among which a pixel picks


@dataclass(frozen=True)
class Samples:
    """Points on the surface: pixel positions (n, 2), values (n, k), and the local spacing by coarse block."""

    at: Float
    value: Array
    spacing: Raster
    spacing_px: Array


def surface_samples(xyz_facade: Float, value: Array, raster: Raster, spacing: float) -> Samples:
    """Points (n, 3) m of the surface with their values (n, k) on the raster; spacing m is typical."""
    at = raster.pixel(xyz_facade)
    c, r = np.floor(at).astype(np.int64).T
    inside = (c >= 0) & (c < raster.width) & (r >= 0) & (r < raster.height)
    at, value = at[inside], value[inside]
    block = max(1, int(np.ceil(8 * spacing / raster.gsd)))
    blocks = raster.coarser(block)
    return Samples(at, value, blocks, _spacing_px(at, blocks, block, spacing / raster.gsd))


def _spacing_px(at: Float, blocks: Raster, block: int, typical: float) -> Array:
    """Spacing (h, w) px by block, from the densest block within a metre or so (an empty one is a window)."""
    cell, _ = gridding.cell_index(at / block, (blocks.height, blocks.width))
    count = np.bincount(cell, minlength=blocks.height * blocks.width).reshape(blocks.height, blocks.width)
    dense = cv2.dilate(count.astype(np.float32), np.ones((5, 5), np.uint8))
    spacing: Array = np.clip(block / np.sqrt(np.maximum(dense, 1.0)), 0.25 * typical, 4.0 * typical)
    return spacing


def splat(samples: Samples, raster: Raster, out: Array, known: Array) -> None:
    """Write values (h, w, k) to `out` and True to `known` (h, w) where there is a surface, tile by tile."""
    order = np.argsort(samples.at[:, 1], kind="stable")
    at, value = samples.at[order], samples.value[order]
    reach = int(np.ceil(3.0 * max(1.0, float(samples.spacing_px.max())))) + 2
    for tile in tiles(raster.height, raster.width, _TILE):
        r0, c0 = tile.r0 - reach, tile.c0 - reach
        shape = (tile.shape[0] + 2 * reach, tile.shape[1] + 2 * reach)
        a, b = np.searchsorted(at[:, 1], [r0, r0 + shape[0]])
        cell, inside = gridding.cell_index(at[a:b] - [c0, r0], shape)
        if not len(cell):
            continue
        inner = (slice(reach, -reach), slice(reach, -reach))
        rows = np.clip(np.arange(r0, r0 + shape[0]), 0, raster.height - 1)
        columns = np.clip(np.arange(c0, c0 + shape[1]), 0, raster.width - 1)
        ratio = round(samples.spacing.gsd / raster.gsd)
        radius = samples.spacing_px[rows[:, None] // ratio, columns // ratio]
        mean, mask = _spread(cell, value[a:b][inside], shape, radius)
        out[tile.window] = mean[inner]
        known[tile.window] = mask[inner]


def _spread(cell: Array, value: Array, shape: tuple[int, int], spacing: Array) -> tuple[Array, Array]:
    """Mean (h, w, k) and mask (h, w) of points by flat pixel number, spread by the spacing (h, w) px."""
    count = np.bincount(cell, minlength=shape[0] * shape[1]).reshape(shape).astype(np.float32)
    total = np.stack(
        [np.bincount(cell, value[:, k], shape[0] * shape[1]).reshape(shape) for k in range(value.shape[1])],
        axis=-1,
    ).astype(np.float32)
    mask = gridding.closed(count > 0, np.where(spacing > 1.0, _CLOSING * spacing, 0.0))
    mean = np.zeros_like(total)
    filled = np.zeros(shape, bool)
    low, high = max(0.3, _SIGMA * float(spacing.min())), max(0.3, _SIGMA * float(spacing.max()))
    levels = max(1, int(np.ceil(np.log(high / low) / np.log(_OCTAVE))) + 1)
    for sigma in low * _OCTAVE ** np.arange(levels + 3):
        want = mask & ~filled & (_SIGMA * spacing <= sigma * 1.001)
        if not want.any():
            continue
        weight = cv2.GaussianBlur(count, (0, 0), sigma) if sigma > 0.35 else count
        summed = cv2.GaussianBlur(total, (0, 0), sigma) if sigma > 0.35 else total
        good = want & (weight > 0.02 / max(1.0, sigma * sigma))
        mean[good] = summed.reshape(*shape, -1)[good] / weight[good][:, None]
        filled |= good
    return mean, mask & filled & (cv2.GaussianBlur(mask.astype(np.float32), (0, 0), _soft(spacing)) > 0.5)


def _soft(spacing: Array) -> float:
    """Sigma px of the smoothing that takes the scallops of the discs off the mask's edge."""
    return max(0.3, 0.7 * float(np.median(spacing)))
