"""Draws pixels from the points of the scan by splatting that adapts to the gaps between them.

The points of a pixel are averaged. Where points are sparser than pixels, their values are spread by a
Gaussian of about half the local spacing. On a surface sampled at random with spacing s, a disc of radius R is
empty with probability ``exp(-pi (R / s)^2)``. Closing by discs of two spacings therefore fills all but a
thousandth of the surface, and what is still empty is a hole. Closing does not grow outer edges, so that
nothing is smeared across a window.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.ortho.gaps import Gaps
from frontage.ortho.orthoraster import OrthoRaster
from frontage.raster import gridding
from frontage.raster.tiles import tiles

_TILE_PX = 1024
_CLOSING = 2.0  # spacings: fills 99.9 % of a surface sampled at random
_LONE = 3.0  # spacings: real surfaces have more dropouts; a lone gap up to this width is not a window
_DENSE_PX = 0.7  # closer samples leave no pixel empty
_OPENING = 0.5  # spacings: narrower pieces are stray samples
_REACH = 8.0  # spacings around a tile on which its pixels depend
_SIGMA = 0.55  # spacings: the Gaussian that joins the samples of a square lattice without visible dots
_NARROW = 0.35  # px, sigma of a Gaussian that changes nothing
_RATIO = 1.5  # between the widths of the Gaussians from which each pixel takes one


@dataclass(frozen=True)
class Samples:
    """Points on the surface: pixel positions (n, 2), values (n, k) and the local gaps between them."""

    at: Float
    value: Array
    gaps: Gaps


def surface_samples(xyz_facade: Float, value: Array, raster: OrthoRaster, gaps: Gaps) -> Samples:
    """Returns those points (n, 3) m of the surface, with their values (n, k), that lie on the raster."""
    at = raster.pixel(xyz_facade)
    _, inside = gridding.cell_index(at, (raster.height, raster.width))
    if not inside.all():
        at, value = np.compress(inside, at, axis=0), np.compress(inside, value, axis=0)
    return Samples(at, value, gaps)


def splat(samples: Samples, raster: OrthoRaster, out: Array, known: Array) -> None:
    """Writes values to `out` (h, w, k) and True to `known` (h, w) where there is a surface, tile by tile."""
    order, band = gridding.by_rows(samples.at[:, 1])
    at, value = (np.take(a, order, axis=0) for a in (samples.at, samples.value))
    reach = int(np.ceil(_REACH * max(1.0, float(samples.gaps.px.max())))) + 2
    for tile in tiles(raster.height, raster.width, _TILE_PX):
        r0, c0 = tile.r0 - reach, tile.c0 - reach
        shape = (tile.shape[0] + 2 * reach, tile.shape[1] + 2 * reach)
        part = gridding.of_rows(band, r0, r0 + shape[0])
        cell, inside = gridding.cell_index(at[part] - [c0, r0], shape)
        if not len(cell):
            continue
        inner = (slice(reach, -reach), slice(reach, -reach))
        radius = samples.gaps.at(np.arange(r0, r0 + shape[0]), np.arange(c0, c0 + shape[1]))
        mean, mask = _spread(cell, np.compress(inside, value[part], axis=0), shape, radius)
        out[tile.window] = mean[inner]
        known[tile.window] = mask[inner]


def _surface(sampled: Array, spacing: Array) -> Array:
    """Returns the mask (h, w) of a surface that was sampled with a spacing (h, w) px.

    Gaps are closed and stray samples removed. A gap that the closing only just missed is filled completely;
    a wider one is a hole.
    """
    mask = gridding.closed(sampled, _CLOSING * spacing)
    _, holes = cv2.connectedComponents((~mask).astype(np.uint8), connectivity=4)
    open_still = np.zeros(holes.max() + 1, bool)
    open_still[holes[~gridding.closed(sampled, _LONE * spacing)]] = True
    mask |= ~open_still[holes]
    opened: Array = ~gridding.closed(~mask, _OPENING * spacing)
    return opened


def _spread(cell: Array, value: Array, shape: tuple[int, int], spacing: Array) -> tuple[Array, Array]:
    """Returns mean (h, w, k) and mask (h, w) of points by flat pixel number, spread by the spacing px."""
    size, channels = shape[0] * shape[1], value.shape[1]
    count = np.bincount(cell, minlength=size).reshape(shape).astype(np.float32)
    total = np.empty((*shape, channels), np.float32)
    for k in range(channels):
        total[..., k] = np.bincount(cell, value[:, k], size).reshape(shape)
    mask = _surface(count > 0, np.where(spacing > _DENSE_PX, spacing, 0.0))
    mean = np.zeros_like(total)
    filled = np.zeros(shape, bool)
    low, high = max(0.3, _SIGMA * float(spacing.min())), max(0.3, _SIGMA * float(spacing.max()))
    levels = max(1, int(np.ceil(np.log(high / low) / np.log(_RATIO))) + 1)
    for sigma in low * _RATIO ** np.arange(levels + 3):
        want = mask & ~filled & (_SIGMA * spacing <= sigma * 1.001)
        if not want.any():
            continue
        weight, summed = count, total
        if sigma > _NARROW:
            weight = cv2.GaussianBlur(count, (0, 0), sigma)
            summed = cv2.GaussianBlur(total, (0, 0), sigma).reshape(total.shape)
        good = want & (weight > 0.02 / max(1.0, sigma * sigma))
        np.divide(summed, weight[..., None], out=mean, where=good[..., None])
        filled |= good
    return mean, mask & filled
