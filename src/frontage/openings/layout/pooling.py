"""What openings share: rows, columns and sizes, pooled as far as their own errors allow.

Every family (widths and heights of like openings, middles of columns, sills or lintels of rows, depths of
like openings) is normally distributed about its mean. Its variance between members is what their scatter
exceeds their own errors by. So pooling shrinks errors where the facade is regular, and does not where it is
not; a member that contradicts its family is left out of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from frontage.geometry.arrays import Float
from frontage.model.estimate import Estimate, Provenance
from frontage.openings.borders.outline import Outline

WIDTH = np.array([-1.0, 1.0, 0.0, 0.0])
HEIGHT = np.array([0.0, 0.0, -1.0, 1.0])
MIDDLE = np.array([0.5, 0.5, 0.0, 0.0])
BOTTOM = np.array([0.0, 0.0, 1.0, 0.0])
TOP = np.array([0.0, 0.0, 0.0, 1.0])
"""What openings may share, as weights of their borders left, right, bottom, top."""

UNKNOWN = 0.1
"""m: openings known no better than that are not members."""

LIKE = 3.0
"""Sigmas between neighbouring sizes of like openings, at most."""

_COLUMN = 0.25  # share of the narrower width: openings whose middles are nearer stand in one column
_ROW = 0.15  # m: sills nearer than that are a row
_ODD = 3.5  # sigmas from the others from which a member is left out
_CAUTION = 0.7  # sets the variance between members at the lower quartile of the distribution of the scatter
_LEAST = 0.001  # m, one sigma between members at least: masonry
_MOST = 1.0  # m, one sigma between members that is as good as none
_ALIKE = 0.001  # m, one sigma of depths: what scanner, wall and joinery do to all frames alike
_SHARED = 0.9  # share of a border's variance, at most, that is common to all
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


def values_of(outlines: Sequence[Outline]) -> tuple[Float, list[Float]]:
    """Returns the borders left, right, bottom, top (n, 4) m and the covariances (4, 4) m2 of their errors."""
    return borders_of(outlines), [o.covariance[:4, :4] - _common(o) for o in outlines]


def borders_of(outlines: Sequence[Outline]) -> Float:
    """Returns the borders left, right, bottom, top (n, 4) m."""
    return np.array([(o.place[0], o.place[2], o.place[1], o.place[3]) for o in outlines]).reshape(-1, 4)


def _common(outline: Outline) -> Float:
    """Returns the covariance (4, 4) m2 that all openings share: the doubt of the footprint."""
    doubt = np.array([b.edge.doubt for b in outline.borders] or [0.0] * 4)
    return np.diag(np.minimum(doubt**2, _SHARED * np.diag(outline.covariance)[:4]))


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
    return [f for f in found if f.groups and f.between < _MOST]


def columns_of(outlines: Sequence[Outline], groups: Sequence[Sequence[int]]) -> list[tuple[int, ...]]:
    """Returns the columns within groups of openings: those whose middles are near each other."""
    own = borders_of(outlines)
    near = _COLUMN * float((own @ WIDTH).min())
    return [column for group in groups for column in _clusters(own @ MIDDLE, near, group)]


def rows_of(level: Float, groups: Sequence[Sequence[int]], least: int = 2) -> list[tuple[int, ...]]:
    """Returns the rows of `least` openings or more within groups of them.

    The sills or the lintels of a row, `level` (n,) m, are near each other.
    """
    return [row for group in groups for row in _clusters(level, _ROW, group, least=least)]


def equally_high(outlines: Sequence[Outline], groups: Sequence[Sequence[int]]) -> list[tuple[int, ...]]:
    """Returns groups of openings of one shape and height: those of the given groups of like ones that agree.

    Narrow windows (of stairs and bathrooms) have the sill and the lintel of the wide ones beside them.
    """
    own, variance = values_of(outlines)
    height, error = own @ HEIGHT, np.sqrt([HEIGHT @ v @ HEIGHT for v in variance])
    between = [min(between_members(height, error, [tuple(g)]), UNKNOWN) for g in groups]
    told = [predicted(height, error, g, b) for g, b in zip(groups, between, strict=True)]
    size, sigma = np.array(told).reshape(-1, 2).T
    shapes = [outlines[g[0]].shape for g in groups]
    found = []
    for shape in dict.fromkeys(shapes):
        some = [n for n, own_shape in enumerate(shapes) if own_shape == shape]
        for part in _clusters(size, LIKE, some, sigma, least=1):
            found.append(tuple(sorted(k for n in part for k in groups[n])))
    return found


def levels_of(own: Float, variance: Sequence[Float], groups: Sequence[Sequence[int]]) -> tuple[Float, Float]:
    """Returns the sills (n,) m of openings and their sigmas (n,) m, by whichever border is seen.

    `own` (n, 4) m are their borders with their covariances (4, 4) m2. Openings of one group are equally high,
    so a lintel tells the sill as well: often that of a window whose sill lies behind a ledge or a balcony.
    """
    level, height = own @ BOTTOM, own @ HEIGHT
    sill, lintel, error = (np.sqrt([w @ v @ w for v in variance]) for w in (BOTTOM, TOP, HEIGHT))
    sigma = sill.copy()
    for group in map(list, groups):
        between = min(between_members(height, error, [tuple(group)]), UNKNOWN)
        size, doubt = predicted(height, error, group, between)
        weight = sill[group] ** -2.0, (lintel[group] ** 2 + doubt**2) ** -1.0
        both = weight[0] + weight[1]
        level[group] = (weight[0] * (own[group] @ BOTTOM) + weight[1] * (own[group] @ TOP - size)) / both
        sigma[group] = both**-0.5
    return level, sigma


def like_groups(outlines: Sequence[Outline]) -> list[tuple[int, ...]]:
    """Returns groups of openings of one shape whose widths and heights agree within their errors."""
    own, variance = values_of(outlines)
    groups = [
        tuple(k for k, o in enumerate(outlines) if o.shape == shape)
        for shape in dict.fromkeys(o.shape for o in outlines)
    ]
    for share in (WIDTH, HEIGHT, WIDTH):
        size = own @ share
        sigma = np.sqrt([share @ v @ share for v in variance])
        groups = [
            part
            for group in groups
            for part in _clusters(size, LIKE, [k for k in group if sigma[k] < UNKNOWN], sigma)
        ]
    return groups


def _clusters(
    value: Float, gap: float, members: Sequence[int], sigma: Float | None = None, least: int = 2
) -> list[tuple[int, ...]]:
    """Returns the members whose sorted values are at most `gap` m apart, or `gap` times `sigma` (n,) m."""
    order = sorted(members, key=lambda k: (float(value[k]), k))
    if not order:
        return []
    step = np.diff(value[order])
    limit = gap if sigma is None else gap * np.hypot(sigma[order][1:], sigma[order][:-1])
    cuts = np.flatnonzero(step > limit) + 1
    return [tuple(int(k) for k in part) for part in np.split(np.array(order), cuts) if len(part) >= least]


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


def between_members(value: Float, sigma: Float, groups: Sequence[tuple[int, ...]]) -> float:
    """Returns the sigma m between the members of groups, beyond their own errors `sigma` (n,) m.

    Mandel and Paule (1970): sum (v - mean)^2 / (sigma^2 + between^2) equals its degrees of freedom; here it
    equals the lower quartile of its distribution, so that few members are pooled with caution.
    """
    freedom = sum(len(g) - 1 for g in groups)
    target = freedom - _CAUTION * np.sqrt(2.0 * freedom)
    if target <= 0.05:
        return _MOST

    members = [(sigma[list(g)] ** 2, value[list(g)]) for g in groups]

    def excess(between: float) -> float:
        """Returns the scatter of the members for a sigma between them, less what is expected."""
        total = 0.0
        for variance, v in members:
            w = 1.0 / (variance + between**2)
            total += float(w @ (v - w @ v / w.sum()) ** 2)
        return float(total - target)

    if excess(_LEAST) <= 0:
        return _LEAST
    return float(brentq(excess, _LEAST, _MOST)) if excess(_MOST) < 0 else _MOST


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


def predicted(value: Float, sigma: Float, others: Sequence[int], between: float) -> tuple[float, float]:
    """Returns what a further member would be by the `others` of its group, and its sigma, m."""
    w = 1.0 / (sigma[list(others)] ** 2 + between**2)
    return float(w @ value[list(others)] / w.sum()), float(np.sqrt(1.0 / w.sum() + between**2))


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
    covariance[:4, :4] = spread + _common(outline)
    # the rise keeps its correlation with the top
    covariance[3, 4] = covariance[4, 3] = outline.covariance[3, 4] * np.sqrt(covariance[3, 3] / before[3])
    owed = bool(np.any(np.diag(covariance)[:4] < _MUCH * before))
    return replace(outline, place=(left, bottom, right, top), covariance=covariance, depth=depth, pooled=owed)
