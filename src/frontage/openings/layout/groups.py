"""Which openings belong together: like ones, rows and columns, and what the others of a group tell of one."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq

from frontage.geometry.arrays import Float
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

MOST = 1.0
"""m, one sigma between members that is as good as none."""

_COLUMN = 0.25  # share of the narrower width: openings whose middles are nearer stand in one column
_ROW = 0.15  # m: sills nearer than that are a row
_CAUTION = 0.7  # sets the variance between members at the lower quartile of the distribution of the scatter
_LEAST = 0.001  # m, one sigma between members at least: masonry
_SHARED = 0.9  # share of a border's variance, at most, that is common to all


def values_of(outlines: Sequence[Outline]) -> tuple[Float, list[Float]]:
    """Returns the borders left, right, bottom, top (n, 4) m and the covariances (4, 4) m2 of their errors."""
    return borders_of(outlines), [o.covariance[:4, :4] - common_of(o) for o in outlines]


def borders_of(outlines: Sequence[Outline]) -> Float:
    """Returns the borders left, right, bottom, top (n, 4) m."""
    return np.array([(o.place[0], o.place[2], o.place[1], o.place[3]) for o in outlines]).reshape(-1, 4)


def common_of(outline: Outline) -> Float:
    """Returns the covariance (4, 4) m2 that all openings share: the doubt of the footprint."""
    doubt = np.array([b.edge.doubt for b in outline.borders] or [0.0] * 4)
    return np.diag(np.minimum(doubt**2, _SHARED * np.diag(outline.covariance)[:4]))


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


def equally_high(outlines: Sequence[Outline], groups: Sequence[Sequence[int]]) -> list[tuple[int, ...]]:
    """Returns the groups of like openings, merged where shapes are equal and heights agree within errors.

    Widths do not matter: narrow windows (of stairs and bathrooms) have the sill and the lintel of the wide
    ones beside them.
    """
    own, variance = values_of(outlines)
    height, error = own @ HEIGHT, np.sqrt([HEIGHT @ v @ HEIGHT for v in variance])
    size, sigma = np.array([size_like(height, error, g) for g in groups]).reshape(-1, 2).T
    shapes = [outlines[g[0]].shape for g in groups]
    found = []
    for shape in dict.fromkeys(shapes):
        some = [n for n, own_shape in enumerate(shapes) if own_shape == shape]
        for part in _clusters(size, LIKE, some, sigma, least=1):
            found.append(tuple(sorted(k for n in part for k in groups[n])))
    return found


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


def levels_of(own: Float, variance: Sequence[Float], groups: Sequence[Sequence[int]]) -> tuple[Float, Float]:
    """Returns the sills (n,) m of openings and their sigmas (n,) m, by whichever border is seen.

    `own` (n, 4) m are their borders with their covariances (4, 4) m2. Openings of one group are equally high,
    so a lintel tells the sill as well: often that of a window whose sill lies behind a ledge or a balcony.
    """
    level, height = own @ BOTTOM, own @ HEIGHT
    sill, lintel, error = (np.sqrt([w @ v @ w for v in variance]) for w in (BOTTOM, TOP, HEIGHT))
    sigma = sill.copy()
    for group in map(list, groups):
        size, doubt = size_like(height, error, group)
        weight = sill[group] ** -2.0, (lintel[group] ** 2 + doubt**2) ** -1.0
        both = weight[0] + weight[1]
        level[group] = (weight[0] * (own[group] @ BOTTOM) + weight[1] * (own[group] @ TOP - size)) / both
        sigma[group] = both**-0.5
    return level, sigma


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


def between_members(value: Float, sigma: Float, groups: Sequence[tuple[int, ...]]) -> float:
    """Returns the sigma m between the members of groups, beyond their own errors `sigma` (n,) m.

    Mandel and Paule (1970): sum (v - mean)^2 / (sigma^2 + between^2) equals its degrees of freedom; here it
    equals the lower quartile of its distribution, so that few members are pooled with caution.
    """
    freedom = sum(len(g) - 1 for g in groups)
    target = freedom - _CAUTION * np.sqrt(2.0 * freedom)
    if target <= 0.05:
        return MOST

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
    return float(brentq(excess, _LEAST, MOST)) if excess(MOST) < 0 else MOST


def predicted(value: Float, sigma: Float, others: Sequence[int], between: float) -> tuple[float, float]:
    """Returns what a further member would be by the `others` of its group, and its sigma, m."""
    w = 1.0 / (sigma[list(others)] ** 2 + between**2)
    return float(w @ value[list(others)] / w.sum()), float(np.sqrt(1.0 / w.sum() + between**2))


def size_like(size: Float, sigma: Float, others: Sequence[int]) -> tuple[float, float]:
    """Returns the size m, a width or a height, of one more opening like the `others`, and its sigma m.

    `size` (n,) m and `sigma` (n,) m are those of all openings.
    """
    between = between_members(size, sigma, [tuple(others)])
    return predicted(size, sigma, others, min(between, UNKNOWN))
