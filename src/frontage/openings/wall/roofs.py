"""Finds the flat roof behind the top of a wall, which was scanned from above and not through the wall."""

import numpy as np

from frontage.geometry.arrays import Float

_PARAPET = 1.5  # m that a wall rises over its flat roof at most
_BEGIN, _LAYER = 0.4, 0.1  # m behind the wall where roofs begin to show, and thickness of layers and levels
_LAYERS, _FILLED = 6, 4  # layers behind the wall, and how many of them a level surface fills at least
_COLUMN = 0.5  # m, width of the columns that are asked
_MOST = 0.5  # share of the columns in which the roof shows


def roof_level(points: Float, depth: Float, top: float) -> float:
    """Returns the height z m of the flat roof behind a wall, infinity where there is none.

    points  (n, 3) m, in the facade frame
    depth   (n,) m of the points behind the wall
    top     m, height of the end of the wall

    A roof is level from some way behind the wall on, no more than a parapet below its top, and runs along
    most of it. What shows on and above it, such as the back of the parapet, was seen from the roof.
    """
    layer = np.floor((depth - _BEGIN) / _LAYER)
    level = np.floor((points[:, 2] - top + _PARAPET) / _LAYER)
    near = (layer >= 0) & (layer < _LAYERS) & (level >= 0) & (level * _LAYER < _PARAPET)
    if not near.any():
        return np.inf
    column = np.floor(points[:, 0] / _COLUMN)
    column -= column.min()
    shape = int(column.max()) + 1, round(_PARAPET / _LAYER) + 1, _LAYERS
    shown = np.zeros(shape, np.bool_)
    shown[tuple(v[near].astype(np.int64) for v in (column, level, layer))] = True
    found = np.flatnonzero((shown.sum(2) >= _FILLED).mean(0) >= _MOST)
    return float(top - _PARAPET + _LAYER * (found[0] - 1)) if len(found) else np.inf
