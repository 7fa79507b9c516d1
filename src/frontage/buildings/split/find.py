"""Find where a row of houses is cut: change points of its profile, kept where independent cues agree.

No signal cuts on its own, except a step of the eaves or an open gap. A bay moves the plane, a shop front
changes the colour and a stair the rhythm, all of it within one house.
"""

from dataclasses import dataclass

import numpy as np

from frontage.buildings.fronts.profile import BIN_M, FrontProfile
from frontage.buildings.options import BuildingOptions
from frontage.buildings.split.avant_corps import find_avant_corps
from frontage.buildings.split.channels import channels, noise_of, sampling_of, sharpest
from frontage.buildings.split.evidence import BinRange, SplitEvidence
from frontage.buildings.split.maps import MappedRow, map_shift
from frontage.buildings.split.verdict import PLACED, Verdict, judge_cut, settle_cuts
from frontage.geometry.arrays import Bool, Float, Int
from frontage.solve.segmentation import change_points

_PARAMETERS = 3  # parameters that a cut is charged for: its place and two cues
_GAP_M = 1.0  # m without any wall from foot to eaves: an open gap
_CORRELATION_BINS = 4.0  # bins (1 m) that count as one observation
_MAP_ODDS = 4.0  # log odds that a mapped party wall adds to a cut
_MAP_ALONE = 0.5  # posterior of a mapped party wall before these odds are added
_END_M = 1.0  # m from the ends of a front within which a mapped party wall is no cut


@dataclass(frozen=True)
class Cut:
    """A cut at s (m along the front), its probability of parting two buildings, and the cues for it."""

    s: float
    posterior: float
    cues: tuple[str, ...]


def find_cuts(
    profile: FrontProfile,
    options: BuildingOptions,
    open_: Bool,
    row: MappedRow | None = None,
    cell: float = 0.25,
) -> tuple[Cut, ...]:
    """Finds the cuts of a front, from left to right.

    open_  (n,) bins that are seen through from the ground up
    row    what a map says along the front, or None; where a map covers the street, it decides
    cell   m, how finely heights are known
    """
    signal, kinds = channels(profile)
    width = max(2, round(options.min_width / BIN_M))
    noise = noise_of(signal, kinds, profile.count)
    sampling = sampling_of(profile, noise, kinds)
    cuts = _candidates(signal, kinds, noise, sampling, width)
    gaps = _gaps(open_)
    cuts = _with_gaps(gaps, cuts, width)
    if row is not None:
        cuts = np.array(
            [c for c in cuts if not row.inside(profile.lo + c * BIN_M, profile.lo, options.snap)], np.int64
        )
    evidence = SplitEvidence(profile, signal, kinds, sampling, gaps, cell)
    found = _prune(evidence, cuts, np.empty(0) if row is None else row.walls, options.snap, width)
    return tuple(found) if row is None else _snap(found, row, profile, options.snap)


def _candidates(signal: Float, kinds: list[str], noise: Float, sampling: Float, width: int) -> Int:
    """Finds change points (c,) of all channels together; bins weigh as much as they were measured well."""
    use = np.isfinite(noise)
    if not use.any():
        return np.empty(0, np.int64)
    scaled = (signal / noise / np.sqrt(_CORRELATION_BINS))[:, use]
    linear = np.array([k in ("eaves", "offset", "bright") for k in kinds])[use]
    sigma = np.sqrt(noise**2 + sampling**2)
    penalty = 2.0 * _PARAMETERS * np.log(max(2.0, len(signal) / _CORRELATION_BINS))
    level = np.clip(scaled - np.nanmedian(scaled, 0), -50, 50)
    cuts = change_points(level, penalty, width, linear, (noise / sigma)[:, use] ** 2)
    return sharpest(signal[:, use], sigma[:, use], cuts, width)


def _gaps(open_: Bool) -> list[BinRange]:
    """Returns the stretches of open bins that are wide enough for a gap and not at the front's ends."""
    padded = np.concatenate([[False], open_, [False]])
    edge = np.flatnonzero(np.diff(padded.astype(np.int8)))
    runs = zip(edge[::2], edge[1::2], strict=True)
    return [(int(a), int(b)) for a, b in runs if (b - a) * BIN_M >= _GAP_M and a > 0 and b < len(open_)]


def _with_gaps(gaps: list[BinRange], cuts: Int, width: int) -> Int:
    """Makes every open gap a candidate; it replaces the change points beside it."""
    middles = np.array([(a + b) // 2 for a, b in gaps], np.int64)
    if not len(middles):
        return cuts
    near = np.abs(cuts[:, None] - middles).min(1) < width if len(cuts) else np.empty(0, bool)
    return np.union1d(cuts[~near], middles)


def _prune(evidence: SplitEvidence, cuts: Int, walls: Float, snap: float, width: int) -> list[Cut]:
    """Removes the sides of avant-corps and the weakest unconvincing cut until all convince.

    An avant-corps is looked for while one of its sides convinces: the other may be hidden, and without it the
    step of the eaves parts a house.

    The remaining pieces grow meanwhile, and all cuts are judged anew. Cuts within `snap` m of a mapped party
    wall (`walls` (c,) m) stay.
    """
    kept = [int(c) for c in cuts]
    while True:
        verdicts = [judge_cut(evidence, kept, i) for i in range(len(kept))]
        place = [evidence.profile.lo + c * BIN_M for c in kept]
        mapped = [bool(len(walls)) and bool(np.abs(walls - s).min() <= snap) for s in place]
        fixed = [m or "gap" in v.cues for m, v in zip(mapped, verdicts, strict=True)]
        i = find_avant_corps(evidence, kept, fixed, [v.convincing for v in verdicts])
        if i is not None:
            del kept[i : i + 2]
            continue
        weak = [(v.odds, i) for i, v in enumerate(verdicts) if not (v.convincing or mapped[i])]
        if not weak:
            return _settled(evidence, kept, verdicts)
        kept.pop(min(weak)[1])


def _settled(evidence: SplitEvidence, kept: list[int], verdicts: list[Verdict]) -> list[Cut]:
    """Moves the cuts that were kept to their steps and states their posteriors."""
    kept = settle_cuts(evidence, kept, [v.cues for v in verdicts])
    return [
        Cut(evidence.profile.lo + c * BIN_M, float(1 / (1 + np.exp(-v.odds))), v.cues)
        for c, v in zip(kept, verdicts, strict=True)
    ]


def _snap(cuts: list[Cut], row: MappedRow, profile: FrontProfile, snap: float) -> tuple[Cut, ...]:
    """Makes every party wall of the map a cut.

    A measured step beside it keeps its place and gains confidence. Where nothing was measured, the map is
    shifted by what the measured steps say that it is off.
    """
    out = list(cuts)
    lo, hi = profile.lo, profile.lo + len(profile) * BIN_M
    seen = np.array([c.s for c in cuts if PLACED & set(c.cues)])
    shift = map_shift(row, seen, lo, hi, snap)
    for wall in row.walls[(row.walls > lo + _END_M) & (row.walls < hi - _END_M)]:
        near = [c for c in out if abs(c.s - wall) <= snap]
        best = (
            min(near, key=lambda c: (not PLACED & set(c.cues), abs(c.s - wall)))
            if near
            else Cut(wall, _MAP_ALONE, ())
        )
        s = best.s if PLACED & set(best.cues) else float(wall) + shift
        odds = np.log(best.posterior / max(1 - best.posterior, 1e-9)) + _MAP_ODDS
        out = [c for c in out if c not in near]
        out.append(Cut(s, float(1 / (1 + np.exp(-odds))), (*best.cues, "map")))
    return tuple(sorted(out, key=lambda c: c.s))


def segment_of(cuts: tuple[Cut, ...], s: Float) -> Int:
    """Returns the segment (k,), numbered from the left, of places s (k,) m along the front."""
    return np.searchsorted(np.array([c.s for c in cuts]), s).astype(np.int64)
