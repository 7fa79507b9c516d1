"""Rectangles in which several windows of a sparse row are joined are parted at the piers of other rows.

Where a wall is scanned sparsely, a pier between two windows returns few beams. They weigh less than the price
of another opening, so that both windows come out as one. Windows stand above one another, and the rows above
and below tell where the piers are. A rectangle is parted if these rows outweigh the beams at the piers:

    log of (rows with these piers + 1/2) / (rows with an opening across one of them + 1/2)  >  nats for open
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.openings.boxes import Box
from frontage.openings.layout.densities import Place, row_by_row
from frontage.openings.layout.selection import worth_of


def divided_by_columns(places: Sequence[Place]) -> list[Place]:
    """Returns the places row by row, parted where they cover several columns of other rows."""
    boxes = np.array([p.box for p in places]).reshape(-1, 4)
    parted = [_parts(place, boxes) or [place] for place in places]
    return row_by_row([p for parts in parted for p in parts])


def _parts(place: Place, boxes: Float) -> list[Place]:
    """Returns the places that a place consists of, none if it is one; `boxes` (n, 4) m are all boxes."""
    near = place.slack
    x0, z0, x1, z1 = place.box
    others = boxes[(boxes[:, 3] <= z0 + near) | (boxes[:, 1] >= z1 - near)]
    rows = _rows_of_columns(others, x0, x1, near)
    agreeing = [[row for row in rows if _are_alike(row, other, near)] for other in rows]
    best = max(agreeing, key=len, default=[])
    if not best:
        return []
    columns = np.median(best, axis=0)
    piers = [(left[1], z0, right[0], z1) for left, right in pairwise(columns.tolist())]
    across = sum(bool(_crosses(others, pier, near).any()) for pier in piers)
    nats = sum(float(worth_of(place.evidence, _inner(place, pier)).sum()) for pier in piers)
    if np.log((len(best) + 0.5) / (across + 0.5)) <= nats:
        return []
    ends = [x0, *columns.ravel()[1:-1].tolist(), x1]
    return [Place.of((a, z0, b, z1), place.evidence) for a, b in zip(ends[::2], ends[1::2], strict=True)]


def _rows_of_columns(boxes: Float, x0: float, x1: float, near: float) -> list[Float]:
    """Returns the left and right borders (k, 2) m of the boxes of every row that reach from `x0` to `x1`.

    A row has at least two of them, and the borders of the first and the last are at most `near` m off.
    """
    inside = boxes[(boxes[:, 0] >= x0 - near) & (boxes[:, 2] <= x1 + near)]
    middle = inside[:, [1, 3]].mean(1)
    found = dict[tuple[float, ...], Float]()
    for height in middle:
        row = inside[(inside[:, 1] < height) & (inside[:, 3] > height)]
        row = row[np.argsort(row[:, 0])][:, [0, 2]]
        apart = bool((row[1:, 0] > row[:-1, 1]).all())
        if len(row) > 1 and apart and row[0, 0] <= x0 + near and row[-1, 1] >= x1 - near:
            found[tuple(row.ravel().tolist())] = row
    return list(found.values())


def _are_alike(row: Float, other: Float, near: float) -> bool:
    """Returns whether two rows (k, 2) m have the same columns, at most `near` m off."""
    return len(row) == len(other) and bool(np.abs(row - other).max() <= near)


def _crosses(boxes: Float, pier: Box, near: float) -> Bool:
    """Returns which boxes (n, 4) m go across a pier."""
    return np.asarray((boxes[:, 0] < pier[0] - near) & (boxes[:, 2] > pier[2] + near))


def _inner(place: Place, pier: Box) -> tuple[slice, slice]:
    """Returns the cells of a pier but for those at its sides, which the openings beside it share."""
    cell = place.evidence.raster.cell
    x0, z0, x1, z1 = pier
    side = min(cell / 2.0, (x1 - x0) / 4.0)
    return place.evidence.raster.cells((x0 + side, z0, x1 - side, z1))
