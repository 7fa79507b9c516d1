"""Tells which of two photos shows the wall where they disagree and no third one sees it.

Either both show the wall, in one colour with a normal error, or one of them does and the other shows what the
scan did not see: a walker, a car that has moved, a lamp beside the camera. The wall's own colours are known
from where photos agree; anything else may have any colour. The negative logarithm of the probability that
a photo shows the wall is the cost of taking it.
"""

from dataclasses import replace

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.ortho.colours import Colours, normal_density
from frontage.ortho.mosaic.consensus import FEWEST_PHOTOS, Disagreement

_STRANGE = 0.05  # share of cells in which a photo shows something else than the wall
_FEWEST = 200  # cells in which photos agree, from which colours of the wall are learned
_TAUGHT = 2  # one of so many cells, along rows and columns, tells the colours of the wall
_AGREE = 2.0  # standard deviations within which two photos show the same
_MOST_COST = 10.0
_WINDOW = 3  # cells over which costs are averaged


def judge_pairs(codes: Array, found: Disagreement, clear: Bool, glass: Bool) -> Disagreement:
    """Returns the comparison of photos, with costs also for the cells that only two photos see.

    `codes` (k, h, w, 3) are the colours of the photos, in one light, `clear` (k, h, w) tells where they see
    the facade with nothing in front, and `glass` (h, w) openings from wall.
    """
    count = clear.sum(0)
    pair = count == FEWEST_PHOTOS - 1
    if not pair.any():
        return found
    apart = _apart(found, clear)
    agreeing = found.accepted.all(0) & (count >= FEWEST_PHOTOS) | pair & (apart < _AGREE)
    some = np.s_[::_TAUGHT, ::_TAUGHT]
    cost, accepted = np.zeros_like(found.cost), found.accepted.copy()
    for kind in (False, True):
        at, sample = pair & (glass == kind), agreeing & (glass == kind)
        if at.any() and sample[some].sum() >= _FEWEST:
            place, chance = _judged(
                codes, clear, at, Colours.of(found.wall[some][sample[some]]), apart, found.sigma
            )
            cost[place] = np.minimum(-np.log(np.maximum(chance, 1e-9)), _MOST_COST)
            accepted[place] = chance > 0.5
    for against in cost:
        cv2.blur(against, (_WINDOW, _WINDOW), dst=against)
    cost += found.cost
    return replace(found, cost=cost, accepted=accepted)


def _judged(
    codes: Array, clear: Bool, at: Bool, own: Colours, apart: Array, sigma: Array
) -> tuple[tuple[Int, Int, Int], Float]:
    """The places (photos, rows, columns) of pairs in cells `at` (h, w); how likely each shows the wall."""
    rows, columns = np.nonzero(at)
    first, second = np.argsort(~clear[:, rows, columns], axis=0, kind="stable")[:2]
    one, other = (own(codes[photo, rows, columns]) for photo in (first, second))
    chances = _chances(one, other, _fit(apart[at], sigma[at]))
    place = np.concatenate([first, second]), np.tile(rows, 2), np.tile(columns, 2)
    return place, np.concatenate(chances)


def _apart(found: Disagreement, clear: Bool) -> Array:
    """How far (h, w) the colours of two photos lie apart, in standard deviations of their difference.

    Each is half as far from the mean of the two.
    """
    half = np.where(clear, found.distance, np.float32(0.0)).max(0)
    return np.asarray(half * np.float32(np.sqrt(2.0)) / found.sigma)


def _fit(apart: Array, sigma: Array) -> Float:
    """The density (n,) of the difference of two photos that both show the wall."""
    spread = np.sqrt(2.0) * sigma.astype(np.float64)
    return normal_density(apart.astype(np.float64), spread)


def _chances(one: Array, other: Array, fit: Float) -> tuple[Float, Float]:
    """The probabilities (n,) that the one and the other of two photos show the wall.

    `one` and `other` (n,) are the densities of their colours on the wall.
    """
    mean = 0.5 * (one + other)
    both = (1.0 - _STRANGE) ** 2 * mean * fit
    first, second = ((1.0 - _STRANGE) * _STRANGE * density for density in (one, other))
    total = both + first + second + _STRANGE**2
    return np.asarray((both + first) / total), np.asarray((both + second) / total)
