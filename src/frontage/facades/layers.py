"""Layers: surfaces parallel to the facade plane, as peaks of the density of signed offsets."""

import numpy as np
from scipy import ndimage, signal

from frontage.facades.cells import CellMap
from frontage.geometry.arrays import Float, Int
from frontage.geometry.ring import convex_ring
from frontage.model.facade import Layer

_LEAST_AREA = 0.5  # m2: half a window of frames, a strip of plinth
_BIC_GAIN = 10.0  # "very strong" evidence (Kass and Raftery 1995)


def find_layers(q: Float, cells: CellMap, sigma: float, reach: tuple[float, float]) -> tuple[Layer, ...]:
    """Layers of points q (n, 3) m in the facade frame with y in `reach` (front < 0 < back), nearest first.

    Area is counted: every cell counts once per bin of sigma / 2. A peak of the kernel density (bandwidth
    sigma) is kept when a Gaussian layer on a locally constant background beats the background alone by a
    BIC gain above 10 and covers half a square metre.
    """
    width = max(0.5 * sigma, 0.001)
    use = (q[:, 1] > reach[0]) & (q[:, 1] < reach[1])
    q = q[use]
    if len(q) == 0:
        return ()
    row, column, _ = cells.locate(q[:, 0], q[:, 2])
    flat_cell = row * cells.wall.shape[1] + column
    level = ((q[:, 1] - reach[0]) / width).astype(np.int64)
    bins = int(np.ceil((reach[1] - reach[0]) / width)) + 1
    pairs = np.unique(flat_cell * bins + level)
    histogram = np.bincount(pairs % bins, minlength=bins).astype(np.float64)
    density = ndimage.gaussian_filter1d(histogram, sigma / width, mode="constant")
    peaks, _ = signal.find_peaks(density, distance=max(1, round(3 * sigma / width)))
    # the wall itself is at y = 0 by construction, whatever the smoothing makes of its neighbours
    here = round(-reach[0] / width)
    peaks = np.unique(np.append(peaks[np.abs(peaks - here) > 3 * sigma / width], here))
    background = ndimage.median_filter(density, size=2 * round(10 * sigma / width) + 1, mode="nearest")
    found = [
        layer
        for p in peaks
        if (
            layer := _layer(
                reach[0] + (p + 0.5) * width,
                q,
                flat_cell,
                cells,
                sigma,
                float(background[p]),
                width,
                bool(p == here),
            )
        )
        is not None
    ]
    return tuple(sorted(found, key=lambda layer: layer.y))


def _layer(
    y: float,
    q: Float,
    flat_cell: Int,
    cells: CellMap,
    sigma: float,
    background: float,
    width: float,
    is_wall: bool,
) -> Layer | None:
    """The layer at offset y,
    or None when it is too small or no better than its background (cells per bin).
    """
    near = np.abs(q[:, 1] - y) < 2.5 * sigma
    distinct = np.unique(flat_cell[near])
    area = len(distinct) * cells.cell**2
    if not is_wall:
        expected = max(background * 5.0 * sigma / width, 1.0)
        number = float(len(distinct))
        gain = 2.0 * (number * np.log(max(number, 1.0) / expected) - (number - expected))
        gain -= 2.0 * np.log(max(len(q), 2))
        if area < _LEAST_AREA or number < 1.5 * expected or gain < _BIC_GAIN:
            return None
    if not near.any():
        return None
    height = float(np.median(q[near, 1]))
    spread = float(np.std(q[near, 1]))
    r, c = np.divmod(distinct, cells.wall.shape[1])
    return Layer(0.0 if is_wall else height, spread / np.sqrt(len(distinct)), area, _ring(r, c, cells))


def _ring(row: Int, column: Int, cells: CellMap) -> Float:
    """Convex ring of cells: a layer (all frames of a front) is rarely one piece."""
    h = cells.wall.shape[0]
    first, last = np.full(h, np.iinfo(np.int64).max), np.full(h, -1)
    np.minimum.at(first, row, column)
    np.maximum.at(last, row, column)
    used = np.flatnonzero(last >= 0)
    ends = np.concatenate(
        [np.column_stack([c, used + up]) for c in (first[used], last[used] + 1) for up in (0, 1)]
    )
    return convex_ring(ends * cells.cell + np.asarray(cells.corner))
