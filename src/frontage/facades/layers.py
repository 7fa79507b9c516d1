"""Find the layers of a facade: surfaces parallel to its plane, as peaks in the density of the offsets."""

import numpy as np
from scipy import ndimage, signal

from frontage.facades.cells import CellMap
from frontage.geometry.arrays import Array, Float, Int, distinct
from frontage.geometry.ring import convex_ring
from frontage.model.facade import Layer

_LEAST_AREA_M2 = 1.0  # m2: a window of frames, a strip of plinth
_LEAST_SHARE = 0.02  # share of the wall's area that a layer covers, at least
_MOST_LAYERS = 8  # plinth, wall, pilasters, frames, panes, balcony fronts, cornice, recess
_BIC_GAIN = 10.0  # "very strong" evidence (Kass and Raftery 1995)
_FINEST_M = 0.002  # m, least width of a bin
_HALF_SIGMAS = 2.5  # half thickness of a layer, in sigmas of the wall
_APART_SIGMAS = 3.0  # least distance between two layers, in sigmas of the wall
_BACKGROUND = (-3, -2, 2, 3)  # neighbouring windows that tell a layer's background
_CLEAR_M = 0.05  # m: a surface at an angle has a point this near in every cell, whatever the spacing
_WIDE = 4.0  # times the half thickness, where a parallel surface leaves its cells empty


class SortedOffsets:
    """Points sorted by their offset from the plane.

    y     (n,) m, ascending
    cell  (n,) cell of each point on a raster of `size` cells
    """

    def __init__(self, y: Float, flat: Int, size: int) -> None:
        order = np.argsort(y)
        self.y, self.cell, self.size = y[order], flat[order], size

    def window(self, at: float, half: float) -> slice:
        """Returns the slice of the points within `half` m of the offset `at` m."""
        return slice(*np.searchsorted(self.y, [at - half, at + half]))

    def area(self, low: float, width: float, bins: int) -> Float:
        """Counts the cells (bins,) with a point in each bin of `width` m, beginning at `low` m."""
        level = np.clip(((self.y - low) * (1.0 / width)).astype(np.int64), 0, bins - 1)
        held = distinct(level * self.size + self.cell) // self.size
        return np.bincount(held, minlength=bins).astype(np.float64)

    def cells(self, at: float, half: float) -> Int:
        """Returns the cells (k,) of a parallel surface at the offset `at` m, within `half` m of it.

        Most points that such a cell holds near the offset lie on the surface. Reveals and other surfaces at
        an angle pass through every offset, and their cells hold points at all of them.
        """
        on = np.bincount(self.cell[self.window(at, half)], minlength=self.size)
        near = np.bincount(self.cell[self.window(at, max(_WIDE * half, _CLEAR_M))], minlength=self.size)
        return np.flatnonzero((on > 0) & (2 * on > near))


def find_layers(
    y: Float, flat: Int, cells: CellMap, sigma: float, reach: tuple[float, float]
) -> tuple[Layer, ...]:
    """Finds the layers of a facade, nearest to the street first.

    y      (n,) m, offsets of the points from the plane, within `reach`
    flat   (n,) cell of each point in `cells`
    sigma  m, robust standard deviation of the wall about its plane
    reach  m, (front < 0, back > 0)

    Area is counted, not points: every cell counts once per bin of sigma / 2. A peak of the kernel density
    (bandwidth sigma) is a layer when it holds more cells than the neighbouring windows by a BIC gain above
    10 (Poisson), covers a square metre and 2 % of the wall, and no stronger layer lies within 3 sigma. At
    most eight layers are returned, those with the most evidence; the wall itself (y = 0) is among them.
    """
    if len(y) == 0:
        return ()
    offsets = SortedOffsets(y, flat, cells.whole.size)
    width, half = max(0.5 * sigma, _FINEST_M), _HALF_SIGMAS * sigma
    area = offsets.area(reach[0], width, int(np.ceil((reach[1] - reach[0]) / width)) + 1)
    found = {0.0: np.inf}  # the wall itself is at y = 0 by construction
    least = max(_LEAST_AREA_M2, _LEAST_SHARE * cells.area) / cells.cell**2
    for at in _peaks(area, reach[0], width, sigma):
        number = len(offsets.cells(at, half))
        if number < least:
            continue
        background = [len(offsets.cells(at + 2.0 * k * half, half)) for k in _BACKGROUND]
        gain = _bic_gain(number, float(np.median(background)), len(y))
        if gain > _BIC_GAIN:
            found[at] = gain
    kept: list[float] = []
    for at in sorted(found, key=lambda at: (-found[at], at)):
        if len(kept) < _MOST_LAYERS and all(abs(at - other) > _APART_SIGMAS * sigma for other in kept):
            kept.append(at)
    layers = (_layer(at, offsets, cells, half) for at in sorted(kept))
    return tuple(layer for layer in layers if layer is not None)


def _peaks(area: Float, low: float, width: float, sigma: float) -> list[float]:
    """Offsets (m) of the peaks of the smoothed area, without the wall's own."""
    density = ndimage.gaussian_filter1d(area, sigma / width, mode="constant")
    peaks, _ = signal.find_peaks(density, distance=max(1, round(_APART_SIGMAS * sigma / width)))
    return [float(at) for at in low + (peaks + 0.5) * width if abs(at) > _APART_SIGMAS * sigma]


def _bic_gain(number: int, expected: float, points: int) -> float:
    """BIC gain of `number` cells over the `expected` number of the background (Poisson).

    Returns -inf unless there are half as many again as expected.
    """
    expected = max(expected, 1.0)
    if number < 1.5 * expected:
        return -np.inf
    return float(
        2.0 * (number * np.log(number / expected) - (number - expected)) - 2.0 * np.log(max(points, 2))
    )


def _layer(at: float, offsets: SortedOffsets, cells: CellMap, half: float) -> Layer | None:
    """Makes the layer at the offset `at` m from the points within `half` m of it."""
    inside = offsets.y[offsets.window(at, half)]
    held = offsets.cells(at, half)
    if len(inside) == 0 or len(held) == 0:
        return None
    r, c = np.divmod(held, cells.whole.shape[1])
    height = 0.0 if at == 0.0 else float(np.median(inside))
    spread = float(np.std(inside)) / np.sqrt(len(held))
    return Layer(height, spread, len(held) * cells.cell**2, _ring(r, c, cells))


def _ring(row: Array, column: Array, cells: CellMap) -> Float:
    """Convex ring (k, 2) m around cells: a layer (all window frames of a facade) is rarely connected."""
    h = cells.wall.shape[0]
    first, last = np.full(h, np.iinfo(np.int64).max), np.full(h, -1)
    np.minimum.at(first, row, column)
    np.maximum.at(last, row, column)
    used = np.flatnonzero(last >= 0)
    ends = np.concatenate(
        [np.column_stack([c, used + up]) for c in (first[used], last[used] + 1) for up in (0, 1)]
    )
    return convex_ring(ends * cells.cell + np.asarray(cells.corner))
