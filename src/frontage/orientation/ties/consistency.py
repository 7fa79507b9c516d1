"""Pairs that contradict the others are left out before mapping: cycles of rotations, approximate poses."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import rotation_angle
from frontage.model import Photo
from frontage.orientation.nouns import PairMatches
from frontage.orientation.ties.options import TieOptions

_CYCLE = np.radians(2.0)  # misclosure of three relative rotations
_WEAK = 100  # matches; pairs with fewer must agree with the approximate poses
_SIGMAS = 4.0


def consistent(
    pairs: Sequence[PairMatches], photos: Sequence[Photo], options: TieOptions
) -> list[PairMatches]:
    """Returns the pairs that do not contradict triplets of photos or approximate poses.

    Approximate poses judge only weak and doubtful pairs, since a camera's GPS and compass may be far off.
    """
    plausible = [
        p
        for p in pairs
        if (len(p.rows) >= _WEAK and p.rival <= 0.5 * options.rival)
        or agrees_with_poses(p, photos[p.first], photos[p.second])
    ]
    return _closing(plausible)


def agrees_with_poses(pair: PairMatches, first: Photo, second: Photo) -> bool:
    """Whether the relative rotation is that of the approximate poses, to four sigmas; true without poses."""
    a, b = first.local_from_camera, second.local_from_camera
    if a is None or b is None:
        return True
    off = rotation_angle(pair.rotation @ (b.value.R.T @ a.value.R).T)
    sigma = float(np.sqrt((a.sigma[3:] ** 2).sum() + (b.sigma[3:] ** 2).sum()))
    return bool(off < _SIGMAS * sigma + _CYCLE)


def _closing(pairs: list[PairMatches]) -> list[PairMatches]:
    """Leaves out, worst first, the pairs most of whose triangles do not close in rotation."""
    kept = {(p.first, p.second): p for p in pairs}
    numbers = sorted({n for key in kept for n in key})
    triangles = [
        (t, _misclosure(kept, *t) < _CYCLE)
        for t in combinations(numbers, 3)
        if all(e in kept for e in combinations(t, 2))
    ]
    while True:
        score: dict[tuple[int, int], list[int]] = {}
        for t, closes in triangles:
            for edge in combinations(t, 2):
                score.setdefault(edge, [0, 0])[int(closes)] += 1
        bad = [
            (good / (good + wrong), len(kept[e].rows), e)
            for e, (wrong, good) in score.items()
            if wrong > good
        ]
        if not bad:
            return [kept[e] for e in sorted(kept)]
        worst = min(bad)[2]
        del kept[worst]
        triangles = [(t, closes) for t, closes in triangles if not set(worst) <= set(t)]


def _misclosure(pairs: dict[tuple[int, int], PairMatches], i: int, j: int, k: int) -> float:
    """Angle of R_ik' R_jk R_ij, which should be none."""
    cycle: Float = pairs[i, k].rotation.T @ pairs[j, k].rotation @ pairs[i, j].rotation
    return rotation_angle(cycle)
