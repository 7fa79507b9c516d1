"""Where a row of houses is cut: change points of the profile, kept when independent cues agree.

One signal never cuts on its own, except a step of the eaves or an open gap: a bay moves the plane,
a shop front
changes the colour, a stair the rhythm, and all of it within one house.
"""

from dataclasses import dataclass

import numpy as np

from frontage.buildings.options import BuildingOptions
from frontage.buildings.profile import BIN, Profile
from frontage.geometry.arrays import Float, Int
from frontage.solve.segmentation import change_points

_LAG = 10  # bins (2.5 m): differences at this lag hold the windows' own rhythm as noise
_FLOOR = {"eaves": 0.15, "offset": 0.03, "rough": 0.01, "colour": 4.0, "bright": 0.1}
_STEP = {"eaves": 0.4, "offset": 0.05, "rough": 0.015, "colour": 6.0, "bright": 0.2}
_WITNESSES = 3  # parameters a cut is charged for: its place and two cues; other signals may stay as they are
_REACH = 24  # bins (6 m): how far from a cut its two sides are compared
_NEAR = 8  # bins (2 m): the same for eaves and offset, which drift
_T = 4.0  # standard errors
_GAP = 1.0  # m without any wall, from foot to eaves: an open gap


@dataclass(frozen=True)
class Cut:
    """A cut at s (m along the front), the probability that it parts two buildings, and the cues
    that speak for it."""

    s: float
    posterior: float
    cues: tuple[str, ...]


def find_cuts(
    profile: Profile, options: BuildingOptions, party: Float | None = None, cell: float = 0.25
) -> tuple[Cut, ...]:
    """Cuts of a front from left to right.

    `party` (k,) m along the front: party walls of a map, where given; `cell` m: how finely heights are known.
    """
    signal, kinds = _signals(profile)
    width = max(2, round(options.min_width / BIN))
    walls = np.empty(0) if party is None else party
    cuts = np.empty(0, np.int64)
    noise, length = _noise(signal, kinds), 4.0
    if np.isfinite(noise).any():
        scaled = signal / noise / np.sqrt(length)
        linear = np.array([k in ("eaves", "offset", "bright") for k in kinds])
        use = np.isfinite(noise)
        n = max(2.0, len(profile) / length)
        penalty = 2.0 * _WITNESSES * np.log(n)
        cuts = change_points(
            np.clip(scaled[:, use] - np.nanmedian(scaled[:, use], 0), -50, 50), penalty, width, linear[use]
        )
    cuts = _with_gaps(profile, cuts, width)
    kept, cues, odds = _prune(profile, signal, kinds, cuts, walls, options.snap, cell)
    found = [
        Cut(profile.lo + c * BIN, 1 / (1 + np.exp(-o)), q) for c, q, o in zip(kept, cues, odds, strict=True)
    ]
    return _snap(found, walls, profile, options)


def _signals(profile: Profile) -> tuple[Float, list[str]]:
    """The profile as one matrix (n, p) and the kind of every channel."""
    parts = [profile.top, profile.offset, profile.rough, *profile.colour.T, profile.bright]
    return np.column_stack(parts), ["eaves", "offset", "rough", *["colour"] * 6, "bright"]


def _noise(signal: Float, kinds: list[str]) -> Float:
    """Spread (p,) within a building: of differences at the lag of a window bay, whose median few
    cuts can move."""
    if len(signal) <= _LAG:
        return np.full(signal.shape[1], np.nan)
    difference = np.abs(signal[_LAG:] - signal[:-_LAG])
    known = np.isfinite(difference).sum(0) >= 4
    spread = np.full(signal.shape[1], np.nan)
    if known.any():
        spread[known] = 1.4826 / np.sqrt(2) * np.nanmedian(difference[:, known], axis=0)
    return np.where(known, np.maximum(spread, [_FLOOR[k] for k in kinds]), np.nan)


def _gaps(profile: Profile) -> list[tuple[int, int]]:
    """Stretches [a, b) of bins without wall at any height, wide enough to be open, not at the
    front's ends."""
    empty = np.concatenate([[False], ~np.isfinite(profile.top), [False]])
    edge = np.flatnonzero(np.diff(empty.astype(np.int8)))
    runs = zip(edge[::2], edge[1::2], strict=True)
    return [(int(a), int(b)) for a, b in runs if (b - a) * BIN >= _GAP and a > 0 and b < len(profile)]


def _with_gaps(profile: Profile, cuts: Int, width: int) -> Int:
    """Every open gap is a candidate, and replaces the change points beside it."""
    middles = np.array([(a + b) // 2 for a, b in _gaps(profile)], np.int64)
    if not len(middles):
        return cuts
    near = np.abs(cuts[:, None] - middles).min(1) < width if len(cuts) else np.empty(0, bool)
    return np.union1d(cuts[~near], middles)


def _prune(
    profile: Profile, signal: Float, kinds: list[str], cuts: Int, walls: Float, snap: float, cell: float
) -> tuple[list[int], list[tuple[str, ...]], list[float]]:
    """Take away the weakest unconvincing cut until all convince; the sides of the others grow meanwhile."""
    kept = [int(c) for c in cuts]
    while True:
        judged = [_judge(profile, signal, kinds, kept, i, cell) for i in range(len(kept))]
        weak = []
        for i, (cues, strength, odds) in enumerate(judged):
            mapped = len(walls) and np.abs(walls - profile.lo - kept[i] * BIN).min() <= snap
            if not (len(cues) >= 2 or strength or mapped):
                weak.append((odds, i))
        if not weak:
            return kept, [j[0] for j in judged], [j[2] for j in judged]
        kept.pop(min(weak)[1])


def _judge(
    profile: Profile, signal: Float, kinds: list[str], cuts: list[int], i: int, cell: float
) -> tuple[tuple[str, ...], bool, float]:
    """The cues for cut i among its neighbours, whether one of them suffices alone, and the log-odds."""
    c = cuts[i]
    lo, hi = (cuts[i - 1] if i else 0), (cuts[i + 1] if i + 1 < len(cuts) else len(profile))
    spread = _within(signal, cuts)
    cues: dict[str, float] = {}
    alone = any(a <= c <= b for a, b in _gaps(profile))
    if alone:
        cues["gap"] = 9.0
    for k in range(signal.shape[1]):
        kind = kinds[k]
        reach = _NEAR if kind == "offset" else _REACH
        left, right = signal[max(lo, c - reach) : c, k], signal[c : min(hi, c + reach), k]
        floor = max(_FLOOR[kind], cell / 2) if kind == "eaves" else _FLOOR[kind]
        step, t = _step(left, right, max(spread[k], floor) if np.isfinite(spread[k]) else floor)
        if kind == "eaves":  # a step, not a slope: it stands close to the cut as well as far from it
            close, tight = _step(left[-_NEAR:], right[:_NEAR], floor)
            step, t = min(step, close), min(t, tight)
        if t > _T and step > _STEP[kind]:
            name = "surface" if kind in ("colour", "bright") else kind
            cues[name] = max(cues.get(name, 0.0), t)
            alone |= kind == "eaves"
    t = _rhythm(profile.rows, lo, c, hi)
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
    out = np.full(a.shape[1], np.nan)
    known = np.isfinite(a).any(0)
    out[known] = np.nanmedian(a[:, known], axis=0)
    return out


def _step(left: Float, right: Float, spread: float) -> tuple[float, float]:
    """Difference of the two sides' medians, and the same in standard errors; bins within 1 m are
    one observation."""
    left, right = left[np.isfinite(left)], right[np.isfinite(right)]
    if min(len(left), len(right)) < 4:
        return 0.0, 0.0
    step = abs(float(np.median(left) - np.median(right)))
    own = [1.4826 * float(np.median(np.abs(side - np.median(side)))) for side in (left, right)]
    spread = max(spread, *own)  # a ragged side proves nothing
    per = 1.0 / BIN
    return step, step / (spread * np.sqrt(per / len(left) + per / len(right)))


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
