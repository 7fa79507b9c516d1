"""Where a row of houses is cut: change points of the profile, kept when independent cues agree.

One signal never cuts on its own, except a step of the eaves or an open gap: a bay moves the plane,
a shop front
changes the colour, a stair the rhythm, and all of it within one house.
"""

from dataclasses import dataclass

import numpy as np

from frontage.buildings.options import BuildingOptions
from frontage.buildings.profile import BIN, Profile
from frontage.buildings.signals import FLOOR, noise_of, sampling_of, sharpest, signals
from frontage.geometry.arrays import Bool, Float, Int
from frontage.solve.segmentation import change_points

_STEP = {"eaves": 0.4, "offset": 0.05, "rough": 0.015, "colour": 6.0, "bright": 0.2}
_WITNESSES = 3  # parameters a cut is charged for: its place and two cues; other signals may stay as they are
_REACH = 24  # bins (6 m): how far from a cut its two sides are compared
_NEAR = 8  # bins (2 m): the same for eaves and offset, which drift
_T = 4.0  # standard errors
_STEEP = 0.02  # of a wall's height: seen steeply from the street, a cornice's depth moves the top it shows
_GAP = 1.0  # m without any wall, from foot to eaves: an open gap


@dataclass(frozen=True)
class Cut:
    """A cut at s (m along the front), the probability that it parts two buildings, and the cues
    that speak for it."""

    s: float
    posterior: float
    cues: tuple[str, ...]


def find_cuts(
    profile: Profile,
    options: BuildingOptions,
    open_: Bool,
    party: Float | None = None,
    cell: float = 0.25,
) -> tuple[Cut, ...]:
    """Cuts of a front from left to right.

    `open_` (n,): bins that are seen through from the ground up;
    `party` (k,) m along the front: party walls of a map, where given; `cell` m: how finely heights are known.
    """
    signal, kinds = signals(profile)
    width = max(2, round(options.min_width / BIN))
    walls = np.empty(0) if party is None else party
    noise = noise_of(signal, kinds, profile.count)
    sampling = sampling_of(profile, noise, kinds)
    cuts = _candidates(signal, kinds, noise, sampling, width)
    gaps = _gaps(open_)
    cuts = _with_gaps(gaps, cuts, width)
    look = _Look(profile, signal, kinds, sampling, gaps, cell)
    kept, cues, odds = _prune(look, cuts, walls, options.snap)
    found = [
        Cut(profile.lo + c * BIN, 1 / (1 + np.exp(-o)), q) for c, q, o in zip(kept, cues, odds, strict=True)
    ]
    return _snap(found, walls, profile, options)


@dataclass(frozen=True, eq=False)
class _Look:
    """What cuts are judged by: channels (n, p), their sampling errors (n, p), open gaps, cell m."""

    profile: Profile
    signal: Float
    kinds: list[str]
    sampling: Float
    gaps: list[tuple[int, int]]
    cell: float


def _candidates(signal: Float, kinds: list[str], noise: Float, sampling: Float, width: int) -> Int:
    """Change points (c,) of all channels together, every bin weighted by how well it was measured."""
    use, length = np.isfinite(noise), 4.0
    if not use.any():
        return np.empty(0, np.int64)
    scaled = (signal / noise / np.sqrt(length))[:, use]
    linear = np.array([k in ("eaves", "offset", "bright") for k in kinds])[use]
    sigma = np.sqrt(noise**2 + sampling**2)
    penalty = 2.0 * _WITNESSES * np.log(max(2.0, len(signal) / length))
    level = np.clip(scaled - np.nanmedian(scaled, 0), -50, 50)
    cuts = change_points(level, penalty, width, linear, (noise / sigma)[:, use] ** 2)
    return sharpest(signal[:, use], sigma[:, use], cuts, width)


def _gaps(open_: Bool) -> list[tuple[int, int]]:
    """Stretches [a, b) of open bins, wide enough for a gap, not at the front's ends."""
    padded = np.concatenate([[False], open_, [False]])
    edge = np.flatnonzero(np.diff(padded.astype(np.int8)))
    runs = zip(edge[::2], edge[1::2], strict=True)
    return [(int(a), int(b)) for a, b in runs if (b - a) * BIN >= _GAP and a > 0 and b < len(open_)]


def _with_gaps(gaps: list[tuple[int, int]], cuts: Int, width: int) -> Int:
    """Every open gap is a candidate, and replaces the change points beside it."""
    middles = np.array([(a + b) // 2 for a, b in gaps], np.int64)
    if not len(middles):
        return cuts
    near = np.abs(cuts[:, None] - middles).min(1) < width if len(cuts) else np.empty(0, bool)
    return np.union1d(cuts[~near], middles)


def _prune(
    look: _Look, cuts: Int, walls: Float, snap: float
) -> tuple[list[int], list[tuple[str, ...]], list[float]]:
    """Take away the weakest unconvincing cut until all convince; the sides of the others grow meanwhile."""
    kept = [int(c) for c in cuts]
    while True:
        judged = [_judge(look, kept, i) for i in range(len(kept))]
        weak = []
        for i, (cues, strength, odds) in enumerate(judged):
            mapped = len(walls) and np.abs(walls - look.profile.lo - kept[i] * BIN).min() <= snap
            if not (len(cues) >= 2 or strength or mapped):
                weak.append((odds, i))
        if not weak:
            return kept, [j[0] for j in judged], [j[2] for j in judged]
        kept.pop(min(weak)[1])


def _judge(look: _Look, cuts: list[int], i: int) -> tuple[tuple[str, ...], bool, float]:
    """The cues for cut i among its neighbours, whether one of them suffices alone, and the log-odds."""
    c, n = cuts[i], len(look.profile)
    lo, hi = (cuts[i - 1] if i else 0), (cuts[i + 1] if i + 1 < len(cuts) else n)
    spread, tall = _within(look.signal, cuts), look.profile.rows.shape[1] * BIN
    cues: dict[str, float] = {}
    alone = any(a <= c <= b for a, b in look.gaps)
    if alone:
        cues["gap"] = 9.0
    for k, kind in enumerate(look.kinds):
        floor = max(FLOOR[kind], look.cell / 2) if kind == "eaves" else FLOOR[kind]
        reach = _NEAR if kind == "offset" else _REACH
        own = max(spread[k], floor) if np.isfinite(spread[k]) else floor
        step, t = _step(look, k, max(lo, c - reach), c, min(hi, c + reach), own)
        if kind == "eaves":  # a step, not a slope: it stands close to the cut as well as far from it
            close, _ = _step(look, k, max(lo, c - _NEAR), c, min(hi, c + _NEAR), floor)
            step, t = (min(abs(step), abs(close)), t) if step * close > 0 else (0.0, 0.0)
        least = max(_STEP[kind], _STEEP * tall) if kind == "eaves" else _STEP[kind]
        if t > _T and abs(step) > least:
            name = "surface" if kind in ("colour", "bright") else kind
            cues[name] = max(cues.get(name, 0.0), t)
            alone |= kind == "eaves"
    t = _rhythm(look.profile.rows, lo, c, hi)
    if t > _T:
        cues["rhythm"] = t
    odds: float = sum(min(t * t / 2, 12.0) - 4.0 for t in cues.values()) - 2.0
    return tuple(sorted(cues)), alone, float(np.clip(odds, -20, 20))


def _within(signal: Float, cuts: list[int]) -> Float:
    """Robust spread (p,) about the medians of the segments between cuts."""
    residual = [part - _median(part) for part in np.split(signal, cuts) if len(part)]
    return 1.4826 * _median(np.abs(np.concatenate(residual)))


def _median(a: Float) -> Float:
    """Median over the bins (p,), NaN for a channel without measurement."""
    n, column = np.isfinite(a).sum(0), np.arange(a.shape[1])
    if not len(a):
        return np.full(a.shape[1], np.nan)
    ordered = np.sort(a, axis=0)  # NaN last
    below, above = np.maximum(n - 1, 0) // 2, np.minimum(n // 2, len(a) - 1)
    return np.where(n > 0, 0.5 * (ordered[below, column] + ordered[above, column]), np.nan)


def _step(look: _Look, k: int, lo: int, c: int, hi: int, spread: float) -> tuple[float, float]:
    """Step of channel k at c, from the medians of [lo, c) and [c, hi), and its size in standard errors; bins
    within 1 m are one observation, and each side adds what its sampling leaves open."""
    medians, variance, per = [], 0.0, 1.0 / BIN
    for a, b in ((lo, c), (c, hi)):
        known = np.isfinite(look.signal[a:b, k])
        side, sampling = look.signal[a:b, k][known], look.sampling[a:b, k][known]
        if len(side) < 4:
            return 0.0, 0.0
        medians.append(float(np.median(side)))
        ragged = 1.4826 * float(np.median(np.abs(side - medians[-1])))  # a ragged side proves nothing
        variance += (
            (max(spread, ragged) ** 2 + float(np.nan_to_num(np.median(sampling))) ** 2) * per / len(side)
        )
    step = medians[1] - medians[0]
    return step, abs(step) / float(np.sqrt(variance))


def _rhythm(rows: Float, lo: int, c: int, hi: int) -> float:
    """How differently the openings stand in height left and right of a cut, in spreads of each
    side's own halves."""
    a, b = rows[max(lo, c - 2 * _REACH) : c], rows[c : min(hi, c + 2 * _REACH)]
    if min(len(a), len(b)) < 12:
        return 0.0
    low = [
        x.mean(0)
        for x in (a[::2], a[1::2], a[: len(a) // 2], a[len(a) // 2 :], b[: len(b) // 2], b[len(b) // 2 :])
    ]
    above = [np.cumsum(x.mean(0)[::-1])[::-1] for x in (a, b)]
    both = np.minimum(*above) > 0.2  # below both eaves
    if both.sum() < 8:
        return 0.0
    between = float(np.mean((a.mean(0) - b.mean(0))[both] ** 2))
    own = 0.5 * float(np.mean((low[2] - low[3])[both] ** 2) + np.mean((low[4] - low[5])[both] ** 2))
    return float(np.sqrt(between / max(own, 1e-3)) * 2.0) if between > 0.04 else 0.0


def _snap(cuts: list[Cut], walls: Float, profile: Profile, options: BuildingOptions) -> tuple[Cut, ...]:
    """Party walls of the map: each becomes a cut; a measured step beside it keeps its place and
    gains confidence."""
    out = list(cuts)
    hi = profile.lo + len(profile) * BIN
    for wall in walls[(walls > profile.lo + 1) & (walls < hi - 1)]:
        near = [c for c in out if abs(c.s - wall) <= options.snap]
        best = min(near, key=lambda c: abs(c.s - wall)) if near else Cut(float(wall), 0.5, ())
        measured = bool({"eaves", "offset", "gap"} & set(best.cues))
        odds = np.log(best.posterior / max(1 - best.posterior, 1e-9)) + 4.0
        out = [c for c in out if c not in near]
        out.append(
            Cut(best.s if measured else float(wall), float(1 / (1 + np.exp(-odds))), (*best.cues, "map"))
        )
    return tuple(sorted(out, key=lambda c: c.s))


def bins_of(cuts: tuple[Cut, ...], s: Float) -> Int:
    """Segment number (k,) from the left, of places s (k,) m along the front."""
    return np.searchsorted(np.array([c.s for c in cuts]), s).astype(np.int64)
