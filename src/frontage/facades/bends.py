"""Ends the outlines of walls at the flat corners where they meet other walls.

Where a front bends, the plane of each part goes on beyond the corner, near the next part or behind it, and
the windows of that part would be its own as well.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import ndimage

from frontage.facades.candidate import FacadeCandidate
from frontage.facades.cells import CellMap
from frontage.facades.options import FacadeOptions
from frontage.geometry.arrays import Bool, Float, Int
from frontage.model.masonry import MASONRY

_FLATTEST = np.cos(np.radians(2.5))  # cosine between walls that are one wall: flatter corners do not show
_FULL = 0.25  # share of the wall in its fullest column that a column of a wall shows: spandrels alone do
_BESIDE = 2.0  # cells on either side of a corner that do not tell whether a wall goes on
_CORNER = 3.0  # cells on either side of a corner in which the outlines of both walls may end

SHARPEST = np.cos(np.radians(40.0))
"""Cosine between walls that meet at the sharpest flat corner, which is blunter than those of an octagon."""

LEAST_M2 = FacadeOptions().min_area
"""m2 of wall that a facade has at least."""


def ended_at_corners(own: FacadeCandidate, others: Sequence[FacadeCandidate]) -> list[FacadeCandidate]:
    """Returns a wall, or its parts, with outlines that end at its flat corners with other walls.

    What is near its plane beyond such a corner belongs to the next face, unless the wall itself goes on there
    for the width of a pier. Where it begins again beyond another corner, as on both sides of a bow, it has
    several parts. At sharp corners pilasters may stand out from the other wall.
    """
    cells = own.cells
    corners = [(other, at) for other in others if (at := crossing(own, other)) is not None]
    if not corners:
        return [own]
    x = places(cells, np.arange(cells.whole.shape[1]))
    alone = _alone(own, [other for other, _ in corners]).sum(0) >= _FULL * cells.wall.sum(0).max(initial=1)
    ends = np.array(sorted(at for _, (at, _) in corners))
    alone &= np.abs(x[:, None] - ends).min(1) > _BESIDE * cells.cell
    goes_on = ndimage.binary_opening(alone, np.ones(round(MASONRY.pier / cells.cell), np.bool_))
    between = np.searchsorted(ends, x)
    kept = np.isin(between, np.unique(between[goes_on]))
    # outlines run through the middles of their border cells
    run, number = ndimage.label(ndimage.binary_dilation(kept) & cells.whole.any(0))
    parts = [_part(cells, run == k) for k in range(1, number + 1)]
    large = [part for part in parts if part.area >= LEAST_M2]
    large.sort(key=lambda part: -part.area)
    return [replace(own, cells=part) for part in large] or [own]


def crossing(own: FacadeCandidate, other: FacadeCandidate) -> tuple[float, float] | None:
    """Returns where two walls meet at a flat corner: x m along each of them. None if they meet at none."""
    if not SHARPEST < float(own.wall.normal @ other.wall.normal) < _FLATTEST:
        return None
    along = own.wall.axes[:, 0]
    x = float((other.wall.point - own.wall.point) @ other.wall.normal) / float(along @ other.wall.normal)
    there = float(other.wall.coordinates((own.wall.point + x * along)[None])[0, 0])
    held = full_columns(other.cells)
    if not len(held):
        return None
    low, high = places(other.cells, held[[0, -1]])
    return (x, there) if low - MASONRY.relief < there < high + MASONRY.relief else None


def share_a_corner(a: FacadeCandidate, b: FacadeCandidate) -> bool:
    """Returns whether two outlines share only what is next to the flat corner where their walls meet."""
    corner = crossing(a, b)
    if corner is None:
        return False
    x = places(a.cells, np.flatnonzero(shared_cells(a, b)[0].any(0)))
    return bool((np.abs(x - corner[0]) <= _CORNER * a.cells.cell).all())


def shared_cells(own: FacadeCandidate, other: FacadeCandidate) -> tuple[Bool, Int]:
    """Returns which cells (h, w) of an outline lie in another outline, and the numbers of its cells there."""
    cells = own.cells
    row, column = np.indices(cells.whole.shape) + 0.5
    x, z = (cells.corner[k] + cells.cell * v.ravel() for k, v in enumerate((column, row)))
    local = own.wall.point + np.column_stack([x, np.zeros(len(x)), z]) @ own.wall.axes.T
    q = other.wall.coordinates(local)
    r, c, inside = other.cells.locate(q[:, 0], q[:, 2])
    there = (r * other.cells.whole.shape[1] + c).reshape(cells.whole.shape)
    return cells.whole & inside.reshape(there.shape) & other.cells.whole.ravel()[there], there


def full_columns(cells: CellMap) -> Int:
    """Returns the numbers (k,) of neighbouring columns that show much wall.

    Of several such runs of columns, it is the one that shows the most wall.
    """
    held = cells.wall.sum(0)
    run, number = ndimage.label(held >= max(_FULL * held.max(initial=0), 1))
    if number == 0:
        return np.empty(0, np.int64)
    return np.flatnonzero(run == 1 + np.bincount(run, held)[1:].argmax())


def places(cells: CellMap, columns: Int) -> Float:
    """Returns where (k,) m the middles of columns lie."""
    return np.asarray(cells.corner[0] + cells.cell * (columns + 0.5), np.float64)


def _alone(own: FacadeCandidate, others: Sequence[FacadeCandidate]) -> Bool:
    """Returns the cells (h, w) of a wall that lie on none of the other walls."""
    cells, alone = own.cells, own.cells.wall.copy()
    rows, columns = np.nonzero(alone)
    x, z = (cells.corner[k] + cells.cell * (v + 0.5) for k, v in enumerate((columns, rows)))
    middles = own.wall.point + np.column_stack([x, np.zeros(len(x)), z]) @ own.wall.axes.T
    for other in others:
        q, slope = other.wall.coordinates(middles), abs(float(own.wall.axes[:, 0] @ other.wall.normal))
        near = np.abs(q[:, 1]) < own.wall.threshold + other.wall.threshold + cells.cell * slope
        alone[rows, columns] &= ~(near & other.cells.within(q[:, 0], q[:, 2]))
    return alone


def _part(cells: CellMap, columns: Bool) -> CellMap:
    """Returns the map of one connected part of an outline: the one in `columns` (w,) with the most wall."""
    label, number = ndimage.label(cells.whole & columns)
    if number == 0:
        return cells.with_outline(np.zeros_like(cells.whole))
    wall = np.bincount(label[cells.wall], minlength=number + 1)
    return cells.with_outline(label == 1 + int(wall[1:].argmax()))
