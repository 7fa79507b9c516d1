"""Openings closed level with the wall: shutters and panes that only intensity or colour tell from it.

They are looked for only where the rows and columns of the other openings cross and wall was seen. There the
means of the points must step by the same amount on all four sides, sharply, where the borders are expected,
and be alike within. How large such steps are on this wall by itself, the wall tells.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from frontage.geometry.arrays import Bool, Float
from frontage.model.estimate import Estimate
from frontage.model.facade import Facade
from frontage.model.scan import Scan
from frontage.openings.beams import Beams
from frontage.openings.borders import Place
from frontage.openings.evidence import Evidence
from frontage.openings.inferred import Grid, Node, state_of
from frontage.openings.outline import Outline
from frontage.openings.reflectance import Channels, reflectances

_SIDES = 3  # of four that must be seen: sills hide the wall below an opening
_SURE = 0.99  # posterior that an opening needs
_PRIOR = 0.05  # share of the crossings seen as wall that hold a closed opening
_EXPECTED = 0.5  # nats (factor 1.6), one sigma of the step from wall to shutter
_UNEVEN = 0.3  # of the step, one sigma between the four sides
_LARGEST = 2.5  # nats, largest step that is tried
_TAILS = 4.0  # degrees of freedom of the wall's own steps: courses, repairs and stains have heavy tails
_ALIKE = 0.4  # of the step that thirds of the inside may differ from the whole
_SHARP = 0.6  # of the step that must happen within the nearest points
_SOME = 0.3  # of the step that a border which is not sharp must still show
_NEAR = 0.04  # m beside a border, or two spacings: its nearest points
_ENDS, _CROWN = 0.05, 0.35  # of a side that is left out at either end; of an arch's top
_FINE = 0.001  # m between tried places of a border
_SEARCH = 0.12  # m, furthest that a border is looked for from where it is expected
_BEST = 0.002  # m, one sigma of a border at least: gaps between leaf and wall
_FLUSH = 0.05  # m: what lies deeper is no flush opening
_FEW = 30  # points inside, and on each side of a border
_SLANT = 0.5  # of its depth that the wall's edge hides of a leaf, or shows of a reveal
_AROUND = (0.5, 0.2)  # m beside the opening, from and to: its wall, surrounds left out
_COMMON = 0.5  # of the noise of a point that its neighbours share


@dataclass(frozen=True, eq=False)
class Flush:
    """An opening that is closed level with the wall, its posterior probability, and its evidence, nats."""

    outline: Outline
    confidence: float
    evidence: float


def find_flush(
    facade: Facade, scan: Scan, beams: Beams, evidence: Evidence, outlines: Sequence[Outline]
) -> list[Flush]:
    """Closed openings where a row and a column of `outlines` cross and the wall was seen.

    None where the scan has neither intensity nor colour. Posterior: likelihood of the four steps against
    that of the wall's own steps, with a price for every crossing and every channel that was tried.
    """
    if (scan.intensity is None and scan.rgb is None) or len(outlines) < 3:
        return []
    nodes = [n for n in Grid(outlines).nodes() if state_of(n.place, outlines, evidence) == "wall"]
    if not nodes:
        return []
    channels = reflectances(facade, scan, beams, evidence.raster, _FLUSH)
    taken = [o.place for o in outlines] + [n.place for n in nodes]
    shortest = min(min(n.place[2] - n.place[0], n.place[3] - n.place[1]) for n in nodes)
    wall = channels.spread(shortest, taken)
    price = np.log(len(nodes) * len(channels.values) * (1.0 - _PRIOR) / _PRIOR)
    found: list[Flush] = []
    for node in nodes:
        told = _judged(node, outlines[node.like], channels, wall)
        if told is None or _posterior(told.evidence, float(price)) < _SURE:
            continue
        if state_of(told.outline.place, [f.outline for f in found], evidence) == "wall":
            found.append(replace(told, confidence=_posterior(told.evidence, float(price))))
    return found


def _posterior(gain: float, price: float) -> float:
    return float(1.0 / (1.0 + np.exp(price - gain)))


def _judged(node: Node, like: Outline, channels: Channels, wall: Float) -> Flush | None:
    """The opening at a node by the channel that tells it best, None where none does.

    wall (c,) is one sigma of the wall's own steps.
    """
    steps = channels.steps(node.place)
    gains = [_gain(own, float(w)) for own, w in zip(steps, wall, strict=True)]
    for k in np.argsort(gains)[::-1]:
        if not np.isfinite(gains[k]) or gains[k] <= 0.0:
            return None
        outline = _outlined(node, like, channels, int(k), steps[k], float(wall[k]))
        if outline is not None:
            return Flush(outline, 0.0, float(gains[k]))
    return None


def _gain(own: Float, wall: float) -> float:
    """Nats for one common step on the four sides `own` (4,) against steps of the wall, one sigma `wall`."""
    own = own[np.isfinite(own)]
    if len(own) < _SIDES or not wall > 0.0:
        return -np.inf
    step = np.linspace(-_LARGEST, _LARGEST, 501)
    sigma = np.hypot(wall, _UNEVEN * step)[:, None]
    each = np.asarray(stats.norm.logpdf(own[None, :], step[:, None], sigma)).sum(1)
    prior = stats.norm.logpdf(step, 0.0, _EXPECTED) + np.log(step[1] - step[0])
    open_ = float(np.logaddexp.reduce(each + prior))
    return open_ - float(np.sum(stats.t.logpdf(own, _TAILS, 0.0, wall)))


def _outlined(
    node: Node, like: Outline, channels: Channels, k: int, own: Float, wall: float
) -> Outline | None:
    """The outline with measured borders and depth; None where it is not like an opening.

    Left, right and one of bottom and top are sharp; the other (a sill, the crown of an arch) need not be, and
    stays where it is expected. The inside is even, and level with the wall.
    """
    place, covariance = list(node.place), node.covariance.copy()
    step = float(np.nanmean(own))
    sharp = np.zeros(4, np.bool_)
    for side in range(4):
        row = (0, 2, 1, 3)[side]
        expected = float(np.sqrt(covariance[row, row]))
        some, u = _across(channels, node.place, side, like.rise)
        jump = step if side < 2 else -step
        border = _border(u[some], channels.values[k][some], expected, jump, wall, channels.spacing)
        if border is not None:
            sharp[side] = True
            place[side] += border[0]
            covariance[row, :] = covariance[:, row] = 0.0
            covariance[row, row] = border[1] ** 2
        elif own[side] / step < _SOME:
            return None
    at: Place = (place[0], place[1], place[2], place[3])
    depth = _depth(channels, at, like.rise)
    if depth is None or not (sharp[0] and sharp[2] and sharp[1::2].any()):
        return None
    if abs(depth.value) > _FLUSH or not _even(channels, k, at, like.rise, step):
        return None
    covariance[:4, :4] += np.eye(4) * (_SLANT * depth.value) ** 2
    return Outline(like.shape, at, like.rise, covariance, (), depth, 0.0, like.wall)


def _across(channels: Channels, place: Place, side: int, rise: float) -> tuple[Bool, Float]:
    """Which points (n,) lie along a side of a box, and all points' distance (n,) m across it."""
    x0, z0, x1, z1 = place
    axis = side % 2
    begin, end = (z0, z1 - rise) if axis == 0 else (x0, x1)
    margin = (_CROWN if side == 3 and rise > 0.0 else _ENDS) * (end - begin)
    along = channels.xz[:, 1 - axis]
    u = channels.xz[:, axis] - place[side]
    return (along > begin + margin) & (along < end - margin) & (np.abs(u) < 2.0 * _SEARCH), u


def _border(
    u: Float, v: Float, expected: float, step: float, wall: float, spacing: float
) -> tuple[float, float] | None:
    """Place m (from where it is expected) and sigma m of the step of values v (n,) over u (n,) m; None where
    the step is not sharp.

    Two means on either side; their likelihood over the place of the step, its exponent as much smaller as
    means on this wall scatter more than its single points let expect.
    """
    search = float(np.clip(3.0 * expected, _SEARCH / 3.0, _SEARCH))
    order = np.argsort(u, kind="stable")
    u, v = u[order], v[order]
    e = np.arange(-search, search, _FINE)
    cut = np.searchsorted(u, e)
    if len(u) == 0 or min(cut[0], len(u) - cut[-1]) < _FEW // 3:
        return None
    total = np.append(0.0, v.cumsum())
    rest = float(v @ v) - total[cut] ** 2 / cut - (total[-1] - total[cut]) ** 2 / (len(u) - cut)
    best = max(float(rest.min()) / len(u), 1e-9)
    share = min(1.0, 4.0 * best / len(u) / wall**2)
    log_l = -0.5 * share * (rest - rest.min()) / best - 0.5 * (e / np.hypot(expected, _BEST)) ** 2
    weight = np.exp(log_l - log_l.max())
    weight /= weight.sum()
    mean = float(weight @ e)
    # the nearest points, ten at least: scan columns may leave a gap beside the border
    first, middle, last = np.searchsorted(u, mean + np.array([-1.0, 0.0, 1.0]) * max(2.0 * spacing, _NEAR))
    before, after = (
        v[min(first, max(middle - _FEW // 3, 0)) : middle],
        v[middle : max(last, middle + _FEW // 3)],
    )
    if (after.mean() - before.mean()) / step < _SHARP:
        return None
    return mean, float(np.sqrt(weight @ (e - mean) ** 2 + _BEST**2))


def _even(channels: Channels, k: int, place: Place, rise: float, step: float) -> bool:
    """Whether the thirds of the inside, across and up, are alike in the channel k."""
    x0, z0, x1, z1 = place
    edges_x, edges_z = np.linspace(x0, x1, 4), np.linspace(z0, z1 - rise, 4)
    inside = channels.within(place)
    column = np.clip(np.searchsorted(edges_x, channels.xz[inside, 0]) - 1, 0, 2)
    row = np.clip(np.searchsorted(edges_z, channels.xz[inside, 1]) - 1, 0, 2)
    number = np.bincount(3 * row + column, minlength=9)
    if number.min() < _FEW // 9 + 1:
        return False
    mean = np.bincount(3 * row + column, channels.values[k][inside], minlength=9) / number
    return bool(np.abs(mean - np.median(mean)).max() < _ALIKE * abs(step))


def _depth(channels: Channels, place: Place, rise: float) -> Estimate[float] | None:
    """Depth m of what closes the opening behind the wall around it, None where few points tell."""
    x0, z0, x1, z1 = place
    inside = channels.within((x0 + 0.03, z0 + 0.03, x1 - 0.03, z1 - rise - 0.03))
    far, near = _AROUND
    around = channels.within((x0 - far, z0 - far, x1 + far, z1 + far))
    around &= ~channels.within((x0 - near, z0 - near, x1 + near, z1 + near))
    if min(inside.sum(), around.sum()) < _FEW:
        return None
    value, variance = [], 0.0
    for some in (inside, around):
        y = channels.depth[some]
        value.append(float(np.median(y)))
        noise = 1.4826 * float(np.median(np.abs(y - value[-1])))
        variance += noise**2 * (_COMMON**2 + 1.57 / len(y))
    return Estimate(value[0] - value[1], np.array([[variance]]), float(inside.sum() - 1))
