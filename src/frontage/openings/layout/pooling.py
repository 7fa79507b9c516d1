"""What openings share: rows, columns and sizes, pooled as far as their own errors allow.

Every family (widths and heights of like openings, middles of columns, sills or lintels of rows, depths of
like openings) is normally distributed about its mean. Its variance between members is what their scatter
exceeds their own errors by. So pooling shrinks errors where the facade is regular, and does not where it is
not; a member that contradicts its family is left out of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.estimate import Estimate, Provenance
from frontage.openings.borders.outline import Outline
from frontage.openings.layout.groups import (
    BOTTOM,
    HEIGHT,
    MIDDLE,
    MOST,
    TOP,
    UNKNOWN,
    WIDTH,
    between_members,
    borders_of,
    columns_of,
    common_of,
    like_groups,
    predicted,
    rows_of,
    values_of,
)

_ODD = 3.5  # sigmas from the others from which a member is left out
_ALIKE = 0.001  # m, one sigma of depths: what scanner, wall and joinery do to all frames alike
_MUCH = 0.5  # share of its own variance: a border that has less now owes most of what is known to others


@dataclass(frozen=True, eq=False)
class Family:
    """Groups of openings that share a quantity.

    share    (4,) weights of left, right, bottom, top whose sum is the quantity
    groups   numbers of the members
    between  m, one sigma between the members of a group
    """

    share: Float
    groups: tuple[tuple[int, ...], ...]
    between: float


def pool(outlines: Sequence[Outline]) -> list[Outline]:
    """Returns the outlines with borders and depths pooled.

    Those that owe most of what is known of a border to others say `pooled`. All borders and family means are
    solved for together, by least squares.
    """
    if len(outlines) < 3:
        return list(outlines)
    own, variance = values_of(outlines)
    families = find_families(outlines)
    size = 4 * len(outlines)
    total = size + sum(len(f.groups) for f in families)
    normal, right = np.zeros((total, total)), np.zeros(total)
    for k, covariance in enumerate(variance):
        weight = np.linalg.inv(covariance)
        normal[4 * k : 4 * k + 4, 4 * k : 4 * k + 4] = weight
        right[4 * k : 4 * k + 4] = weight @ own[k]
    mean = size
    for family in families:
        for group in family.groups:
            for k in group:
                at = np.r_[4 * k : 4 * k + 4, mean]
                row = np.append(family.share, -1.0) / family.between
                normal[np.ix_(at, at)] += np.outer(row, row)
            mean += 1
    spread: Float = np.linalg.inv(normal).astype(np.float64)
    found = (spread @ right)[:size].reshape(-1, 4)
    depths = _pooled_depths(outlines, families)
    blocks = [spread[4 * k : 4 * k + 4, 4 * k : 4 * k + 4] for k in range(len(outlines))]
    return [_with_borders(o, v, b, d) for o, v, b, d in zip(outlines, found, blocks, depths, strict=True)]


def find_families(outlines: Sequence[Outline]) -> list[Family]:
    """Returns the families of like openings: widths, heights, columns, and rows.

    Rows go by sills or by lintels, whichever agree better.
    """
    like = like_groups(outlines)
    columns = columns_of(outlines, like)
    rows = [rows_of(borders_of(outlines) @ share, like) for share in (BOTTOM, TOP)]
    sills, lintels = (
        _family(outlines, share, groups) for share, groups in zip((BOTTOM, TOP), rows, strict=True)
    )
    found = [
        _family(outlines, WIDTH, like),
        _family(outlines, HEIGHT, like),
        _family(outlines, MIDDLE, columns),
        sills if sills.between <= lintels.between else lintels,
    ]
    return [f for f in found if f.groups and f.between < MOST]


def _family(outlines: Sequence[Outline], share: Float, groups: Sequence[tuple[int, ...]]) -> Family:
    """Returns the groups without the members that contradict them, and the sigma between the others."""
    own, variance = values_of(outlines)
    value = own @ share
    sigma = np.sqrt([share @ v @ share for v in variance])
    left = [tuple(k for k in g if sigma[k] < UNKNOWN) for g in groups]
    while True:
        left = [g for g in left if len(g) > 1]
        between = between_members(value, sigma, left)
        worst, odd = _worst(value, sigma, left, between)
        if odd <= _ODD:
            return Family(share, tuple(left), between)
        left = [tuple(k for k in g if k != worst) for g in left]


def _worst(
    value: Float, sigma: Float, groups: Sequence[tuple[int, ...]], between: float
) -> tuple[int, float]:
    """Returns the member furthest from the mean of the others of its group, and how many sigmas."""
    worst, most = -1, 0.0
    for g in groups:
        for k in g:
            mean, error = predicted(value, sigma, [j for j in g if j != k], between)
            odd = abs(float(value[k]) - mean) / float(np.hypot(sigma[k], error))
            if odd > most:
                worst, most = k, odd
    return worst, most


def _pooled_depths(outlines: Sequence[Outline], families: Sequence[Family]) -> list[Estimate[float] | None]:
    """Returns the depths of like openings, each drawn towards the mean of the others."""
    depths: list[Estimate[float] | None] = [o.depth for o in outlines]
    value = np.array([np.nan if d is None else d.value for d in depths])
    sigma = np.array([np.nan if d is None else float(d.sigma[0]) for d in depths])
    groups = [tuple(k for k in g if depths[k] is not None) for g in like_groups(outlines)]
    groups = [g for g in groups if len(g) > 1]
    while groups:
        between = between_members(value, sigma, groups)
        worst, odd = _worst(value, sigma, groups, between)
        if odd <= _ODD:
            break
        groups = [h for g in groups if len(h := tuple(k for k in g if k != worst)) > 1]
    for g in groups:
        for k in g:
            mean, error = predicted(value, sigma, [j for j in g if j != k], between)
            own = depths[k]
            assert own is not None
            weight = error**2 / (error**2 + sigma[k] ** 2)
            source = Provenance.POOLED if weight < _MUCH else own.provenance
            at = float(weight * value[k] + (1.0 - weight) * mean)
            variance = weight * sigma[k] ** 2 + _ALIKE**2
            depths[k] = Estimate(at, np.array([[variance]]), own.dof, source)
    return depths


def _with_borders(outline: Outline, borders: Float, spread: Float, depth: Estimate[float] | None) -> Outline:
    """Returns the outline with other borders left, right, bottom, top m and their covariance (4, 4) m2."""
    left, right, bottom, top = (float(v) for v in borders)
    before = np.diag(outline.covariance)[:4]
    covariance = outline.covariance.copy()
    covariance[:4, :4] = spread + common_of(outline)
    # the rise keeps its correlation with the top
    covariance[3, 4] = covariance[4, 3] = outline.covariance[3, 4] * np.sqrt(covariance[3, 3] / before[3])
    owed = bool(np.any(np.diag(covariance)[:4] < _MUCH * before))
    return replace(outline, place=(left, bottom, right, top), covariance=covariance, depth=depth, pooled=owed)
