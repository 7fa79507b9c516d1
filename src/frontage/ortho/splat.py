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

from frontage.geometry.arrays import Array, Bool, Float, picked_rows
from frontage.ortho.gaps import Gaps
from frontage.ortho.orthoraster import OrthoRaster
from frontage.raster import gridding
from frontage.raster.tiles import Tile, tiles

_ROWS, _COLUMNS = 256, 4096  # of cells that are drawn at once, so that they stay in the cache
_CLOSING = 2.0  # spacings: fills 99.9 % of a surface sampled at random
_LONE = 3.0  # spacings: real surfaces have more dropouts; a lone gap up to this width is not a window
_DENSE_PX = 0.7  # closer samples leave no pixel empty
_OPENING = 0.5  # spacings: narrower pieces are stray samples
_REACH = 8.0  # spacings around a tile on which its pixels depend
_SIGMA = 0.55  # spacings: the Gaussian that joins the samples of a square lattice without visible dots
_LEAST = 0.3  # px, sigma of the narrowest Gaussian
_NARROW = 0.35  # px, sigma of a Gaussian that changes nothing
_RATIO = 1.25  # between the widths of the Gaussians from which each pixel takes one
_WIDER = 3.0  # times as wide a Gaussian is tried where too few samples are near
_DENSEST = 0.1  # share of the surface on which samples may be closer together than cells are wide
_HALF = 0.5  # share of known cells around a pixel, from which on it is known
_TAIL = 4.0  # sigmas after which a Gaussian is cut


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
        at, value = picked_rows(inside, at), np.compress(inside, value, axis=0)
    return Samples(at, value, gaps)


def splat(samples: Samples, raster: OrthoRaster, out: Array, known: Array) -> None:
    """Writes values to `out` (h, w, k) and True to `known` (h, w) where there is a surface, strip by strip.

    Where samples are sparser than pixels, they are joined on cells as wide as their spacing, which resolve
    what the samples do, and the cells are enlarged.
    """
    step = max(1, round(float(np.quantile(samples.gaps.px, _DENSEST))))
    cells = raster.coarser(step)
    order, band = gridding.by_rows(samples.at[:, 1] / step)
    at, value = np.take(samples.at.T, order, axis=1), np.take(samples.value, order, axis=0)
    at /= step
    for tile in tiles(cells.height, cells.width, _ROWS, _COLUMNS):
        reach = _reach(samples.gaps, tile, step)
        r0, c0 = tile.r0 - reach, tile.c0 - reach
        shape = (tile.shape[0] + 2 * reach, tile.shape[1] + 2 * reach)
        part = gridding.of_rows(band, r0, r0 + shape[0])
        cell, inside = gridding.cell_index((at[:, part] - np.array([[c0], [r0]], at.dtype)).T, shape)
        if not len(cell):
            continue
        spacing = samples.gaps.at(*(np.arange(n, n + m) * step for n, m in zip((r0, c0), shape, strict=True)))
        spacing /= np.float32(step)
        mean, mask = _spread(cell, np.compress(inside, value[part], axis=0), shape, spacing)
        inner = (slice(reach - 1, 1 - reach), slice(reach - 1, 1 - reach))
        place = np.s_[tile.r0 * step :, tile.c0 * step :]
        _enlarged(mean[inner], mask[inner], step, out[place], known[place])


def _enlarged(mean: Array, mask: Bool, step: int, out: Array, known: Array) -> None:
    """Writes cells (m, n, k) and which of them are known to pixels, `step` x `step` for each cell.

    The outermost cells only help to interpolate.
    """
    inner = (slice(step, (len(mask) - 1) * step), slice(step, (mask.shape[1] - 1) * step))
    h, w = (min(a.stop - a.start, size) for a, size in zip(inner, known.shape, strict=True))
    if step == 1:
        shown = mask[1:-1, 1:-1][:h, :w]
        np.copyto(out[:h, :w], mean[1:-1, 1:-1][:h, :w], where=shown[..., None])
        known[:h, :w] = shown
        return
    size = (mask.shape[1] * step, len(mask) * step)
    weight = cv2.resize(mask.astype(np.float32), size)[inner][:h, :w]
    summed = cv2.resize(mean, size).reshape(*size[::-1], -1)  # the mean is zero where it is not known
    known[:h, :w] = weight > _HALF
    _divided(summed[inner][:h, :w], weight, known[:h, :w], out[:h, :w])


def _divided(total: Array, weight: Array, where: Bool, out: Array) -> None:
    """Writes totals (h, w, k) over weights (h, w) where they are wanted (h, w).

    OpenCV takes a small part of the time of numpy with a mask.
    """
    mask = np.ascontiguousarray(where).view(np.uint8)
    for k in range(total.shape[2]):
        band = np.ascontiguousarray(out[..., k])
        cv2.copyTo(cv2.divide(np.ascontiguousarray(total[..., k]), weight), mask, band)
        out[..., k] = band


def _reach(gaps: Gaps, tile: Tile, step: int) -> int:
    """The cells of `step` px around a tile on which its cells depend, by the widest gap in and around it."""
    most = int(np.ceil(_REACH * max(step, float(gaps.px.max()))))
    rows, columns = (
        np.arange(first * step - most, last * step + most, gaps.step)
        for first, last in ((tile.r0, tile.r1), (tile.c0, tile.c1))
    )
    return int(np.ceil(_REACH * max(1.0, float(gaps.at(rows, columns).max()) / step))) + 2


def _surface(sampled: Array, spacing: Array) -> Array:
    """Returns the mask (h, w) of a surface that was sampled with a spacing (h, w) px.

    Gaps are closed and stray samples removed. A gap that the closing only just missed is filled completely;
    a wider one is a hole.
    """
    mask = gridding.closed(sampled, _CLOSING * spacing)
    count, holes = cv2.connectedComponents((~mask).view(np.uint8), connectivity=4)
    lone = np.ones(count, np.bool_)
    lone[holes[~gridding.grown(sampled, _LONE * spacing)]] = False  # a disc of that radius fits into the hole
    lone[0] = True
    mask = lone[holes]
    opened: Array = ~gridding.closed(~mask, _OPENING * spacing)
    return opened


def _spread(cell: Array, value: Array, shape: tuple[int, int], spacing: Array) -> tuple[Array, Bool]:
    """Returns mean (h, w, k) and mask (h, w) of points by flat cell number, spread by the spacing (cells)."""
    size, channels = shape[0] * shape[1], value.shape[1]
    count = np.bincount(cell, minlength=size).reshape(shape).astype(np.float32)
    total = np.empty((*shape, channels), np.float32)
    for k in range(channels):
        total[..., k] = np.bincount(cell, value[:, k], size).reshape(shape)
    mask = _surface(count > 0, np.where(spacing > _DENSE_PX, spacing, 0.0))
    mean = np.zeros_like(total)
    wanted = np.maximum(_SIGMA * spacing, _LEAST)
    left, widest = mask.copy(), _WIDER * float(wanted.max())
    for sigma in _LEAST * _RATIO ** np.arange(np.ceil(np.log(widest / _LEAST) / np.log(_RATIO)) + 1):
        want = left & (wanted <= 1.001 * sigma)
        columns = np.flatnonzero(want.any(0))
        if len(columns):
            part = np.s_[:, columns[0] : columns[-1] + 1]
            left[part] &= ~_means(count, total, want, sigma, part, mean)
    return mean, mask & ~left


def _means(
    count: Array, total: Array, want: Bool, sigma: float, part: tuple[slice, slice], mean: Array
) -> Bool:
    """Writes the means (h, w, k) of the samples around the wanted pixels of a part, and returns where.

    Where the Gaussian reaches too few samples, nothing is written.
    """
    tail = int(np.ceil(_TAIL * sigma)) + 1 if sigma > _NARROW else 0
    first = max(part[1].start - tail, 0)
    around, inner = np.s_[:, first : part[1].stop + tail], np.s_[:, part[1].start - first :]
    weight, summed = count[around], total[around]
    if tail:
        weight, blurred = (cv2.GaussianBlur(a, (0, 0), sigma) for a in (weight, summed))
        summed = blurred.reshape(summed.shape)
    weight, summed = (a[inner][:, : part[1].stop - part[1].start] for a in (weight, summed))
    good = want[part] & (weight > 0.02 / max(1.0, sigma * sigma))
    _divided(summed, weight, good, mean[part])
    return np.asarray(good)
