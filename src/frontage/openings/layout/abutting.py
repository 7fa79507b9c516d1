"""Separates openings that have no masonry between them, such as a door beside a shop window.

Such openings are one hole in the wall. Each unit of joinery has its own frame, which lies in one plane along
its head and jambs, whatever its panes, curtains and open casements return. Frames of units that were built
separately lie at different depths, and meet in an upright line.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.model.masonry import TOLERANCES
from frontage.openings.borders.depth import AROUND, FRAME, find_depth, points_behind
from frontage.openings.borders.outline import Outline
from frontage.openings.wall.crossings import CrossingBeams

_STEP = 0.06  # m: the sashes of one sliding window lie no farther apart
_LEAST = 0.5  # m, least width of the openings on both sides
_JOINT = 0.01  # m between two units, which are built apart
_BIN = 0.01  # m, bin of depths
_OWN = 0.7  # share of the points on a frame that lie in its plane
_FEW = 8  # points that tell where a frame lies


@dataclass(frozen=True)
class _Step:
    """An upright line x = `at` m, known to `sigma` m, at which the frames of two openings meet."""

    at: float
    sigma: float


def parted_at_steps(outline: Outline, beams: CrossingBeams) -> list[Outline]:
    """Divides an outline at the steps of its frame and returns the openings from left to right."""
    near = beams.around(outline.place, AROUND)
    ends = [None, *_find_steps(near, outline), None]
    return [_part(outline, left, right, near) for left, right in pairwise(ends)]


def _part(outline: Outline, left: _Step | None, right: _Step | None, near: CrossingBeams) -> Outline:
    """Returns the part of an opening between two steps. Without a step on a side, its own border stays."""
    if left is right is None:
        return outline
    part = outline
    for side, step, towards in ((0, left, 0.5), (1, right, -0.5)):
        if step is not None:
            part = part.with_border(side, step.at + towards * _JOINT, step.sigma)
    slack = 2.0 * max(part.borders[0].sigma, part.borders[1].sigma)
    return replace(part, depth=find_depth(near, part.place, 0.0, slack))


def _find_steps(near: CrossingBeams, outline: Outline) -> list[_Step]:
    """Finds the steps of the frame along the head of an opening, from left to right.

    Each part of the head must lie at one of two depths, and each jamb at the depth of the head beside it.
    """
    x0, z0, x1, z1 = outline.place
    if outline.rise > 0.0 or x1 - x0 < 2.0 * _LEAST:
        return []
    x, y, z = points_behind(near)
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
    """Returns the two depths (2,) m, a step apart, that hold most points y (n,) m, or None."""
    if len(y) < 2 * _FEW:
        return None
    low = float(y.min())
    number = np.bincount(((y - low) / _BIN).astype(np.int64))
    count = np.convolve(number, [1, 1, 1], "same")
    middle = low + (np.arange(len(count)) + 0.5) * _BIN
    first = int(count.argmax())
    others = np.where(np.abs(middle - middle[first]) > _STEP, count, 0)
    second = int(others.argmax())
    if others[second] < _FEW:
        return None
    near = (np.abs(y - middle[k]) < 1.5 * _BIN for k in (first, second))
    return np.array([float(np.median(y[some])) for some in near])


def _changes(x: Float, on: Bool) -> list[tuple[int, int]]:
    """Finds where points at rising x (n,) m change from one level to the other.

    `on` (2, n) tells which points lie at either level. Each change is a pair of point numbers: points from
    the first one on no longer lie at the old level, and points from the second one on lie at the new level.
    A change counts if it puts more points at the level of their part.
    """
    below = np.hstack([np.zeros((2, 1)), on.cumsum(1)])
    agree = np.max([below[k] + below[1 - k, -1] - below[1 - k] for k in (0, 1)], axis=0)[:-1]
    far = np.flatnonzero((x > x[0] + _LEAST) & (x < x[-1] - _LEAST))
    best = far[agree[far] == agree[far].max(initial=0.0)]
    if not len(best) or agree[best[0]] < below[:, -1].max() + _FEW:
        return []
    a = int(best[0])
    b = int(best[best - np.arange(len(best)) == a][-1])  # points between two levels tell nothing
    right = [(b + i, b + k) for i, k in _changes(x[b:], on[:, b:])]
    return [*_changes(x[:a], on[:, :a]), (a, b), *right]
