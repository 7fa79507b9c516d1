"""Settle the street sides of walls by the walls that they meet in a corner.

Two walls that meet in a corner look at the same room or the same court from inside, or at the same open space
from outside: each either lies before the other, or behind it. A light court without ground or roof tells
little about one of its walls, but its other walls tell the rest.
"""

from dataclasses import replace
from itertools import combinations

import numpy as np

from frontage.facades.candidate import FacadeCandidate, turned
from frontage.geometry.arrays import Float
from frontage.model.masonry import MASONRY

_CORNER = 2.0  # log odds of a corner: 7 to 1, because rooms are scanned too
_LEAST_SINE = 0.5  # of the angle between them: 30 degrees
_LEAST_SHARED = 0.5  # share of the lower wall's height that both have

APART_M = 0.75
"""Distance in plan between the ends of two walls that meet, m: cornices and downpipes hide the corner."""


def with_sides_of_corners(candidates: list[FacadeCandidate]) -> list[FacadeCandidate]:
    """Turns a wall round where its corners contradict its street side more than its own evidence supports it.

    The wall with the strongest contradiction is turned first, until none remains. Walls with known rays stay.
    The odds of the others are told anew, from their own evidence and their corners.
    """
    spans, number = [_span(c) for c in candidates], len(candidates)
    agree = np.zeros((number, number))
    for i, k in combinations(range(number), 2):
        agree[i, k] = agree[k, i] = _agreement(spans[i], spans[k])
    own = np.array([_log_odds(c) for c in candidates])
    fixed = np.array([c.side.told_by == "rays" for c in candidates], np.bool_)
    sign, total = np.ones(number), np.zeros(number)
    for _ in range(number):
        total = sign * (own + _CORNER * (agree @ sign))
        if total[~fixed].min(initial=0.0) >= 0.0:
            break
        sign[np.where(fixed, np.inf, total).argmin()] *= -1.0
    return [_settled(c, s, t) for c, s, t in zip(candidates, sign, total, strict=True)]


def is_side(front: FacadeCandidate, wall: FacadeCandidate) -> bool:
    """Returns whether a wall goes on round the end of a front, as the outer side of the house.

    The front ends in the plane of the wall and lies behind it. It runs past the inner face of such a side by
    the thickness of the masonry.
    """
    own, other = _span(front), _span(wall)
    if _agreement(own, other) != 1:
        return False
    (ends, _, _), (there, _, normal) = own, other
    behind = (ends - wall.wall.point[:2]) @ normal
    corner = int(np.linalg.norm(ends[:, None] - there[None], axis=2).min(1).argmin())
    return bool(abs(behind[corner]) < MASONRY.half_brick and behind[1 - corner] > 0.0)


def _settled(candidate: FacadeCandidate, sign: float, log_odds: float) -> FacadeCandidate:
    """Returns a candidate turned where `sign` is negative, with the odds of its street side."""
    if candidate.side.told_by == "rays":
        return candidate
    side = replace(candidate.side, odds=float(np.exp(-max(log_odds, 0.0))))
    candidate = replace(candidate, side=side)
    return turned(candidate) if sign < 0.0 else candidate


def _log_odds(candidate: FacadeCandidate) -> float:
    """Returns the log odds of a wall's street side."""
    return -float(np.log(max(candidate.side.odds, 1e-3)))


def _span(candidate: FacadeCandidate) -> tuple[Float, Float, Float]:
    """Returns the ends (2, 2) m of a wall in plan, its heights (2,) m, and its normal (2,) in plan."""
    low, high = candidate.cells.outline.min(0), candidate.cells.outline.max(0)
    along = np.array([[low[0], 0.0, 0.0], [high[0], 0.0, 0.0]])
    ends = candidate.wall.point + along @ candidate.wall.axes.T
    return ends[:, :2], candidate.wall.point[2] + np.array([low[1], high[1]]), candidate.wall.normal[:2]


def _agreement(own: tuple[Float, Float, Float], other: tuple[Float, Float, Float]) -> int:
    """Returns +1 if two walls meet in a corner and look at the same space, -1 if they do not, 0 if apart."""
    (ends, heights, normal), (ends2, heights2, normal2) = own, other
    shared = min(heights[1], heights2[1]) - max(heights[0], heights2[0])
    sine = abs(float(normal[0] * normal2[1] - normal[1] * normal2[0]))
    if sine < _LEAST_SINE or shared < _LEAST_SHARED * min(np.ptp(heights), np.ptp(heights2)):
        return 0
    apart = np.linalg.norm(ends[:, None] - ends2[None], axis=2)
    i, k = np.unravel_index(int(apart.argmin()), apart.shape)
    if apart[i, k] > APART_M:
        return 0
    behind = float((ends2[1 - k] - ends[i]) @ normal), float((ends[1 - i] - ends2[k]) @ normal2)
    return 1 if behind[0] * behind[1] > 0.0 else -1
