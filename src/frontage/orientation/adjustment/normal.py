"""The normal equations, reduced to bodies, cameras and mounts by the Schur complement of the points.

With U of bodies, cameras and mounts, V of the points (3 x 3 blocks) and W between them, the reduced equations
are ``S = U - W^T V^-1 W``. They are summed over chunks of points, each dense in the few columns that it
touches, so that the work is done by matrix products.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.orientation.adjustment.layout import Chunk, Layout
from frontage.orientation.adjustment.linearise import Linearised


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """U (u, u), V (a, 3, 3), and the gradients (u,) and (a, 3)."""

    layout: Layout
    rows: Linearised
    U: Float
    V: Float
    wide_gradient: Float
    point_gradient: Float

    def between(self) -> Iterator[tuple[Chunk, Float]]:
        """The blocks W (g, 3, c) between the points and the columns of every chunk."""
        for chunk in self.layout.chunks:
            products = _outer(self.rows.point[chunk.rows], self.rows.wide[chunk.rows])
            width = len(chunk.columns) + 1
            table = np.bincount(chunk.address.ravel(), products.ravel(), chunk.size * 3 * width)
            yield chunk, np.ascontiguousarray(table.reshape(chunk.size, 3, width)[:, :, :-1])

    def coupling(self, slots: Int) -> Float:
        """The blocks W (g, 3, u) of some active points, given by their distinct numbers (g,)."""
        place = np.full(len(self.layout.points), -1)
        place[slots] = np.arange(len(slots))
        mine = np.flatnonzero(place[self.layout.slot] >= 0)
        width = self.layout.columns + 1
        corner = place[self.layout.slot[mine], None] * 3 + np.arange(3)
        wide = self.layout.photo_columns[self.layout.photo[mine]]
        address = corner[:, :, None] * width + wide[:, None, :]
        products = _outer(self.rows.point[mine], self.rows.wide[mine])
        table = np.bincount(address.ravel(), products.ravel(), len(slots) * 3 * width)
        return np.ascontiguousarray(table.reshape(len(slots), 3, width)[:, :, :-1])

    def reduce(self, inverse_points: Float, U: Float) -> tuple[Float, Float]:
        """Returns S (u, u) and its right-hand side (u,), with V^-1 (a, 3, 3) and a (damped) U."""
        S, right = U.copy(), -self.wide_gradient
        for chunk, W in self.between():
            flat = W.reshape(3 * chunk.size, len(chunk.columns))
            Z = (inverse_points[chunk.points] @ W).reshape(flat.shape)
            S[np.ix_(chunk.columns, chunk.columns)] -= flat.T @ Z
            right[chunk.columns] += Z.T @ self.point_gradient[chunk.points].ravel()
        return 0.5 * (S + S.T), right

    def back_substitute(self, inverse_points: Float, wide: Float) -> Float:
        """The corrections (a, 3) of the points that follow from those of the columns (u,)."""
        padded = np.append(wide, 0.0)[self.layout.photo_columns[self.layout.photo]]
        along = np.einsum("mik,mk->mi", self.rows.wide, padded)
        pulled = self.layout.by_point(np.einsum("mia,mi->ma", self.rows.point, along))
        return -np.asarray(np.einsum("aij,aj->ai", inverse_points, self.point_gradient + pulled), np.float64)


def normal_equations(layout: Layout, rows: Linearised) -> NormalEquations:
    """Sums the normal equations of linearised rows."""
    V = point_blocks(layout, rows.point, rows.surface)
    point_gradient = layout.by_point(np.einsum("mia,mi->ma", rows.point, rows.miss))
    point_gradient += layout.by_surface_point(rows.surface * rows.surface_miss[:, None])
    U, gradient = _wide_part(layout, rows)
    return NormalEquations(layout, rows, U, V, gradient, point_gradient)


def point_blocks(layout: Layout, rays: Float, surface: Float) -> Float:
    """The blocks V (a, 3, 3) from the derivatives (m_a, 2, 3) of image rows and (k_a, 3) of surface rows."""
    return layout.by_point(_outer(rays, rays)) + layout.by_surface_point(
        surface[:, :, None] * surface[:, None, :]
    )


def _wide_part(layout: Layout, rows: Linearised) -> tuple[Float, Float]:
    """U (u, u) and the gradient (u,), priors included."""
    u = layout.columns
    U, gradient = np.zeros((u + 1, u + 1)), np.zeros(u + 1)
    for columns, mine in zip(layout.photo_columns, layout.rows_of_photo, strict=True):
        own = rows.wide[mine].reshape(-1, layout.width)
        U[np.ix_(columns, columns)] += own.T @ own
        gradient[columns] += own.T @ rows.miss[mine].ravel()
    for body, prior in enumerate(rows.priors):
        if prior is not None:
            block = slice(6 * body, 6 * body + 6)
            U[block, block] += prior[0].T @ prior[0]
            gradient[block] += prior[0].T @ prior[1]
    cameras, mounts = np.arange(u)[layout.all_cameras], layout.all_mounts
    U[cameras, cameras] += rows.cameras**2
    gradient[cameras] += rows.cameras * rows.camera_miss
    U[mounts, mounts] += rows.mounts.T @ rows.mounts
    gradient[mounts] += rows.mounts.T @ rows.mount_miss
    return U[:u, :u], gradient[:u]


def inverse_blocks(V: Float, damping: float = 0.0) -> Float:
    """Inverts blocks (a, 3, 3), damped on their diagonals; a point without observations stays in place."""
    damped = V.copy()
    diagonal = np.einsum("aii->ai", damped)
    diagonal *= 1.0 + damping
    empty = diagonal.sum(axis=1) <= 0.0
    damped[empty] = np.eye(3)
    scale = 1.0 / np.sqrt(np.maximum(np.einsum("aii->ai", damped), 1e-300))
    scaled = damped * scale[:, :, None] * scale[:, None, :]
    np.einsum("aii->ai", scaled)[...] += 1e-14
    return np.asarray(np.linalg.inv(scaled) * scale[:, :, None] * scale[:, None, :], np.float64)


def _outer(a: Float, b: Float) -> Float:
    """``a^T b`` per row: (r, 2, i) and (r, 2, j) give (r, i, j)."""
    return np.asarray(a.transpose(0, 2, 1) @ b, np.float64)
