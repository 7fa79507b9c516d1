"""Detection of repeated windows: does a shift along the wall explain a pair of photos as well?

Five-point orientation cannot see such a shift: with a baseline along the wall, matches that are wrong by
one window stay on their epipolar lines, and only the ratio of baseline to distance changes. On the wall
itself the shift is plain. Every key point is carried to the wall from its own photo; the true matches meet
there, and those with a neighbouring window lie one pitch apart. A peak at any shift but zero is a rival,
and its height beside the peak at zero says how ambiguous the pair is. Candidates are several neighbours of
every key point, because the ratio test removes what repeats.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.orientation.ties.matches import several
from frontage.orientation.ties.sight import Sight
from frontage.orientation.ties.wall import wall_of_pair

_NEIGHBOURS = 3
_SAMPLE = 2048  # key points of the first photo that are tried
_FAR = 8.0  # times the distance of the wall; farther places on it are left out
_BIN_PX = 8.0
_BIN = 0.006  # of the distance: relief moves points on the wall
_CLEAR = 3  # bins around a peak that belong to it
_FEW = 8  # matches that chance may bring to one shift
_WITHIN = 3.0  # times the distance of the wall, the largest shift
_SHIFTS = 6  # peaks whose support is counted
_LOOK = 0.2  # share of the true matches that look less alike than what supports a shift
_NEAREST = 6  # key points around a predicted place that are compared


@dataclass(frozen=True, eq=False)
class Rival:
    """The strongest shift (2,) along the wall, its share of the matches without shift, the size of a bin."""

    share: float
    shift: Float
    bin: float

    def same_shift(self, shifts: Float) -> Bool:
        """Which of the shifts (n, 2) equal this one."""
        with np.errstate(invalid="ignore"):
            near: Bool = np.abs(shifts - self.shift).max(1) < 1.5 * self.bin
        return near


def bin_size(pixel: float, distance: float) -> float:
    """Size of a bin on a wall at some distance, which one pixel sees under `pixel` rad."""
    return max(_BIN_PX * pixel, _BIN) * distance


def strongest_shift(shifts: Float, source: Int, size: float, distance: float) -> Rival:
    """Finds the largest peak of shifts (n, 2) besides the one at zero, among those up to thrice the distance.

    source  (n,) key point that each shift belongs to; it counts once per bin
    """
    peaks = _peaks(shifts, source, size, _WITHIN * distance, 1)
    with np.errstate(invalid="ignore"):
        own = len(np.unique(source[np.abs(shifts).max(1) < 1.5 * size]))
    if not peaks:
        return Rival(0.0, np.zeros(2), size)
    height, shift = peaks[0]
    return Rival(height / max(own, 1), shift, size)


def _peaks(shifts: Float, source: Int, size: float, reach: float, count: int) -> list[tuple[int, Float]]:
    """The highest `count` peaks of shifts (n, 2) apart from zero and from one another, with their heights."""
    with np.errstate(invalid="ignore"):
        inside = np.isfinite(shifts).all(1) & (np.abs(shifts).max(1) < reach)
    half = int(np.ceil(reach / size)) + 1
    side = 2 * half + 1
    cells = np.round(shifts[inside] / size).astype(np.int64) + half
    keys = np.unique(source[inside] * side**2 + cells[:, 0] * side + cells[:, 1]) % side**2
    cell, number = np.unique(keys, return_counts=True)
    table = dict(zip(cell.tolist(), number.tolist(), strict=True))
    around = [i * side + j for i in (-1, 0, 1) for j in (-1, 0, 1)]
    heavy = cell[np.argsort(-number, kind="stable")[:300]].tolist()
    heights = sorted((-sum(table.get(c + a, 0) for a in around), c) for c in heavy)
    taken, peaks = [(half, half)], list[tuple[int, Float]]()
    for negative, c in heights:
        place = (c // side, c % side)
        if -negative < _FEW or len(peaks) == count:
            break
        if all(max(abs(place[0] - p), abs(place[1] - q)) > _CLEAR for p, q in taken):
            taken.append(place)
            peaks.append((-negative, size * (np.array(place, np.float64) - half)))
    return peaks


def pair_rival(a: Sight, b: Sight, rows: Int, R: Float, t: Float) -> tuple[Rival, Bool]:
    """Returns the strongest rival of an oriented pair, and which of its `rows` (m, 2) have that shift.

    R, t  second_from_first

    Peaks of the shifts are proposals. What counts is their support: the key points of the first photo for
    which the second has one at the predicted place that looks as alike as true matches do.
    """
    rng = np.random.default_rng(len(rows))
    wall, centre = wall_of_pair(a.rays[rows[:, 0]], b.rays[rows[:, 1]], R, t, rng)
    some = np.sort(rng.permutation(len(a.looks))[:_SAMPLE])
    near = several(a.looks[some], b.looks, _NEIGHBOURS)
    place_a, place_b = wall.meet(np.zeros(3), a.rays), wall.meet(centre, b.rays @ R)
    for place in (place_a, place_b):
        with np.errstate(invalid="ignore"):
            place[np.abs(place).max(1) > _FAR * wall.distance] = np.nan
    size = bin_size(0.5 * (a.pixel + b.pixel), wall.distance)
    shifts = place_b[near[:, 1]] - place_a[some[near[:, 0]]]
    peaks = _peaks(shifts, near[:, 0], size, _WITHIN * wall.distance, _SHIFTS)
    none = np.zeros(2)
    if not peaks:
        return Rival(0.0, none, size), np.zeros(len(rows), np.bool_)
    alike = float(np.quantile((a.looks[rows[:, 0]] * b.looks[rows[:, 1]]).sum(1), _LOOK))
    counts = _supports(a, b, some, (place_a, place_b), [none, *(s for _, s in peaks)], size, alike)
    known = (1 - _LOOK) * np.isin(rows[:, 0], some).sum()  # not all true matches lie on the wall
    best = int(np.argmax(counts[1:]))
    share = counts[1 + best] / max(counts[0], known, 1)
    rival = Rival(share if counts[1 + best] >= _FEW else 0.0, peaks[best][1], size)
    return rival, rival.same_shift(place_b[rows[:, 1]] - place_a[rows[:, 0]])


def _supports(
    a: Sight,
    b: Sight,
    some: Int,
    places: tuple[Float, Float],
    shifts: list[Float],
    size: float,
    alike: float,
) -> list[int]:
    """For every shift, how many of `some` key points of the first photo find one that looks alike."""
    on_wall = np.flatnonzero(np.isfinite(places[1]).all(1))
    some = some[np.isfinite(places[0][some]).all(1)]
    if not len(on_wall) or not len(some):
        return [0] * len(shifts)
    tree = KDTree(places[1][on_wall])
    counts = []
    for shift in shifts:
        near = tree.query(places[0][some] + shift, _NEAREST, distance_upper_bound=1.5 * size)
        far, found = np.asarray(near[0]), np.asarray(near[1])
        k, m = np.nonzero(np.isfinite(far))
        first, second = some[k], on_wall[found[k, m]]
        good = _cosines(a.looks[first], b.looks[second]) >= alike
        counts.append(min(len(np.unique(first[good])), len(np.unique(second[good]))))
    return counts


def _cosines(one: Array, other: Array) -> Array:
    cosines: Array = np.einsum("ij,ij->i", one, other)
    return cosines
