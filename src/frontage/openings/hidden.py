"""The foot of an opening that something hides: where it can be, and what kind of opening it makes.

A car before a wall hides where a door or window ends below. The kind of an opening follows from its foot,
so it must be judged over all places that the foot may have:

    p(foot, kind) ~ p(foot) p(beams | foot) p(leaf, size | kind),

where the kind follows from the foot (`kind_of`). Before anything is seen, the foot is that of a door, on the
ground; or a sill of the row of windows beside it; or anywhere. The rows of cells that beams reached tell
where it is not: those that something hides tell nothing, so that nothing speaks against a door that reaches
the ground. Then the leaf tells. A door is closed by wood and returns the beams from its own depth, a window
lets them pass; and windows of a row share their width and depth, which a door need not have.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import beta, norm

from frontage.geometry.arrays import Float
from frontage.model.opening import DOORS, OpeningKind
from frontage.openings.borders.outline import Outline
from frontage.openings.kinds import kind_of
from frontage.openings.layout.forms import is_known
from frontage.openings.wall.crossings import CrossingBeams
from frontage.openings.wall.evidence import Evidence

_UNKNOWN = 0.1  # m: a foot known no better tells no kind
_BELOW = 0.3  # m below the foot as far as it is known, where what hides it must show
_HIDDEN = 0.5  # share of the beams that must not have reached the wall there
_STEP = 0.01  # m, of the places of a foot
_THRESHOLD = (0.1, 0.25)  # m, mean and sigma of the foot of a door above the lowest ground of the facade
_SILL = 0.05  # m, one sigma of the sills of a row
_PRIOR = (0.4, 0.4, 0.2)  # of a door, of a sill of the row, and of any other place
_DOOR_HIGH, _WINDOW_HIGH = (np.log(2.3), 0.2), (np.log(1.7), 0.3)  # m, log-normal; doors with a light above
_HIGHEST = float(np.exp(norm.ppf(0.99, *_DOOR_HIGH)))  # m above the ground: 99 % of all doors end below it
_MOST = 6.0  # nats of a row of cells at most: they err together
_WALLED = 0.25  # share of a row of cells that shows wall, at least, where there is one
_LEAF = 0.05  # m about the front of the frame: panels and boards of a leaf
_SAME = 0.03  # m, one sigma of widths and depths of a row
_ODD = 0.3  # share of the windows of a row that are unlike the others
_SPAN = (1.5, 0.4)  # m, of the widths and of the depths of whatever is unlike
_OPAQUE, _CLEAR = (8.0, 1.5), (2.0, 5.0)  # beta distributions of the share that a leaf and a pane return
_GLAZED, _SHUT = 0.3, 0.1  # shares of the doors that are glazed, and of the windows with shutters or blinds


@dataclass(frozen=True, eq=False)
class HiddenFoot:
    """Where the foot of an opening can be, and what that makes of it.

    kind    the likeliest kind
    chance  its probability
    at      m, mean of its places z given that kind
    sigma   m, root mean square distance from `at` of all places, those of the other kinds included
    """

    kind: OpeningKind
    chance: float
    at: float
    sigma: float


def is_foot_hidden(outline: Outline, evidence: Evidence, ground: float) -> bool:
    """Returns whether something before the wall hides where an opening of the ground floor ends below."""
    x0, z0, x1, z1 = outline.place
    unknown = float(np.sqrt(outline.covariance[2, 2])) > _UNKNOWN
    if not outline.borders or outline.borders[2].is_seen or not unknown or z1 - ground > _HIGHEST:
        return False
    low, high, *columns = _cells(evidence, (z0 - _BELOW, z0), (x0, x1))
    part = slice(low, max(high, low + 1)), slice(*columns)
    return float(evidence.expected[part].sum()) < _HIDDEN * float(evidence.expected_free[part].sum())


def is_foot_unknown(outline: Outline, others: Sequence[Outline], evidence: Evidence, ground: float) -> bool:
    """Returns whether the foot of an opening must be judged, for the beams do not tell it.

    Where the lines of sight are unknown, nothing tells what hides a foot, so that every foot counts that may
    be a door's and is neither seen nor known to a tenth of the height. Unless it is known well, wall must
    show below it: the facade may end there only because something hides the rest.
    """
    if evidence.rays or not outline.borders:
        return is_foot_hidden(outline, evidence, ground)
    well = float(np.sqrt(outline.covariance[2, 2])) <= _UNKNOWN
    known = bool(is_known(outline)[2]) and (well or _shows_wall_below(outline, evidence))
    told = outline.borders[2].is_seen or known
    above = outline.place[3] - ground
    return not told and 2.0 * _STEP < above < _HIGHEST * np.exp(_scale(_row(outline, others)))


def _shows_wall_below(outline: Outline, evidence: Evidence) -> bool:
    """Returns whether any row of cells below an opening shows wall."""
    x0, z0, x1, _ = outline.place
    low, high, *columns = _cells(evidence, (evidence.raster.corner[1], z0), (x0, x1))
    part = slice(low, high), slice(*columns)
    return bool(((evidence.seen[part] & (evidence.llr[part] < 0.0)).mean(1) >= _WALLED).any())


def _row(outline: Outline, others: Sequence[Outline]) -> list[Outline]:
    """Returns those of the other openings that stand beside an opening by more than half of their heights."""
    _, z0, _, z1 = outline.place
    beside = [min(o.place[3], z1) - max(o.place[1], z0) for o in others]
    return [o for o, high in zip(others, beside, strict=True) if high > 0.5 * (o.place[3] - o.place[1])]


def _scale(row: Sequence[Outline]) -> float:
    """Returns the logarithm of the factor by which the openings of a row are higher than usual windows."""
    heights = [o.place[3] - o.place[1] for o in row]
    return max(float(np.log(np.median(heights))) - _WINDOW_HIGH[0], 0.0) if heights else 0.0


def lowest_foot(outline: Outline, others: Sequence[Outline], ground: float) -> float:
    """Returns the height z m that no foot lies below: the ground, or the highest opening under this one."""
    x0, z0, x1, z1 = outline.place
    under = [o.place for o in others if o.place[0] < x1 and o.place[2] > x0]
    return max([ground, *(p[3] for p in under if p[1] + p[3] < z0 + z1 and p[3] < 0.5 * (z0 + z1))])


def judge_foot(
    outline: Outline,
    others: Sequence[Outline],
    beams: CrossingBeams,
    evidence: Evidence,
    ground: float,
    lowest: float,
) -> HiddenFoot:
    """Returns the likeliest kind of an opening with a hidden foot, and its foot under that kind.

    `others` are the openings of the wall whose feet are known, `ground` m is the height z of the ground, and
    `lowest` m the height that the foot does not lie below.
    """
    x0, z0, x1, z1 = outline.place
    row = _row(outline, others)
    foot = np.arange(lowest, 0.5 * (max(z0, lowest) + z1), _STEP)
    kinds = np.array([kind_of(x1 - x0, z1 - z, z - ground, outline.passes) for z in foot])
    door = np.isin(kinds, list(DOORS))
    nats = np.log(_prior(foot, z1, row, ground)) + _seen(foot, outline, evidence)
    nats += np.where(door, *_leaf(outline, row, _returned(outline, beams)))
    share = np.exp(nats - nats.max())
    share /= share.sum()
    chances = {kind: float(share[kinds == kind].sum()) for kind in dict.fromkeys(kinds.tolist())}
    best = max(chances, key=lambda kind: chances[kind])
    own = np.where(kinds == best, share, 0.0) / chances[best]
    at = float(own @ foot)
    sigma = float(np.hypot(np.sqrt(share @ (foot - at) ** 2), _STEP))
    return HiddenFoot(OpeningKind(best), chances[best], at, sigma)


def _prior(foot: Float, top: float, row: Sequence[Outline], ground: float) -> Float:
    """Returns the density (k,) of the places of a foot before anything of it is seen.

    Where the openings of the row are higher than windows are in general, doors are as well.
    """
    scale = _scale(row)
    door_high, window_high = (
        norm.pdf(np.log(top - foot), middle + scale, spread) for middle, spread in (_DOOR_HIGH, _WINDOW_HIGH)
    )
    door = norm.pdf(foot - ground, *_THRESHOLD) * door_high
    even = window_high / max(np.ptp(foot), _STEP)
    sills = [norm.pdf(foot, o.place[1], np.hypot(_SILL, np.sqrt(o.covariance[2, 2]))) for o in row]
    parts = (door, np.mean(sills, axis=0) * window_high if sills else even, even)
    return np.asarray(sum(w * p for w, p in zip(_PRIOR, parts, strict=True)))


def _seen(foot: Float, outline: Outline, evidence: Evidence) -> Float:
    """Returns the log-likelihood (k,) of the beams for every place of the foot, up to a constant.

    A row of cells above the foot is open and one below it is wall; hidden cells tell nothing. Where the lines
    of sight are unknown, empty cells may be a shadow: all of them err together. A row that is mostly empty is
    no wall then, whatever stands in it: a post, a person.
    """
    x0, _, x1, z1 = outline.place
    raster = evidence.raster
    low, high, *columns = _cells(evidence, (foot[0], z1), (x0, x1))
    part = slice(low, high), slice(*columns)
    told, seen = evidence.llr[part], evidence.seen[part] | evidence.rays
    rows = np.clip(np.where(seen, told, 0.0).sum(1), -_MOST, _MOST)
    rows = np.where(seen.mean(1) < _WALLED, np.maximum(rows, 0.0), rows)
    empty = np.where(seen, 0.0, told).sum(1)
    rows += empty * min(1.0, _MOST / max(float(empty.sum()), 1e-9))
    above = np.append(np.cumsum(rows[::-1])[::-1], 0.0)  # nats of all rows from one upwards
    at = (foot - raster.corner[1]) / raster.cell - low
    return np.asarray(np.interp(at, np.arange(len(above)), above))


def _cells(evidence: Evidence, z: tuple[float, float], x: tuple[float, float]) -> tuple[int, int, int, int]:
    """Returns the rows [r0, r1) and the columns [c0, c1) between heights z and places x in m.

    The outermost column on either side is left out.
    """
    corner, cell, (h, w) = evidence.raster.corner, evidence.raster.cell, evidence.raster.shape
    r0, r1 = (min(max(round((v - corner[1]) / cell), 0), h) for v in z)
    c0, c1 = (min(max(round((v - corner[0]) / cell), 0), w) for v in x)
    return r0, r1, min(c0 + 1, c1 - 1), max(c1 - 1, c0 + 1)


def _returned(outline: Outline, beams: CrossingBeams) -> float:
    """Returns the share of the beams into an opening that come back from the depth of its frame."""
    x0, z0, x1, z1 = outline.place
    if outline.depth is None:
        return 0.5
    near = beams.around((x0, z0, x1, z1 - outline.rise), 0.0)
    y = near.depth + near.level - (outline.wall or 0.0)
    own = np.abs(y - float(outline.depth.value)) < _LEAF
    into = near.depth > near.wall
    return float((own & into).sum() + 1.0) / float(into.sum() + 2.0)


def _leaf(outline: Outline, row: Sequence[Outline], returned: float) -> tuple[float, float]:
    """Returns the log-likelihoods of the leaf of an opening: as a door, and as a window."""
    share = float(np.clip(returned, 0.01, 0.99))
    leaf, pane = (float(beta.pdf(share, *shape)) for shape in (_OPAQUE, _CLEAR))
    door = np.log((1.0 - _GLAZED) * leaf + _GLAZED * pane)
    window = np.log((1.0 - _SHUT) * pane + _SHUT * leaf)
    width = outline.place[2] - outline.place[0]
    depths = [float(o.depth.value) for o in row if o.depth is not None]
    measured = [(width, [o.place[2] - o.place[0] for o in row], _SPAN[0])]
    if outline.depth is not None:
        measured.append((float(outline.depth.value), depths, _SPAN[1]))
    for own, like, span in measured:
        if like:
            same = float(np.mean(norm.pdf(own, np.array(like), _SAME)))
            window += np.log((1.0 - _ODD) * same + _ODD / span)
            door -= np.log(span)
    return float(door), float(window)
