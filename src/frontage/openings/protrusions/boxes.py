"""The points within, along and all over boxes on a facade."""

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, distinct
from frontage.openings.boxes import Box


def within(p: Float, box: Box, margin: float) -> Bool:
    """Returns which points (n, 3) or places (n, 2) m lie within a box, `margin` m wider on all sides.

    Points lie within it at any depth.
    """
    x, z = p[:, 0], p[:, -1]
    return np.asarray(
        (x >= box[0] - margin) & (x <= box[2] + margin) & (z >= box[1] - margin) & (z <= box[3] + margin)
    )


def occupied(values: Array, step: float) -> int:
    """Counts the steps of `step` m that hold a value (n,) m."""
    return len(distinct((values / step).astype(np.int64)))


def extent(p: Float, cell: float, tail: float) -> Box:
    """Returns the box of points (n, 3) m without thin tails.

    Tails are lines of cells of `cell` m that hold less than a share `tail` of the fullest.
    """
    across = [((p[:, k] - p[:, k].min()) / cell).astype(np.int64) for k in (0, 2)]
    held = np.zeros([int(a.max()) + 1 for a in across], np.bool_)
    held[across[0], across[1]] = True
    ends = []
    for axis in (0, 1):
        line = held.sum(1 - axis)
        full = np.flatnonzero(line >= tail * line.max())
        kept = p[(across[axis] >= full[0]) & (across[axis] <= full[-1]), 2 * axis]
        ends.append((float(kept.min()), float(kept.max())))
    return ends[0][0], ends[1][0], ends[0][1], ends[1][1]


def shown_sides(p: Float, box: Box, cell: float) -> list[float]:
    """Returns the shares of the left, lower, right and upper side within `cell` m of which points show."""
    shares = []
    for side in range(4):
        axis, along = (0, 2) if side % 2 == 0 else (2, 0)
        near = np.abs(p[:, axis] - box[side]) <= cell
        length = max(box[3 - side % 2] - box[1 - side % 2], cell)
        shares.append(min(occupied(p[near, along], cell) * cell / length, 1.0))
    return shares


def filled(p: Float, box: Box, cell: float) -> float:
    """Returns the share of a box's cells that hold points (n, 3) m."""
    size = [int((box[k + 2] - box[k]) / cell) + 1 for k in (0, 1)]
    held = np.zeros(size, np.bool_)
    across = [np.clip((p[:, 2 * k] - box[k]) / cell, 0, size[k] - 1).astype(np.int64) for k in (0, 1)]
    held[across[0], across[1]] = True
    return float(held.sum() * cell**2 / max((box[2] - box[0]) * (box[3] - box[1]), cell**2))
