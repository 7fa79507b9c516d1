"""Errors of a scan across its surface, which its control points and the surfaces of tie points share.

A scan that shows a wall some millimetres before or behind its place, over a metre or two, displaces the
control points there and the surfaces that tie points lie on. Both groups then err together. A control point
that is displaced along its normal moves in a photo by the tangent of the angle at which it is seen: to one
side in a photo from the left, to the other in a photo from the right. Residuals in two photos therefore do
not show that it is one error; the surfaces show it directly.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Float, Int
from frontage.orientation.adjustment.cells import Member, reduced_rows
from frontage.orientation.adjustment.dependence import Variogram, alike_gradient
from frontage.orientation.adjustment.normal import NormalEquations, inverse_blocks


@dataclass(frozen=True, eq=False)
class _Rows:
    """Rows of a group: derivatives (m, a, 3) by their points, slots (m,), places and normals (m, 3)."""

    member: Member
    point: Float
    slot: Int
    place: Float
    normal: Float


def relief_gradient(
    equations: NormalEquations,
    xyz: Float,
    surfaces: Member,
    control: Member,
    variogram: Variogram,
    variance: float,
) -> Float:
    """Returns the covariance (u, u) of the gradient from displacements of the scan along its normals.

    xyz        (n, 3) m, all points
    variogram  of the errors of the surfaces; `variance` m2, that of one of them
    """
    of_surfaces = _rows(equations, surfaces, xyz, None)
    both = (of_surfaces, _rows(equations, control, xyz, of_surfaces))
    places = np.concatenate([rows.place for rows in both])
    cubes = np.floor(places / variogram.reach).astype(np.int64)
    cell = np.unique(cubes, axis=0, return_inverse=True)[1].ravel()
    count = np.bincount(cell)
    middle = np.stack([np.bincount(cell, axis) / count for axis in places.T], axis=1)
    pull = np.zeros((len(count), 3, equations.layout.columns))
    first = 0
    for rows in both:
        _add_pull(pull, cell[first : first + len(rows.slot)], rows, equations)
        first += len(rows.slot)
    return variance * alike_gradient(pull, middle, None, variogram)


def _rows(equations: NormalEquations, member: Member, xyz: Float, known: _Rows | None) -> _Rows:
    """The rows of a group; those of images have the normals of the `known` surfaces nearest to them."""
    layout, rows = equations.layout, member.rows
    if known is None:
        point, slot = equations.rows.surface[rows][:, None], layout.surface_slot[rows]
        place = xyz[layout.points[slot]]
        normal = point[:, 0] / np.linalg.norm(point[:, 0], axis=1, keepdims=True)
        return _Rows(member, point, slot, place, normal)
    point, slot = equations.rows.point[rows], layout.slot[rows]
    place = xyz[layout.points[slot]]
    return _Rows(member, point, slot, place, known.normal[cKDTree(known.place).query(place)[1]])


def _add_pull(pull: Float, cell: Int, rows: _Rows, equations: NormalEquations) -> None:
    """Adds what a displacement of 1 m of every cell (c,) along the normals adds to the gradient (c, 3, u)."""
    # The surface of a tie point is displaced against the point, a control point against its image.
    sign = 1.0 if rows.member.surfaces else -1.0
    error = sign * np.einsum("rai,ri->ra", rows.point, rows.normal)
    inverse = inverse_blocks(equations.V)
    for mine, columns, along in reduced_rows(equations, inverse, rows.point, rows.slot, rows.member):
        moved = np.einsum("ra,rac->rc", error[mine], along)
        address = (cell[mine][:, None, None], np.arange(3)[:, None], columns)
        np.add.at(pull, address, rows.normal[mine][:, :, None] * moved[:, None])
