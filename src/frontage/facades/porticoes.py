"""Finds how deep a facade reaches behind its plane. It reaches deeper in porticoes and loggias."""

import numpy as np
from scipy import ndimage

from frontage.facades.cells import CellMap
from frontage.geometry.arrays import Bool, Float, Int, distinct
from frontage.model.masonry import MASONRY, TOLERANCES

_CORE_M = 0.75  # m, least width of what is open: joints and gaps between points are narrower
_LAYER_M = 0.1  # m, thickness of what counts as one surface: sills and surrounds of a wall lie about it
_SHOWN = 0.5  # share of the cells of the fullest surface that a wall shows in


def depth_behind(y: Float, flat: Int, cells: CellMap, limits: tuple[float, float]) -> Float:
    """Returns how deep (h, w) m the prism of a facade is behind its plane.

    y       (n,) m, offsets of points from the plane; flat (n,) their cells
    limits  m, the depth everywhere, and the largest one in porticoes

    The wall behind a portico is the deepest surface that shows there in half as many cells as the fullest
    one, which may be that of the columns. The frames of its windows lie within its relief.
    """
    least, most = limits[0], max(limits)
    recess = _porticoes(cells)
    there = recess.ravel()[flat] & (y > TOLERANCES.least_on_wall) & (y < most)
    levels = int(most / _LAYER_M) + 1
    level = (y[there] / _LAYER_M).astype(np.int64)
    shown = np.bincount(distinct(flat[there] * levels + level) % levels, minlength=levels)
    wall = (int(np.flatnonzero(shown >= _SHOWN * shown.max())[-1]) + 1) * _LAYER_M if there.any() else 0.0
    return np.where(recess, np.clip(wall + MASONRY.relief, least, most), least)


def _porticoes(cells: CellMap) -> Bool:
    """Returns the cells (h, w) of areas that show no wall and are too large for an opening.

    Gaps that are narrower than `_CORE_M`, such as those between the points of a sparse scan, join nothing.
    """
    core = max(round(_CORE_M / cells.cell), 1)
    square = np.ones((core, core), np.bool_)
    labels, _ = ndimage.label(ndimage.binary_opening(cells.whole & ~cells.wall, square))
    large = []
    for number, parts in enumerate(ndimage.find_objects(labels), 1):
        high, wide = (cells.cell * (part.stop - part.start) for part in parts)
        large += [number] if MASONRY.exceeds_opening(wide, high) else []
    return np.isin(labels, large)
