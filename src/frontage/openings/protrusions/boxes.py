"""The points within, along and all over boxes on a facade."""

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int, distinct
from frontage.openings.boxes import Box


def within(p: Float, box: Box, margin: float) -> Bool:
    """Returns which points (n, 3) or places (n, 2) m lie within a box, `margin` m wider on all sides.

    Points lie within it at any depth.
    """
    x, z = p[:, 0], p[:, -1]
    return np.asarray(
        (x >= box[0] - margin) & (x <= box[2] + margin) & (z >= box[1] - margin) & (z <= box[3] + margin)
    )


def first_corner(p: Float, step: float) -> Float:
    """Returns the corner (d,) m of the first cell of `step` m over points (n, d) m.

    Cells lie alike on both sides of the middle of the first axis, so that a mirrored cloud has the same ones.
    """
    low, high = p.min(0), p.max(0)
    cells = np.ceil((high[0] - low[0]) / (2.0 * step))
    return np.array([(low[0] + high[0]) / 2.0 - cells * step, *low[1:]])


def cells_of(p: Float, step: float) -> Int:
    """Returns the cells (n, d) of `step` m, from 0 on, that points (n, d) m lie in (see `first_corner`)."""
    return np.floor((p - first_corner(p, step)) / step).astype(np.int64)


def occupied(values: Array, step: float) -> int:
    """Counts the steps of `step` m that hold a value (n,) m."""
    return len(distinct(np.floor(values / step).astype(np.int64)))


def held_cells(p: Float, cell: float) -> tuple[Int, Bool]:
    """Returns the columns and rows (2, n) of the cells of `cell` m that points (n, 3) m lie in.

    The map (columns, rows) tells which cells hold any.
    """
    across = cells_of(p[:, [0, 2]], cell).T
    held = np.zeros([int(a.max()) + 1 for a in across], np.bool_)
    held[across[0], across[1]] = True
    return across, held


def extent(p: Float, cell: float, tail: float) -> Box:
    """Returns the box of points (n, 3) m without thin tails.

    Tails are lines of cells of `cell` m that hold less than a share `tail` of the fullest.
    """
    across, held = held_cells(p, cell)
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
    # columns lie alike on both sides of the middle
    start = (box[0] + box[2] - size[0] * cell) / 2.0, box[1]
    across = [np.clip((p[:, 2 * k] - start[k]) / cell, 0, size[k] - 1).astype(np.int64) for k in (0, 1)]
    held[across[0], across[1]] = True
    return float(held.sum() * cell**2 / max((box[2] - box[0]) * (box[3] - box[1]), cell**2))
