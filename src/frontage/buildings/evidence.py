"""What speaks for a party wall at a place of a front: the cues, each with its size in standard errors.

Two sides are compared in every channel of the profile. A step of the wall's plane counts only where it runs
from the foot to the eaves: what starts above the ground floor or ends below the roof is a bay or an oriel.
"""

from dataclasses import dataclass

import numpy as np

from frontage.buildings.profile import BIN, Profile
from frontage.buildings.signals import FLOOR, sharpest
from frontage.geometry.arrays import Float

STEP = {"eaves": 0.4, "offset": 0.05, "rough": 0.015, "colour": 6.0, "bright": 0.2}
SURE = 4.0  # standard errors from which a cue speaks for itself
HINT = 3.0  # standard errors from which a cue confirms another
_LOW_STEP = 0.5  # share of an eaves step that parts houses alone, from which it confirms another cue
_REACH = 24  # bins (6 m): how far from a cut its two sides are compared
_NEAR = 8  # bins (2 m): the same for eaves and offset, which drift
_STEEP = 0.02  # of a wall's height: seen steeply from the street, a cornice's depth moves the top it shows
_UPRIGHT = 0.75  # share of the height through which a step of the plane must run
_CROWN = 12  # bins (3 m) below the eaves: cornice, frieze and the uppermost lintels
_MOULDED = 0.04  # m, spread of the relief over them from which it tells something
_SAME = 0.8  # correlation of the relief on both sides of a cut that shows one cornice
_LEFT_OVER = 0.5  # share of the higher side's wall that the lower side may show above its eaves
_UNLIKE = 0.5  # mean square difference of levelled row profiles: a correlation of 3/4
_EXACT = 0.02  # the least of two halves of one side
_PROUD = 0.05  # m, a step of the plane at one height

Side = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Look:
    """What cuts are judged by: channels (n, p), their sampling errors (n, p), open gaps, cell m."""

    profile: Profile
    signal: Float
    kinds: list[str]
    sampling: Float
    gaps: list[tuple[int, int]]
    cell: float

    def sides(self, cuts: list[int], i: int) -> tuple[Side, Side]:
        """The bins [lo, c) and [c, hi) beside cut i, up to its neighbours."""
        return (
            (cuts[i - 1] if i else 0, cuts[i]),
            (cuts[i], cuts[i + 1] if i + 1 < len(cuts) else len(self.profile)),
        )


@dataclass(frozen=True)
class Verdict:
    """The cues for a cut, whether they suffice, and the log-odds for it."""

    cues: tuple[str, ...]
    convincing: bool
    odds: float


def settled(look: Look, cuts: list[int], cues: list[tuple[str, ...]], width: int) -> list[int]:
    """Cuts moved to the step of the channels that speak for each; pieces stay at least `width` bins wide."""
    names = [cue_of(kind) for kind in look.kinds]
    floor = np.array([FLOOR[kind] for kind in look.kinds])
    sigma = np.sqrt(np.nan_to_num(within(look, cuts)) ** 2 + floor**2 + look.sampling**2)
    tells = [np.array([name in own for name in names]) for own in cues]
    return [int(c) for c in sharpest(look.signal, sigma, np.array(cuts, np.int64), width, tells)]


def judge(look: Look, cuts: list[int], i: int) -> Verdict:
    """The verdict on cut i among its neighbours: an eaves step or a gap convinces alone, any other cue needs
    a second one."""
    left, right = look.sides(cuts, i)
    cues, alone = compare(look, left, right, within(look, cuts))
    if any(a <= cuts[i] <= b for a, b in look.gaps):
        cues["gap"], alone = 9.0, True
    convincing = alone or (len(cues) >= 2 and max(cues.values()) > SURE)
    odds: float = sum(min(t * t / 2, 12.0) - 4.0 for t in cues.values()) - 2.0
    return Verdict(tuple(sorted(cues)), convincing, float(np.clip(odds, -20, 20)))


def compare(look: Look, left: Side, right: Side, spread: Float) -> tuple[dict[str, float], bool]:
    """Cues (name: standard errors) that part two sides, and whether a step of the eaves suffices alone.

    spread (p,): of every channel within a house.
    """
    cues: dict[str, float] = {}
    alone, tall = False, look.profile.rows.shape[1] * BIN
    for k, kind in enumerate(look.kinds):
        step, t = difference(look, k, left, right, spread[k])
        least = max(STEP[kind], _STEEP * tall) if kind == "eaves" else STEP[kind]
        if t > SURE and abs(step) > least:
            alone |= kind == "eaves" and not _cornice_goes_on(look, left, right)
        elif kind == "eaves":
            least *= _LOW_STEP
        if t > HINT and abs(step) > least and (kind != "offset" or _upright(look, left, right, step)):
            name = cue_of(kind)
            cues[name] = max(cues.get(name, 0.0), t)
    t = _rhythm(look.profile.rows[_last(left, 2 * _REACH)], look.profile.rows[_first(right, 2 * _REACH)])
    if t > HINT:
        cues["rhythm"] = t
    return cues, alone


def cue_of(kind: str) -> str:
    """The cue that a kind of channel gives: colour and intensity see the same paint."""
    return "surface" if kind in ("colour", "bright") else kind


def difference(look: Look, k: int, left: Side, right: Side, spread: float) -> tuple[float, float]:
    """Step of channel k from the left to the right side, and its size in standard errors."""
    kind = look.kinds[k]
    floor = max(FLOOR[kind], look.cell / 4) if kind == "eaves" else FLOOR[kind]
    reach = _NEAR if kind == "offset" else _REACH
    own = max(spread, floor) if np.isfinite(spread) else floor
    step, t = _step(look, k, _last(left, reach), _first(right, reach), own)
    if kind == "eaves":  # a step, not a slope: it stands close to the cut as well as far from it
        close, _ = _step(look, k, _last(left, _NEAR), _first(right, _NEAR), floor)
        step, t = (float(np.sign(step)) * min(abs(step), abs(close)), t) if step * close > 0 else (0.0, 0.0)
        if not _free_above(look, left, right):
            return 0.0, 0.0
    return step, t


def within(look: Look, cuts: list[int]) -> Float:
    """Robust spread (p,) about the medians of the segments between cuts, in the better measured half of the
    bins: how scarcely the others were measured is known apart."""
    residual = [part - _median(part) for part in np.split(look.signal, cuts) if len(part)]
    count = look.profile.count
    return 1.4826 * _median(np.abs(np.concatenate(residual))[count >= np.median(count)])


def _last(side: Side, reach: int) -> slice:
    return slice(max(side[0], side[1] - reach), side[1])


def _first(side: Side, reach: int) -> slice:
    return slice(side[0], min(side[1], side[0] + reach))


def _median(a: Float) -> Float:
    """Median over the bins (p,), NaN for a channel without measurement."""
    n, column = np.isfinite(a).sum(0), np.arange(a.shape[1])
    if not len(a):
        return np.full(a.shape[1], np.nan)
    ordered = np.sort(a, axis=0)  # NaN last
    below, above = np.maximum(n - 1, 0) // 2, np.minimum(n // 2, len(a) - 1)
    return np.where(n > 0, 0.5 * (ordered[below, column] + ordered[above, column]), np.nan)


def _step(look: Look, k: int, left: slice, right: slice, spread: float) -> tuple[float, float]:
    """Step of channel k between the medians of two stretches, and its size in standard errors; bins
    within 1 m are one observation, and each side adds what its sampling leaves open."""
    medians, variance, per = [], 0.0, 1.0 / BIN
    for part in (left, right):
        known = np.isfinite(look.signal[part, k])
        side, sampling = look.signal[part, k][known], look.sampling[part, k][known]
        if len(side) < 4:
            return 0.0, 0.0
        medians.append(float(np.median(side)))
        ragged = 1.4826 * float(np.median(np.abs(side - medians[-1])))  # a ragged side proves nothing
        variance += (
            (max(spread, ragged) ** 2 + float(np.nan_to_num(np.median(sampling))) ** 2) * per / len(side)
        )
    step = medians[1] - medians[0]
    return step, abs(step) / float(np.sqrt(variance))


def _upright(look: Look, left: Side, right: Side, step: float) -> bool:
    """Whether a step of the plane runs through the whole height that both sides measured."""
    relief = look.profile.relief
    at_height = _median(relief[_first(right, _NEAR)]) - _median(relief[_last(left, _NEAR)])
    at_height = at_height[np.isfinite(at_height)] * np.sign(step)
    return len(at_height) < 3 or bool(np.mean(at_height > max(_PROUD, 0.5 * abs(step))) >= _UPRIGHT)


def _free_above(look: Look, left: Side, right: Side) -> bool:
    """Whether the lower side is empty where the higher one still has wall.

    Between galleries, dormers and badly seen storeys the recognised wall ends here higher and there lower,
    but above it the house goes on.
    """
    profile = look.profile
    parts = _last(left, _REACH), _first(right, _REACH)
    tops = [_median(profile.top[part, None])[0] for part in parts]
    if not np.isfinite(tops).all():
        return True
    first, last = sorted(int((top - profile.base) / BIN) + 1 for top in tops)
    full = [np.isfinite(profile.relief[part, first:last]) for part in parts]
    if not full[0].size:
        return True
    low, high = (full[i].mean() for i in np.argsort(tops))
    return bool(low < _LEFT_OVER * high)


def _cornice_goes_on(look: Look, left: Side, right: Side) -> bool:
    """Whether the relief under the lower eaves is the same on both sides: then what rises above one of them
    is a railing or a parapet (or was measured there only), and no neighbour's wall."""
    profile = look.profile
    parts = _last(left, _NEAR), _first(right, _NEAR)
    tops = [_median(profile.top[part, None])[0] for part in parts]
    if not np.isfinite(tops).all():
        return False
    last = int((min(tops) - profile.base) / BIN) + 1
    rows = slice(max(0, last - _CROWN), max(0, last))
    a, b = (_median(profile.relief[part, rows]) for part in parts)
    known = np.isfinite(a) & np.isfinite(b)
    if known.sum() < _CROWN // 2 or min(np.std(a[known]), np.std(b[known])) < _MOULDED:
        return False
    return bool(np.corrcoef(a[known], b[known])[0, 1] > _SAME)


def _rhythm(a: Float, b: Float) -> float:
    """How differently the openings of two sides (k, r) stand in height, in spreads of their own halves."""
    if min(len(a), len(b)) < 12:
        return 0.0
    above = [np.cumsum(x.mean(0)[::-1])[::-1] for x in (a, b)]
    both = np.minimum(*above) > 0.2  # below both eaves
    if both.sum() < 8:
        return 0.0
    half = [
        _levelled(x.mean(0)[both])
        for x in (a[: len(a) // 2], a[len(a) // 2 :], b[: len(b) // 2], b[len(b) // 2 :])
    ]
    between = float(np.mean((_levelled(a.mean(0)[both]) - _levelled(b.mean(0)[both])) ** 2))
    own = 0.5 * float(np.mean((half[0] - half[1]) ** 2) + np.mean((half[2] - half[3]) ** 2))
    return float(np.sqrt(between / max(own, _EXACT)) * 2.0) if between > _UNLIKE else 0.0


def _levelled(share: Float) -> Float:
    """A row profile (r,) without the level and the contrast that only the density of the points gives it."""
    spread = float(np.std(share))
    return (share - share.mean()) / spread if spread > 0 else np.zeros_like(share)
