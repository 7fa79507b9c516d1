"""Standard errors that believe nothing about independence within a cluster of observations.

Errors of neighbouring observations are alike: templates overlap, a key point is displaced in all photos by
the same shadow, a piece of wall is rough. The inverse of the normal equations takes them for independent, and
is too optimistic by the square root of the number of observations that err together. Here the observations of
points that lie close together form a cluster c with its gradient ``g_c`` and its part ``S_c`` of the reduced
normal equations; leaving it out moves the unknowns by ``(S - S_c)^-1 g_c``. The covariance is the sum of the
outer products of these moves (the cluster jackknife; Bell and McCaffrey 2002 call it CR3). It needs neither a
model nor the size of the correlation, only clusters that are wider than it reaches.

What whole walls have in common no residual can show. It is added: control points of a scan share a small
displacement that varies over `reach` metres, a Gaussian random field, which is propagated to the unknowns.
"""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Float, Int, freeze
from frontage.orientation.adjustment.covariance import Precision
from frontage.orientation.adjustment.layout import Layout
from frontage.orientation.adjustment.linearise import Linearised
from frontage.orientation.adjustment.normal import NormalEquations, inverse_blocks

_SILENT = 1e-12  # variance from clusters over that of the normal equations: rounding, not information


@dataclass(frozen=True, eq=False)
class Dependence:
    """Which errors are alike.

    cluster       (n,) int64, the cluster of every point of the network: its observations err together
    displacement  (n,) m, standard error of what neighbouring control points share; 0 = not control
    reach         m, over which that displacement changes
    """

    cluster: Int
    displacement: Float
    reach: float

    def __post_init__(self) -> None:
        n = len(self.cluster)
        freeze(self, cluster=((n,), np.int64), displacement=((n,), np.float64))


def clustered_precision(
    equations: NormalEquations, precision: Precision, xyz: Float, dependence: Dependence
) -> Precision:
    """Returns the precision with covariances that hold for dependent errors; `xyz` (n, 3) m are all points.

    Redundancies stay: they tell how observations control one another, not how they err. No unknown becomes
    more certain than the inverse of the normal equations says.
    """
    Q = precision.wide
    number = np.unique(dependence.cluster[equations.layout.points], return_inverse=True)[1]
    wide = _not_below(clustered_covariance(equations, Q, number), Q)
    wide = wide + _shared_covariance(equations, Q, number, xyz, dependence)
    inverse = inverse_blocks(equations.V)
    points = np.empty_like(equations.V)
    for chunk, W in equations.between():
        Z = inverse[chunk.points] @ W
        inner = wide[np.ix_(chunk.columns, chunk.columns)]
        across = (Z.reshape(3 * chunk.size, len(chunk.columns)) @ inner).reshape(Z.shape)
        points[chunk.points] = inverse[chunk.points] + across @ Z.transpose(0, 2, 1)
    return replace(precision, wide=wide, points=points)


def _shared_covariance(
    equations: NormalEquations, Q: Float, number: Int, xyz: Float, dependence: Dependence
) -> Float:
    """The covariance (u, u) that follows from displacements which neighbouring control points share."""
    layout, rows = equations.layout, equations.rows
    count = int(number.max(initial=-1)) + 1
    weight = np.bincount(number, minlength=count)[:, None]
    middle = np.column_stack([np.bincount(number, c, count) for c in xyz[layout.points].T]) / weight
    square = np.square(middle[:, None] - middle).sum(-1)
    alike = np.exp(-0.5 * square / dependence.reach**2)
    shift = dependence.displacement[layout.points][layout.slot]
    total = np.zeros_like(Q)
    for axis in range(3):
        # the image of a control point moves by its derivative; the unknowns answer like to a residual
        answer = replace(rows, miss=rows.point[:, :, axis] * shift[:, None])
        moves = cluster_gradients(layout, answer, number) @ Q
        total += moves.T @ alike @ moves
    return total


def _not_below(covariance: Float, least: Float) -> Float:
    """Widens a covariance (u, u), parameter by parameter, to at least the variances of another.

    Parameters that no cluster tells anything of, such as the mount of a camera that sees nothing, have what
    the other covariance says of them.
    """
    variance, lowest = np.diag(covariance), np.diag(least)
    silent = variance <= _SILENT * lowest
    scale = np.where(silent, 0.0, np.sqrt(np.maximum(lowest / np.where(silent, 1.0, variance), 1.0)))
    widened = covariance * scale[:, None] * scale
    widened[np.ix_(silent, silent)] = least[np.ix_(silent, silent)]
    return np.asarray(widened)


def clustered_covariance(equations: NormalEquations, wide: Float, number: Int) -> Float:
    """Returns the covariance (u, u) of bodies and camera parameters from clusters of points.

    wide    (u, u) the inverse of the reduced normal equations
    number  (a,) int64, the cluster of every active point, numbered from 0 without gaps
    """
    layout, rows = equations.layout, equations.rows
    inverse = inverse_blocks(equations.V)
    gradients = cluster_gradients(layout, rows, number)
    order = np.argsort(number, kind="stable")
    ends = np.cumsum(np.bincount(number))
    moves = np.empty_like(gradients)
    own_rows = _rows_by_cluster(layout, number, len(ends))
    identity = np.eye(layout.columns)
    for c, slots in enumerate(np.split(order, ends[:-1])):
        part = _normal_part(equations, inverse, slots, own_rows[c])
        # (S - S_c)^-1 g = Q (I - S_c Q)^-1 g, with Q the inverse of S
        moves[c] = wide @ np.linalg.lstsq(identity - part @ wide, gradients[c], rcond=None)[0]
    covariance = moves.T @ moves
    return np.asarray(0.5 * (covariance + covariance.T))


def cluster_gradients(layout: Layout, rows: Linearised, number: Int) -> Float:
    """The gradients (c, u) of the clusters; those of the points themselves cancel at the minimum.

    number  (a,) int64, the cluster of every active point
    """
    count, width = int(number.max(initial=-1)) + 1, layout.columns + 1
    pulled = np.einsum("mik,mi->mk", rows.wide, rows.miss)
    address = number[layout.slot][:, None] * width + layout.photo_columns[layout.photo]
    table = np.bincount(address.ravel(), pulled.ravel(), count * width)
    return np.ascontiguousarray(table.reshape(count, width)[:, :-1])


def _rows_by_cluster(layout: Layout, number: Int, count: int) -> list[Int]:
    own = number[layout.slot]
    order = np.argsort(own, kind="stable")
    return np.split(order, np.cumsum(np.bincount(own, minlength=count))[:-1])


def _normal_part(equations: NormalEquations, inverse: Float, slots: Int, rows: Int) -> Float:
    """What a cluster adds to the reduced normal equations (u, u)."""
    layout, own = equations.layout, equations.rows
    u = layout.columns
    part = np.zeros((u + 1, u + 1))
    photo = layout.photo[rows]
    for number in np.unique(photo):
        columns = layout.photo_columns[number]
        wide = own.wide[rows[photo == number]].reshape(-1, layout.width)
        part[np.ix_(columns, columns)] += wide.T @ wide
    W = equations.coupling(slots)
    eliminated = np.einsum("gau,gab,gbv->uv", W, inverse[slots], W, optimize=True)
    return np.asarray(part[:u, :u] - eliminated)
