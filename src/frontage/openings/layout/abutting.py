"""Openings without masonry between them, as a door beside a shop window, are parted where their frames step.

Such openings are one hole in the wall. Units of joinery that were built apart have frames at depths of their
own, which meet in an upright line; the frame of one unit lies in one plane along its head and jambs, whatever
its panes, curtains and open casements return.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float
from frontage.model.masonry import TOLERANCES
from frontage.openings.borders.depth import AROUND, FRAME, find_depth
from frontage.openings.borders.outline import Outline
from frontage.openings.wall.crossings import CrossingBeams

_STEP = 0.06  # m: the sashes of one sliding window lie no farther apart
_LEAST = 0.5  # m, least width of the openings on both sides
_JOINT = 0.01  # m between two units, which are built apart
_DEEPEST = 1.0  # m: deeper points are in a room
_BIN = 0.01  # m, bin of depths
_OWN = 0.7  # share of the points on a frame that lie in its plane
_FEW = 8  # points that tell where a frame lies


@dataclass(frozen=True)
class _Step:
    """An upright line x = `at` m, known to `sigma` m, at which the frames of two openings meet."""

    at: float
    sigma: float


def parted_at_steps(outline: Outline, beams: CrossingBeams) -> list[Outline]:
    """Returns the openings that an outline consists of, from left to right, parted where the frame steps."""
    near = beams.around(outline.place, AROUND)
    ends = [None, *_find_steps(near, outline), None]
    return [_part(outline, left, right, near) for left, right in pairwise(ends)]


def _part(outline: Outline, left: _Step | None, right: _Step | None, near: CrossingBeams) -> Outline:
    """Returns the part of an opening between two steps; where there is none, its own border stays."""
    if left is right is None:
        return outline
    covariance, borders, ends = outline.covariance.copy(), list(outline.borders), list(outline.place)
    for side, step in enumerate((left, right)):
        if step is not None:
            ends[2 * side] = at = step.at + (0.5 - side) * _JOINT
            covariance[side, :] = covariance[:, side] = 0.0
            covariance[side, side] = step.sigma**2
            borders[side] = replace(borders[side], at=at, sigma=step.sigma)
    place = (ends[0], ends[1], ends[2], ends[3])
    depth = find_depth(near, place, 0.0, 2.0 * max(borders[0].sigma, borders[1].sigma))
    return replace(outline, place=place, covariance=covariance, borders=tuple(borders), depth=depth)


def _find_steps(near: CrossingBeams, outline: Outline) -> list[_Step]:
    """Returns where the frame along the head of an opening goes on at another depth, from left to right.

    Each part of the head must lie at one of two depths, and the jambs at that of the head beside them.
    """
    x0, z0, x1, z1 = outline.place
    if outline.rise > 0.0 or x1 - x0 < 2.0 * _LEAST:
        return []
    deep = np.flatnonzero((near.depth > near.wall) & (near.depth < _DEEPEST))
    x, z = near.points.take(deep, 1)
    y = near.depth[deep] + near.level[deep]
    inside = (x > x0 + FRAME[0]) & (x < x1 - FRAME[0]) & (z > z0) & (z < z1 - FRAME[0])
    head = np.flatnonzero(inside & (z > z1 - FRAME[1]))
    head = head[np.argsort(x[head], kind="stable")]
    levels = _two_levels(y[head])
    if levels is None:
        return []
    on = np.abs(y - levels[:, None]) <= max(near.wall, TOLERANCES.least_on_wall)
    cuts = _changes(x[head], on[:, head])
    ends = pairwise([(0, 0), *cuts, (len(head), len(head))])
    parts = [on[:, head[a:b]].mean(1) for (_, a), (b, _) in ends]
    jambs = on[:, inside & (x < x0 + FRAME[1])], on[:, inside & (x > x1 - FRAME[1])]
    beside = zip((parts[0], parts[-1]), jambs, strict=True)
    agree = all(jamb[part.argmax()].sum() >= _OWN * jamb.sum() for part, jamb in beside)
    if not agree or min(part.max() for part in parts) <= _OWN:
        return []
    pairs = [(float(x[head[a - 1]]), float(x[head[b]])) for a, b in cuts]
    return [_Step((a + b) / 2.0, np.hypot(b - a, _JOINT) / np.sqrt(12.0)) for a, b in pairs]


def _two_levels(y: Float) -> Float | None:
    """Returns the two depths (2,) m, a step apart, that hold the most of the points (n,) m; None without."""
    if len(y) < 2 * _FEW:
        return None
    low = float(y.min())
    number = np.bincount(((y - low) / _BIN).astype(np.int64))
    count = ndimage.uniform_filter1d(number.astype(np.float64), 3, mode="constant") * 3.0
    middle = low + (np.arange(len(count)) + 0.5) * _BIN
    first = int(count.argmax())
    others = np.where(np.abs(middle - middle[first]) > _STEP, count, 0.0)
    second = int(others.argmax())
    if others[second] < _FEW:
        return None
    near = (np.abs(y - middle[k]) < 1.5 * _BIN for k in (first, second))
    return np.array([float(np.median(y[some])) for some in near])


def _changes(x: Float, on: Bool, first: int = 0) -> list[tuple[int, int]]:
    """Returns between which of the points at rising x (n,) m they change to the other level.

    These are the numbers of the first point that is not at one level any more, and of the first at the other.
    `on` (2, n) tells which points lie at either level, and `first` is the number of the first point. More of
    the points are at the level of their part than without the change.
    """
    below = np.hstack([np.zeros((2, 1)), on.cumsum(1)])
    agree = np.max([below[k] + below[1 - k, -1] - below[1 - k] for k in (0, 1)], axis=0)[:-1]
    far = np.flatnonzero((x > x[0] + _LEAST) & (x < x[-1] - _LEAST))
    best = far[agree[far] == agree[far].max(initial=0.0)]
    if not len(best) or agree[best[0]] < below[:, -1].max() + _FEW:
        return []
    a = int(best[0])
    b = int(best[best - np.arange(len(best)) == a][-1])  # points between two levels tell nothing
    left, right = _changes(x[:a], on[:, :a], first), _changes(x[b:], on[:, b:], first + b)
    return [*left, (first + a, first + b), *right]
