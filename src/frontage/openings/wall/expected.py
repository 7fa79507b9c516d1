"""Predicts how many beams a piece of wall would return, from the wall around it."""

from functools import lru_cache

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float
from frontage.openings.wall.density import triangulated_density
from frontage.openings.wall.raster import WallRaster

_AROUND = 0.5  # m, one sigma of the surroundings
_CUT = 0.05  # share of wall in the surroundings below which nothing is expected
_FEW = 2.0  # beams that a cell must hold for its neighbours to be predicted from it
_REACH = 3.0  # sigmas that a blur reaches
_COARSEST = 0.2  # m: larger cells are cut by openings
_EVEN = 32  # columns: with a multiple of them, blocks of blocks begin at the same places when mirrored


def expected_beams(points: Float, raster: WallRaster) -> Float:
    """Returns the number of beams (h, w) that cells of wall would return; 0 where no wall is near.

    `points` (n, 2) m are those on the wall. Where the cells hold too few of them, larger cells predict, four
    times as large until they hold two points on average, for the density varies with distance and incidence.
    Where those hold too few as well, the triangles between neighbouring points predict. Wide openings are
    predicted from further around.
    """
    counts = raster.count(*points.T)
    aside = -counts.shape[1] % _EVEN // 2
    own = slice(aside, aside + counts.shape[1])
    wide, uncertain = _by_cells(np.pad(counts, ((0, 0), (aside, aside))), raster.cell)
    due, sparse = np.array(wide[:, own]), uncertain[:, own]
    if sparse.any():
        flat = raster.flat(*points.T)
        beside = points[(flat >= 0) & sparse.ravel()[flat]]
        due[sparse] = raster.cell**2 * triangulated_density(beside, raster.middles(sparse), 2.0 * _AROUND)
    return due


def _by_cells(solid: Float, cell: float) -> tuple[Float, Bool]:
    """Returns the beams (h, w) that larger and larger cells predict, and where the largest hold too few.

    `solid` (h, w) are the points of the wall in cells of `cell` m.
    """
    due, left, sparse = np.zeros(solid.shape), np.ones(solid.shape, np.bool_), np.zeros(solid.shape, np.bool_)
    steps = [1]
    while steps[-1] * 2 * cell <= _COARSEST:
        steps.append(steps[-1] * 2)
    for step, around in [*((s, _AROUND) for s in steps), (steps[-1], 2.0 * _AROUND)]:
        mean, cover = _mean_hits(_blocks(solid, step), around / (step * cell))
        told = left & _spread((cover > _CUT) & ((mean >= _FEW) | (step == steps[-1])), step, solid.shape)
        due = np.where(told, _spread(mean / step**2, step, solid.shape), due)
        sparse |= told & _spread(mean < _FEW, step, solid.shape)
        left &= ~told
    return due, sparse


def _mean_hits(hits: Float, wide: float) -> tuple[Float, Float]:
    """Returns the Poisson mean of those cells (h, w) that are wall, and the share of such cells around.

    The mean of the cells with a hit is lam / (1 - exp(-lam)), which is inverted.
    """
    held, total = (blurred(m, wide) for m in ((hits > 0).astype(np.float64), hits))
    mean = total / np.maximum(held, 1e-9)
    lam = np.geomspace(1e-3, 1e4, 400)
    found = np.interp(mean, lam / -np.expm1(-lam), lam)
    return found, held / -np.expm1(-found)


def blurred(values: Float, wide: float) -> Float:
    """Blurs values (h, w) with a Gaussian of `wide` cells; for speed, on blocks of up to a quarter of that.

    Blocks of an even number of cells begin at the same places in a mirrored facade.
    """
    step = max(2 * int(wide / 8.0), 1)
    small = _blocks(values, step) / step**2
    kernel = _gaussian(wide / step)
    smooth = cv2.sepFilter2D(small, -1, kernel, kernel, borderType=cv2.BORDER_CONSTANT)
    return _spread(smooth, step, values.shape)


@lru_cache(maxsize=32)
def _gaussian(sigma: float) -> Float:
    """Returns a Gaussian (2 k + 1,) of `sigma` cells up to three sigmas, whose sum is 1."""
    reach = int(_REACH * sigma + 0.5)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    return np.asarray(kernel / kernel.sum())


def _blocks(values: Float, step: int) -> Float:
    """Sums values (h, w) over blocks of step x step cells, which are centred from left to right."""
    if step == 1:
        return values
    h, w = values.shape
    left = -w % step // 2
    padded = np.pad(values, ((0, -h % step), (left, -w % step - left)))
    rows = padded.reshape(-(-h // step), step, -1).sum(1)  # numpy adds whole rows faster than single cells
    return np.asarray(sum(rows[:, k::step] for k in range(step)))


def _spread(values: Array, step: int, shape: tuple[int, ...]) -> Array:
    """Gives every cell the value of its block."""
    if step == 1:
        return values
    left = -shape[1] % step // 2
    return np.repeat(np.repeat(values, step, 0), step, 1)[: shape[0], left : left + shape[1]]
