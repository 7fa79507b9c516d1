"""Weights and covariances for errors that are alike at neighbouring places.

The inverse of the normal equations treats all observations as independent. Where errors are alike it is too
optimistic, by the square root of the number of observations that err together, and groups with many such
observations weigh too much against others. Both follow from the variograms of the groups (`variogram`):

- the variance of an observation is multiplied by its design effect, the sum of its correlations with all
  others of its group (Kish 1965), so that a cell that is full of observations weighs as what it is: one
  measurement;
- with these weights the unknowns are ``Q g``, and their covariance is ``Q cov(g) Q``, where the gradient
  ``g`` has the covariance that the variograms tell.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.orientation.adjustment.cells import Cells, Member, collected
from frontage.orientation.adjustment.covariance import Precision
from frontage.orientation.adjustment.dependence import (
    RANGES,
    Dependence,
    Variogram,
    alike_chunks,
    alike_gradient,
)
from frontage.orientation.adjustment.fit import Fit
from frontage.orientation.adjustment.linearise import Weights
from frontage.orientation.adjustment.network import Network
from frontage.orientation.adjustment.normal import NormalEquations, inverse_blocks
from frontage.orientation.adjustment.relief import relief_gradient
from frontage.orientation.adjustment.variogram import estimated_variogram

_FEWEST = 30  # rows of a group, below which nothing can be told of them


@dataclass(frozen=True, eq=False)
class Alike:
    """A group of observations and which of its errors are alike.

    member   its rows, with design effects `effect` (m,)
    weight   1/m2, mean square of the derivatives of its rows by the place of their points
    """

    group: int
    member: Member
    variogram: Variogram
    effect: Float
    weight: float


def alike_groups(network: Network, fit: Fit, dependence: Dependence) -> tuple[Alike, ...]:
    """Estimates for every group of a fit how its errors are alike."""
    layout, xyz = fit.layout, fit.minimum.state.points
    found = []
    for group, reach in sorted(dependence.reach.items()):
        images = np.flatnonzero(network.images.group[layout.rows] == group)
        surfaces = np.flatnonzero(network.surfaces.group[layout.surface_rows] == group)
        member = Member(surfaces if len(surfaces) else images, bool(len(surfaces)))
        if len(member.rows) < _FEWEST:
            continue
        cells = collected(fit.equations, member, xyz, reach)
        own, shared = group in dependence.own, group in dependence.shared
        pair = estimated_variogram(cells, fit.precision.wide, reach, own=own, shared=shared)
        weight = _weight_per_metre(fit.equations, member)
        likeliest, fading = (_with_stated(v, dependence, group, weight) for v in pair)
        # The choice hardly matters for weights, and poses must not depend on whether shares fade.
        effect = design_effects(cells, likeliest)[cells.cell]
        variogram = fading if group in dependence.fading else likeliest
        found.append(Alike(group, member, variogram, effect, weight))
    return tuple(found)


def _with_stated(variogram: Variogram, dependence: Dependence, group: int, weight: float) -> Variogram:
    """A variogram with what is stated because no residual shows it; `weight` 1/m2 as in `Alike`."""
    far = dependence.far.get(group, 0.0) * float(variogram.shared.sum())
    least = dependence.least.get(group, 0.0) ** 2 * weight
    return replace(variogram, far=far).at_least(least)


def _weight_per_metre(equations: NormalEquations, member: Member) -> float:
    """The mean squared length of the derivatives of a group's rows by the place of their point, 1/m^2."""
    point = equations.rows.surface[:, None] if member.surfaces else equations.rows.point
    lengths = np.square(point[member.rows]).sum(axis=(1, 2))
    return float(np.mean(lengths)) / float(point.shape[1])


def design_effects(cells: Cells, variogram: Variogram) -> Float:
    """By how much the variance of an observation grows in every cell (c,) for those that err alike."""
    # What is alike over all of the object does not tell places apart, and is no reason to trust one less.
    within = np.array(RANGES) * variogram.reach < cells.extent
    seen = replace(variogram, far=0.0, shared=variogram.shared * within)
    total = [k @ cells.count for _, k in alike_chunks(cells.middle, cells.photo, seen)]
    return np.asarray(np.maximum(np.concatenate(total) + seen.alone, 1.0))


def effective_weights(fit: Fit, groups: Sequence[Alike]) -> Weights:
    """The weights of a fit, divided by the design effects."""
    images, surfaces = fit.minimum.weights.images.copy(), fit.minimum.weights.surfaces.copy()
    for one in groups:
        if one.member.surfaces:
            surfaces[fit.layout.surface_rows[one.member.rows]] /= np.sqrt(one.effect)
        else:
            images[fit.layout.rows[one.member.rows]] /= np.sqrt(one.effect)
    return Weights(images, surfaces)


def dependent_precision(
    equations: NormalEquations,
    precision: Precision,
    xyz: Float,
    groups: Sequence[Alike],
    relief: tuple[int, int] | None = None,
) -> Precision:
    """Returns the precision with covariances that hold for errors that are alike.

    `equations` and `precision` have effective weights; `xyz` (n, 3) m are the points that told the groups.
    The groups of `relief` have the errors of a scan across its surface in common (`Dependence`).
    Redundancies stay: they tell how observations control one another, not how they err.
    """
    Q = precision.wide
    gradient = np.zeros_like(Q)
    pair = [one for group in relief or () for one in groups if one.group == group]
    if len(pair) == 2:
        surfaces, control = pair
        variance = 1.0 / surfaces.weight
        members = (surfaces.member, control.member)
        gradient += relief_gradient(equations, xyz, *members, surfaces.variogram, variance)
    for one in groups:
        # an error of one sigma alone is 1 / effect in the weights; the inverse Q has taken it for 1
        alone = one.variogram.alone / one.effect - 1.0
        cells = collected(equations, one.member, xyz, one.variogram.reach, alone)
        root = np.ones(len(cells.count))
        root[cells.cell] = 1.0 / np.sqrt(one.effect)
        gradient += cells.alone
        if len(pair) < 2 or one is not pair[0]:
            pull = (cells.count * root)[:, None, None] * cells.pull
            gradient += alike_gradient(pull, cells.middle, cells.photo, one.variogram)
    wide = Q + Q @ gradient @ Q
    return replace(precision, wide=wide, points=_points(equations, wide))


def _points(equations: NormalEquations, wide: Float) -> Float:
    """Marginal covariances (a, 3, 3) of the points from that of bodies and cameras."""
    inverse = inverse_blocks(equations.V)
    points = np.empty_like(equations.V)
    for chunk, W in equations.between():
        Z = inverse[chunk.points] @ W
        inner = wide[np.ix_(chunk.columns, chunk.columns)]
        across = (Z.reshape(3 * chunk.size, len(chunk.columns)) @ inner).reshape(Z.shape)
        points[chunk.points] = inverse[chunk.points] + across @ Z.transpose(0, 2, 1)
    return points
