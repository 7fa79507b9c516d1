"""The observations of a group, collected in cells: those of one photo at one place of the object.

Within a cell errors are taken for alike. The errors of its rows, in sigmas, are a displacement ``f`` in space
as the rows see it (``U f``, with U the unit directions of their derivatives), and what each row has alone.
Of every cell, means over its n rows are kept:

    error     y = mean U^T v   of the residuals v, (3,)
    response  D = mean U^T (I - P V^-1 P^T) U   how an error shows when the photos stay, (3, 3)
    pull      A = mean U^T J   what n A^T f adds to the gradient of the unknowns, (3, u)

with P and V of the object points and ``J`` the derivatives of the rows after elimination of the points. The
residuals of errors f are then ``D f - A Q sum(n A^T f)``, with Q the inverse of the reduced equations.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.orientation.adjustment.layout import Chunk
from frontage.orientation.adjustment.normal import NormalEquations, inverse_blocks


@dataclass(frozen=True, eq=False)
class Cells:
    """Means over the cells of a group; see above.

    cell      (m,) int64, the cell of every row
    count     (c,) rows of a cell
    middle    (c, 3) m; photo (c,) int64, -1 where no photo saw it
    error     (c, 3), response (c, 3, 3), pull (c, 3, u)
    alone     (u, u) covariance of the gradient from independent errors of given variances
    """

    cell: Int
    count: Float
    middle: Float
    photo: Int
    error: Float
    response: Float
    pull: Float
    alone: Float

    @property
    def extent(self) -> float:
        """The diagonal of the box around all cells, m."""
        return float(np.linalg.norm(np.ptp(self.middle, axis=0)))

    def take(self, cells: Int) -> "Cells":
        """Some of the cells; `cell` and `alone` remain those of all."""
        fields = ("count", "middle", "photo", "error", "response", "pull")
        kept: dict[str, Any] = {f: getattr(self, f)[cells] for f in fields}
        return replace(self, **kept)


@dataclass(frozen=True, eq=False)
class Member:
    """The rows of a group: positions (m,) among the active rows of images or of surfaces."""

    rows: Int
    surfaces: bool


def collected(
    equations: NormalEquations, group: Member, xyz: Float, size: float, variance: Float | None = None
) -> Cells:
    """Collects the rows of a group in cubes of `size` m.

    xyz       (n, 3) m, all points: what decides on the cells
    variance  (m,) of the independent errors of the rows, in squared sigmas; None: 1
    """
    layout, own, rows = equations.layout, equations.rows, group.rows
    if group.surfaces:
        point, error = own.surface[rows][:, None], -own.surface_miss[rows][:, None]
        slot, photo = layout.surface_slot[rows], np.full(len(rows), -1)
    else:
        point, error = own.point[rows], -own.miss[rows]
        slot, photo = layout.slot[rows], layout.photo[rows]
    share = np.ones(len(rows)) if variance is None else variance
    axes = point.shape[1]
    unit = point * np.sqrt(axes) / np.linalg.norm(point, axis=(1, 2), keepdims=True)
    places = xyz[equations.layout.points[slot]]
    key = np.column_stack([photo, np.floor(places / size).astype(np.int64)])
    _, first, cell = np.unique(key, axis=0, return_index=True, return_inverse=True)
    cell = np.asarray(cell.ravel(), np.int64)
    count = np.bincount(cell).astype(np.float64)
    inverse = inverse_blocks(equations.V)
    shown = np.eye(axes) - point @ inverse[slot] @ point.transpose(0, 2, 1)
    turned = unit.transpose(0, 2, 1)
    mean = _Mean(cell, count)
    pull = np.zeros((len(count), 3, equations.layout.columns))
    alone = np.zeros((equations.layout.columns,) * 2)
    for mine, columns, along in reduced_rows(equations, inverse, point, slot, group):
        np.add.at(pull, (cell[mine][:, None, None], np.arange(3)[:, None], columns), turned[mine] @ along)
        flat = along.reshape(-1, len(columns))
        weighted = (along * share[mine, None, None]).reshape(flat.shape)
        alone[np.ix_(columns, columns)] += flat.T @ weighted
    return Cells(
        cell,
        count,
        mean(places),
        photo[first],
        mean((turned @ error[:, :, None])[..., 0]),
        mean(turned @ shown @ unit),
        pull / count[:, None, None],
        alone,
    )


@dataclass(frozen=True, eq=False)
class _Mean:
    """Means of values (m, ...) of rows over their cells."""

    cell: Int
    count: Float

    def __call__(self, values: Array) -> Float:
        flat = values.reshape(len(values), -1)
        sums = [np.bincount(self.cell, column, len(self.count)) for column in flat.T]
        return np.asarray((np.stack(sums, 1) / self.count[:, None]).reshape(-1, *values.shape[1:]))


def reduced_rows(
    equations: NormalEquations, inverse: Float, point: Float, slot: Int, group: Member
) -> Iterator[tuple[Int, Int, Float]]:
    """Yields per chunk which rows, the columns (c,), and the rows' reduced derivatives (r, a, c) by them.

    point  (m, a, 3) derivatives of the group's rows by their points, in the slots `slot` (m,)
    """
    for chunk, W in equations.between():
        mine = np.flatnonzero(_inside(slot, chunk))
        if not len(mine):
            continue
        coupled = inverse[chunk.points] @ W
        along = -point[mine] @ coupled[slot[mine] - chunk.points.start]
        if not group.surfaces:
            padded = np.concatenate([along, np.zeros((*along.shape[:2], 1))], axis=2)
            local = chunk.local[group.rows[mine] - chunk.rows.start]
            address = (
                np.arange(len(mine))[:, None, None],
                np.arange(along.shape[1])[:, None],
                local[:, None],
            )
            np.add.at(padded, address, equations.rows.wide[group.rows[mine]])
            along = padded[:, :, :-1]
        yield mine, chunk.columns, along


def _inside(slot: Int, chunk: Chunk) -> Bool:
    return np.asarray((slot >= chunk.points.start) & (slot < chunk.points.stop))
