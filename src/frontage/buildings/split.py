"""Where a row of houses is cut: change points of the profile, kept when independent cues agree.

One signal never cuts on its own, except a step of the eaves or an open gap: a bay moves the plane,
a shop front
changes the colour, a stair the rhythm, and all of it within one house.
"""

from dataclasses import dataclass

import numpy as np

from frontage.buildings.bays import embedded
from frontage.buildings.evidence import Look, judge, settled
from frontage.buildings.maps import MappedRow, map_shift
from frontage.buildings.options import BuildingOptions
from frontage.buildings.profile import BIN, Profile
from frontage.buildings.signals import noise_of, sampling_of, sharpest, signals
from frontage.geometry.arrays import Bool, Float, Int
from frontage.solve.segmentation import change_points

_WITNESSES = 3  # parameters a cut is charged for: its place and two cues; other signals may stay as they are
_PLACED = {
    "eaves",
    "offset",
    "surface",
    "gap",
}  # cues that tell where a party wall is, not only that there is one
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
    row: MappedRow | None = None,
    cell: float = 0.25,
) -> tuple[Cut, ...]:
    """Cuts of a front from left to right.

    `open_` (n,): bins that are seen through from the ground up;
    `row`: what a map says along the front, where given; `cell` m: how finely heights are known.
    """
    signal, kinds = signals(profile)
    width = max(2, round(options.min_width / BIN))
    noise = noise_of(signal, kinds, profile.count)
    sampling = sampling_of(profile, noise, kinds)
    cuts = _candidates(signal, kinds, noise, sampling, width)
    gaps = _gaps(open_)
    cuts = _with_gaps(gaps, cuts, width)
    if row is not None:  # where a map covers the street, it decides
        cuts = np.array(
            [c for c in cuts if not row.inside(profile.lo + c * BIN, profile.lo, options.snap)], np.int64
        )
    look = Look(profile, signal, kinds, sampling, gaps, cell)
    found = _prune(look, cuts, np.empty(0) if row is None else row.walls, options.snap, width)
    return tuple(found) if row is None else _snap(found, row, profile, options.snap)


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


def _prune(look: Look, cuts: Int, walls: Float, snap: float, width: int) -> list[Cut]:
    """Take away the weakest unconvincing cut until all convince, and the sides of bays; the other pieces grow
    meanwhile. Cuts beside a mapped party wall stay."""
    kept = [int(c) for c in cuts]
    while True:
        judged = [judge(look, kept, i) for i in range(len(kept))]
        place = [look.profile.lo + c * BIN for c in kept]
        mapped = [bool(len(walls)) and bool(np.abs(walls - s).min() <= snap) for s in place]
        weak = [(v.odds, i) for i, v in enumerate(judged) if not (v.convincing or mapped[i])]
        if weak:
            kept.pop(min(weak)[1])
            continue
        bay = embedded(look, kept, [m or "gap" in v.cues for m, v in zip(mapped, judged, strict=True)])
        if bay is None:
            kept = settled(look, kept, [v.cues for v in judged], width)
            odds = [float(1 / (1 + np.exp(-v.odds))) for v in judged]
            return [
                Cut(look.profile.lo + c * BIN, o, v.cues) for c, o, v in zip(kept, odds, judged, strict=True)
            ]
        del kept[bay : bay + 2]


def _snap(cuts: list[Cut], row: MappedRow, profile: Profile, snap: float) -> tuple[Cut, ...]:
    """Party walls of the map: each becomes a cut. A measured step beside it keeps its place and gains
    confidence; where nothing was measured, the map is moved as the measured ones say that it is off."""
    out = list(cuts)
    lo, hi = profile.lo, profile.lo + len(profile) * BIN
    seen = np.array([c.s for c in cuts if _PLACED & set(c.cues)])
    shift = map_shift(row, seen, lo, hi, snap)
    for wall in row.walls[(row.walls > lo + 1) & (row.walls < hi - 1)]:
        near = [c for c in out if abs(c.s - wall) <= snap]
        best = (
            min(near, key=lambda c: (not _PLACED & set(c.cues), abs(c.s - wall)))
            if near
            else Cut(wall, 0.5, ())
        )
        s = best.s if _PLACED & set(best.cues) else float(wall) + shift
        odds = np.log(best.posterior / max(1 - best.posterior, 1e-9)) + 4.0
        out = [c for c in out if c not in near]
        out.append(Cut(s, float(1 / (1 + np.exp(-odds))), (*best.cues, "map")))
    return tuple(sorted(out, key=lambda c: c.s))


def bins_of(cuts: tuple[Cut, ...], s: Float) -> Int:
    """Segment number (k,) from the left, of places s (k,) m along the front."""
    return np.searchsorted(np.array([c.s for c in cuts]), s).astype(np.int64)
