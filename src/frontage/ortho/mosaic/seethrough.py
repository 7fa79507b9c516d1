"""Asks the photos whether the wall can be seen where the scan says that something stands before it.

Between the leaves of a tree the wall shows, in other places from every photo, and a car may have left, but
only as a whole. Where no photo is clear, the colour of each photo is either that of the wall, which is the
same in all photos that see it and likely on this facade, or that of what stands before it. Both
distributions, and how often the scan is wrong, are learned where another photo is clear and shows what the
wall looks like. The probability of the wall follows by Bayes' rule, with the colour of every photo in turn as
that of the wall.
"""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float
from frontage.ortho.colours import Colours, normal_density
from frontage.ortho.mosaic.consensus import FEWEST_PHOTOS, MEDIAN_LENGTH, Disagreement
from frontage.ortho.views import ViewPlan

_SAME = 5.7  # standard deviations within which 99.9 % of two colours of one surface lie, in three channels
_FEWEST = 200  # cells from which the colours of occluders are learned
_SAMPLED = 3  # one of so many cells, along rows and columns, tells how much photos differ
_TAUGHT = 2  # likewise, the colours of wall and glass
_WINDOW = 3  # cells over which log odds are averaged
_ODDS = np.log(1.5)  # of wall against occluder, averaged, from which on the wall is painted
_GONE = np.log(3.0)  # of the whole of what has no gaps
_MOST_ODDS = 5.0  # of one cell, so that most of its neighbours decide and not a single one
_RANGE = (0.02, 0.5)  # of the share of cells in which the wall shows although the scan hides it


def see_through(codes: Array, found: Disagreement, plan: ViewPlan, glass: Bool) -> Bool:
    """Returns the cells (k, h, w) in which photos show the wall although the scan puts something before it.

    `codes` (k, h, w, 3) are the colours of the photos, in one light; `found` compares them with that of the
    wall, which is known where photos of the plan are clear; the cells behind something
    are those in question, and `glass` (h, w) tells openings from wall. Only cells without a clear photo are
    judged.
    """
    wall, sigma = found.wall, found.sigma
    known, behind = plan.clear.any(0), plan.behind
    judged = behind & ~known
    through = np.zeros_like(behind)
    learned = behind & known
    if not judged.any() or learned.sum() < _FEWEST:
        return through
    spread = _spreads(found, plan.clear, glass)
    tolerance = np.maximum(sigma, np.where(glass, spread[1], spread[0]).astype(np.float32))
    same = found.distance < _SAME * tolerance
    seen = float(np.clip((learned & same).sum() / learned.sum(), *_RANGE))
    if (learned & ~same).sum() < _FEWEST:
        return through
    before = Colours.of(_at(codes, learned & ~same))
    odds, some = np.full(behind.shape, -20.0, np.float32), np.s_[::_TAUGHT, ::_TAUGHT]
    for kind in (False, True):
        cells = judged.any(0) & (glass == kind)
        sample = (known & (glass == kind))[some]
        if cells.any() and sample.any():
            own = Colours.of(wall[some][sample])
            at = np.flatnonzero(cells)
            colours, asked = (
                np.take(a.reshape(len(a), cells.size, *a.shape[3:]), at, 1) for a in (codes, judged)
            )
            odds.reshape(len(odds), -1)[:, at] = _log_odds(colours, asked, own, before, spread[kind], seen)
    limited = np.where(judged, np.clip(odds, -_MOST_ODDS, _MOST_ODDS), 0.0).astype(np.float32)
    smooth = np.stack([cv2.blur(o, (_WINDOW, _WINDOW)) for o in limited])
    whole = limited + _compared(codes, found, tolerance, learned & plan.solid, before, seen)
    there = np.stack([_stays(o, mask) for o, mask in zip(whole, plan.solid, strict=True)])
    return np.asarray(judged & (smooth > _ODDS) & (limited > 0.0) & ~there)


def _spreads(found: Disagreement, clear: Bool, glass: Bool) -> tuple[float, float]:
    """The standard deviations of the colours of photos of one place: on the wall, and on glass.

    Behind glass and in its reflections every photo shows something else.
    """
    out = []
    some = np.s_[..., ::_SAMPLED, ::_SAMPLED]
    clear, glass, distance, sigma = clear[some], glass[some], found.distance[some], found.sigma[some]
    count = clear.sum(0)
    for kind in (False, True):
        compared = clear & (glass == kind) & (count >= FEWEST_PHOTOS)
        typical = float(np.median(distance[compared])) / MEDIAN_LENGTH if compared.any() else 0.0
        cells = (count > 0) & (glass == kind)
        out.append(max(typical, float(np.median(sigma[cells])) if cells.any() else 0.0))
    return max(out[0], 1e-6), max(out)


def _compared(
    codes: Array, found: Disagreement, sigma: Array, known: Bool, before: Colours, seen: float
) -> Array:
    """Log odds (k, h, w) that photos show the wall in cells (k, h, w) in which it is `known`, elsewhere 0."""
    odds = np.zeros(known.shape, np.float32)
    at = np.flatnonzero(known)
    own = np.take(sigma.ravel(), at % sigma.size)
    fit = normal_density(np.take(found.distance.ravel(), at) / own, own)
    ratio = seen * np.maximum(fit, 1e-9) / ((1.0 - seen) * before(_at(codes, known)))
    odds.ravel()[at] = np.clip(np.log(ratio), -_MOST_ODDS, _MOST_ODDS)
    return odds


def _at(codes: Array, where: Bool) -> Array:
    """The colours (n, 3) of the cells of photos (k, h, w, 3) that a mask (k, h, w) names."""
    return np.asarray(np.take(codes.reshape(-1, 3), np.flatnonzero(where), axis=0))


def _stays(odds: Array, solid: Bool) -> Bool:
    """Cells (h, w) behind things without gaps that still stand there, by the mean log odds of each."""
    count, number = cv2.connectedComponents(solid.astype(np.uint8), connectivity=8)
    own = number[solid]
    mean = np.bincount(own, odds[solid], count) / np.maximum(np.bincount(own, minlength=count), 1)
    there = np.zeros_like(solid)
    there[solid] = mean[own] <= _GONE
    return there


def _log_odds(codes: Array, judged: Bool, own: Colours, before: Colours, sigma: float, seen: float) -> Float:
    """Log odds (k, n) that photos of colours (k, n, 3) show the wall; without `judged` (k, n) ones -20."""
    k = len(codes)
    other = np.where(judged, before(codes), 1.0)
    variance = 2.0 * sigma**2  # of the difference of two photos
    peak = (2.0 * np.pi * variance) ** -1.5
    total = np.zeros(codes.shape[1])  # weights of all ways: no photo sees the wall, or it looks as in photo i
    mine = np.zeros(codes.shape[:2])
    none = np.where(judged, (1.0 - seen) * other, 1.0).prod(0)
    total += none
    for i in range(k):
        off = codes - codes[i]
        off = np.einsum("kni,kni->kn", off, off)
        like = seen * peak * np.exp(-0.5 * off / variance)
        unlike = (1.0 - seen) * other
        share = np.where(judged, like / (like + unlike), 0.0)
        share[i] = judged[i]
        every = np.where(judged, like + unlike, 1.0)
        every[i] = np.where(judged[i], seen * own(codes[i]), 0.0)
        weight = every.prod(0)
        total += weight
        mine += weight * share
    chance = np.clip(mine / np.maximum(total, 1e-300), 1e-9, 1.0 - 1e-9)
    return np.where(judged, np.log(chance) - np.log1p(-chance), -20.0)
