"""Locates the borders of an opening: a posterior from the beams on both sides of each."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Float
from frontage.openings.borders.edges import FEW, Edge, EdgeTraits, Side, edge_beams, typical_gap
from frontage.openings.borders.scores import STRAY, blurred_scores, correlated, side_scores
from frontage.openings.boxes import Box
from frontage.openings.wall.crossings import CrossingBeams

_STEP = 0.0005  # m, step of the posterior
_FLOOR = 0.0005  # m: reveals are uneven by 1 mm, the mean of a side by half as much
_COARSE = 0.005  # m, step and blur where no beam determines the place
_ROUGHLY = 10_000  # beams that are enough for the first rounds
_NEVER = 1e-300  # likelihood of the impossible
_TOLD = 5.0  # nats that a border must gain for its place to be known
_SURE = float(np.log(100.0))  # nats that it must gain over no border to be seen beyond doubt
_OUTLIER = 0.05  # share of supposed reveals that are something else
CLOSE = 0.4
"""m around an opening within which beams determine its borders."""

WIDTHS = (0.001, 0.002, 0.003, 0.0045, 0.007)
"""m, blurs of edges that are tried: one sigma of a beam's footprint."""


@dataclass(frozen=True, eq=False)
class Border:
    """A border of an opening.

    at      m, place along its axis
    sigma   m, standard error of the place
    gain    nats, log-likelihood over no border at all
    edge    the beams that determine it
    scores  (k,) log-evidence for every blur of `WIDTHS`, where it was asked for
    """

    at: float
    sigma: float
    gain: float
    edge: Edge
    scores: Float

    @property
    def is_seen(self) -> bool:
        """Whether it is seen beyond doubt: a hundred times likelier than no border."""
        return self.gain > _SURE

    @property
    def is_hidden(self) -> bool:
        """Whether something before the wall stopped the beams on its open side."""
        return is_hidden(self.edge)


def is_hidden(edge: Edge) -> bool:
    """Returns whether something before the wall stopped the beams on the open side of an edge."""
    return len(edge.stopped) > 0 and len(edge.opened) < FEW


def find_borders(
    near: CrossingBeams,
    rough: Box,
    *,
    cell: float,
    rise: float,
    frame: float | None,
    spacing: float,
    traits: EdgeTraits,
    loose: bool = False,
) -> tuple[Box, list[Border]]:
    """Locates the four borders of a box, in rounds, for each needs the others.

    cell    m, how well `rough` is known
    rise    m, height of the head above the end of the sides (0 = straight)
    frame   m, depth of the frame, None where it is unknown
    traits  what the edges of the facade share
    loose   whether what stands before the wall beside the opening may begin off its edge

    Returns the box and its borders left, right, bottom, top.
    """
    x0, z0, x1, z1 = rough
    borders: list[Border] = []
    quick, few = replace(traits, all_blurs=False), near.thinned(_ROUGHLY)
    rounds = [max(0.12, 2.0 * cell), max(0.06, 1.5 * cell), max(0.04, 1.5 * spacing)]
    if cell <= spacing:  # a known place needs no wide search
        del rounds[0]
    for number, band in enumerate(rounds, 1):
        now, part = (traits, near) if number == len(rounds) else (quick, few)
        wide, high = (x1 - x0) / 2, (z1 - z0) / 2
        side = (z0, max(z1 - rise, z0 + 0.2 * (z1 - z0)))
        sides = ((0, 1, x0, wide, side), (0, -1, x1, wide, side), (1, 1, z0, high, (x0, x1)))
        borders = []
        for axis, sign, at, inner, across in (*sides, (1, -1, z1, high, (x0, x1))):
            least = min(band, inner)
            one = Side(axis, sign, at, inner, 2 * least, across, axis == 0 and loose)
            last = number == len(rounds)
            borders.append(locate(part, one, now, band=least, frame=frame, spacing=spacing, last=last))
        x0, x1, z0 = (b.at for b in borders[:3])
        z1 = borders[3].at if rise == 0.0 else z1
    return (x0, z0, x1, z1), borders


def locate(
    near: CrossingBeams,
    side: Side,
    traits: EdgeTraits,
    *,
    band: float,
    frame: float | None,
    spacing: float,
    last: bool = True,
) -> Border:
    """Locates the border at an edge, searching within `band` m to either side of it.

    Only in the `last` round its sigma tells where it may lie if no beam tells it.
    """
    edge = edge_beams(near, side, frame, traits)
    asked = WIDTHS if traits.all_blurs else ()
    unseen = partial(_unseen, near, side, traits, frame=frame, spacing=spacing) if last else _unasked
    if len(edge.solid) < 3:
        return Border(side.at, unseen(0.0), 0.0, edge, np.zeros(len(asked)))
    half = round(band / _STEP)
    e: Float = np.arange(-half, half + 1, dtype=np.float64) * _STEP
    strays = _strays(edge, -band / 2)
    due, reveal = _absences(edge, side.reach, spacing, e, strays), _reveal(edge.reveal, e)
    scores = reveal + _edge_scores(edge, e, (traits.blur, *asked), strays, due)
    best = scores.max(1)
    p = np.exp(scores - best[:, None])
    total = p.sum(1)
    p = p[0] / total[0]
    mean = float(p @ e)
    sigma = float(np.hypot(np.sqrt(p @ (e - mean) ** 2), _FLOOR))
    gain = float(best[0] - max(scores[0, 0], scores[0, -1]))
    if is_hidden(edge):
        mean, gain = 0.0, 0.0
    if gain < _TOLD:
        sigma = max(sigma, unseen(mean))
    return Border(side.at + side.sign * mean, sigma, gain, edge, best[1:] + np.log(total[1:]))


def _unasked(_: float) -> float:
    """Returns nothing instead of the error of a border that no beam tells."""
    return 0.0


def _edge_scores(
    edge: Edge, e: Float, blurs: Sequence[float], strays: tuple[float, float], due: Float
) -> Float:
    """Returns the log-likelihood (b, k) of borders at e m by the beams, also by the missing ones (`due`).

    There is one for every blur (b,) m. Beams that the face of the edge hides err together, by the errors of
    the face's depth and of the footprint: the likelihood of all of them is blurred by that. Where other beams
    determine the border, they determine these errors too.
    """
    share = (len(edge.hidden[0]) + len(edge.hidden[1])) / max(len(edge.solid) + len(edge.opened), 1)
    hidden, seen = blurred_scores((edge.hidden, edge.seen), e, blurs, strays).transpose(1, 0, 2)
    hidden = hidden + share * due
    n = int(4.0 * edge.shift / _STEP)
    if n > 0 and share > 0.0:
        lag = np.arange(-n, n + 1) * (_STEP / edge.shift)
        kernel = np.exp(-0.5 * lag**2)
        kernel /= kernel.sum()
        best = hidden.max(1, keepdims=True)
        p = np.exp(hidden - best)
        ends = (np.repeat(p[:, k : k + 1], n, 1) for k in (0, len(e) - 1))
        p = correlated(np.hstack([next(ends), p, next(ends)]), kernel)
        hidden = np.log(np.maximum(p, _NEVER)) + best
    return np.asarray(hidden + seen + (1.0 - share) * due)


def _unseen(
    near: CrossingBeams, side: Side, traits: EdgeTraits, at: float, *, frame: float | None, spacing: float
) -> float:
    """Returns the root mean square distance m from `at` of a border that no beam tells.

    It lies anywhere between the wall outside and the opening inside, as far as they are seen.
    """
    reach = max(CLOSE, side.inner)
    edge = edge_beams(near, replace(side, reach=reach), frame, traits)
    e: Float = np.arange(-reach, side.inner, _COARSE)
    strays = _strays(edge, -side.inner / 2)
    score = _absences(edge, reach, spacing, e, strays)
    score += side_scores(edge.solid, edge.opened, e, _COARSE, strays)
    p = np.exp(score - score.max())
    return float(np.sqrt(p @ (e - at) ** 2 / p.sum()))


def _reveal(line: tuple[float, float] | None, e: Float) -> Float:
    """Returns the log-likelihood (k,) of borders at e m by the reveal's own points."""
    if line is None:
        return np.zeros(len(e))
    fit = np.exp(-0.5 * ((e - line[0]) / line[1]) ** 2) / (line[1] * np.sqrt(2 * np.pi))
    return np.asarray(np.log((1 - _OUTLIER) * fit + _OUTLIER / np.ptp(e)))


def _strays(edge: Edge, low: float) -> tuple[float, float]:
    """Returns the shares of an edge's solid and opened beams on the wrong side of the border, 1 to 90 %.

    Rooms behind a wall and bars in front of an opening are such. The solid side is below `low` m, the opened
    one as far on the other side.
    """
    below, above = (
        (int(u.searchsorted(low)), len(u) - int(u.searchsorted(-low, "right")))
        for u in (edge.solid, edge.opened)
    )
    return _stray(below[0], below[1]), _stray(above[1], above[0])


def _stray(own: int, wrong: int) -> float:
    """Returns the share of beams on the wrong side, 1 to 90 %."""
    return min(max(wrong / max(own, 1), STRAY), 0.9)


def _absences(edge: Edge, reach: float, spacing: float, e: Float, strays: tuple[float, float]) -> Float:
    """Returns the log-likelihood (k,) of borders at e m by missing beams where nothing hides the wall.

    Rasters are regular, so the width of the gaps between points counts, not the number of points.
    """
    fine, length = _all_free(reach)
    if len(edge.stopped):
        found = (edge.solid, edge.opened, edge.stopped)
        count = [np.diff(np.searchsorted(u, fine)).astype(np.float64) for u in found]
        total, stopped = ndimage.gaussian_filter1d(np.stack([sum(count), count[2]]), spacing / 0.002)
        length = _length(1.0 - stopped / np.maximum(total, 1e-9))
    before = np.interp(e, fine, length)
    # beyond a single row or column everything is empty up to the end
    solid = np.concatenate([[-reach], edge.solid[: edge.solid.searchsorted(0.0)]])
    opened = np.concatenate([edge.opened[edge.opened.searchsorted(0.0, "right") :], [reach]])
    # with unknown sensors, the shadow of the edge itself is empty behind it
    rates = 1.0 / _gap(solid, reach), 1.0 / _gap(opened, reach) if edge.rays else 0.0
    # strays are expected on the other side, too
    rates = rates[0] * (1.0 - strays[0]), rates[1] * (1.0 - strays[1])
    return np.asarray(-(rates[0] * before + rates[1] * (length[-1] - before)))


@lru_cache(maxsize=64)
def _all_free(reach: float) -> tuple[Float, Float]:
    """Returns places (n,) m every 2 mm up to `reach` m to either side, and the length m before each."""
    fine = np.arange(-reach, reach + 0.001, 0.002)
    return fine, _length(np.ones(len(fine) - 1))


def _length(free: Float) -> Float:
    """Returns the length (n + 1,) m that is free before every place, by the shares (n,) between them."""
    return np.concatenate([[0.0], np.cumsum(np.minimum(np.maximum(free, 0.0), 1.0)) * 0.002])


def _gap(u: Float, reach: float) -> float:
    """Returns half the width m of the gap that a random place lies in among rising points u (n,) m."""
    return max(typical_gap(u) / 2.0, _STEP) if len(u) > 1 and u[-1] > u[0] else reach
