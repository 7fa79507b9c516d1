"""Collect the result: from one label per leaf to the `Building` nouns, numbered along the street."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.buildings.assembly.segments import SegmentedStreet
from frontage.buildings.cloud import StreetCloud
from frontage.buildings.fronts.front import StreetFront
from frontage.buildings.groups import grouped, mean_of
from frontage.buildings.split.maps import footprint_of
from frontage.geometry.arrays import Bool, Float, Int, distinct
from frontage.model import Building, Scan

_ACROSS_M = 3.0  # m before the longest front, from which a building stands across the street

PlacedCut = tuple[tuple[float, float], float]  # (x, y) m local, and the posterior of a cut


@dataclass(frozen=True, eq=False)
class BuildingSplit:
    """A street divided into buildings, ground, occluders and the rest.

    The four kinds of index (int64, into the scan) are disjoint and together complete.

    spacing  m, median distance between neighbouring points
    notes    sentences for the report
    """

    buildings: tuple[Building, ...]
    ground: Int
    occluders: Int
    rest: Int
    spacing: float
    notes: tuple[str, ...] = ()


def collect(
    cloud: StreetCloud,
    label: Int,
    ground: Bool,
    occluder: Bool | None = None,
    street: SegmentedStreet | None = None,
) -> BuildingSplit:
    """Makes `Building` nouns from the label of every leaf, numbered along the street.

    label             (m,) number of each leaf's building in any order, -1 = none
    ground, occluder  (m,) leaves of either kind
    street            the fronts that tell the order; by coordinates when omitted
    """
    tree = cloud.tree
    label = np.where(ground, -1, label)
    number, count = _numbers(cloud, label, street)
    own = number[label]
    sort, edge = grouped(own.astype(np.int32)[tree.of_point], count)
    leaf_sort, leaf_edge = grouped(own, count)
    cuts = _cuts_of(street, number) if street else {}
    buildings = tuple(
        _building(
            cloud, b, sort[edge[b] : edge[b + 1]], leaf_sort[leaf_edge[b] : leaf_edge[b + 1]], cuts.get(b, ())
        )
        for b in range(count)
    )
    other = sort[: edge[0]]
    leaf = tree.of_point[other]
    before = np.zeros(len(leaf), bool) if occluder is None else occluder[leaf] & ~ground[leaf]
    rest = ~ground[leaf] & ~before
    notes = _notes(cloud, len(buildings))
    return BuildingSplit(buildings, other[ground[leaf]], other[before], other[rest], cloud.spacing, notes)


def nothing_found(scan: Scan, note: str) -> BuildingSplit:
    """Returns a split without buildings, in which all points are rest."""
    none = np.empty(0, np.int64)
    return BuildingSplit((), none, none, np.arange(len(scan), dtype=np.int64), float("nan"), (note,))


def as_seen(split: BuildingSplit, axes: Float) -> BuildingSplit:
    """Returns a split that was found in the frame of `axes` (3, 3) as one in the frame of the scan."""

    def back(xy: tuple[float, float]) -> tuple[float, float]:
        """Returns a place in plan in the frame of the scan."""
        x, y = axes[:2, :2] @ xy
        return float(x), float(y)

    buildings = tuple(
        replace(
            b,
            footprint=None if b.footprint is None else b.footprint @ axes[:2, :2].T,
            cuts=tuple((back(place), posterior) for place, posterior in b.cuts),
        )
        for b in split.buildings
    )
    return replace(split, buildings=buildings)


def _numbers(cloud: StreetCloud, label: Int, street: SegmentedStreet | None) -> tuple[Int, int]:
    """Returns the number along the street of every label, and their count; the last entry, -1, is for -1."""
    known = distinct(label[label >= 0])
    inside = np.flatnonzero(label >= 0)
    at = np.searchsorted(known, label[inside])
    size = np.bincount(at, minlength=len(known)).astype(np.float64)
    place = np.column_stack([mean_of(at, cloud.tree.leaf.mean[inside, a], size) for a in (0, 1)])
    rank = (
        _order(street.fronts if street else (), place, -1.0 if cloud.mirrored else 1.0)
        if len(known)
        else np.empty(0, np.int64)
    )
    number = np.full(int(label.max()) + 2, -1, np.int64)
    number[known[rank]] = np.arange(len(known))
    return number, len(known)


def _order(fronts: Sequence[StreetFront], place: Float, rightwards: float) -> Int:
    """Returns the order (b,) of buildings at `place` (b, 2) m.

    It runs along the longest front from left to right, then across the street. `rightwards` is -1 where left
    and right are swapped.
    """
    if not fronts:
        return np.lexsort((place[:, 1], place[:, 0]))
    first = max(fronts, key=lambda f: (f.length, -f.origin[0], -f.origin[1]))
    s, d = first.coordinates(place)
    return np.lexsort((np.round(rightwards * s, 3), d > _ACROSS_M))


def _notes(cloud: StreetCloud, count: int) -> tuple[str, ...]:
    """Writes what a user must know about the split."""
    notes = []
    if cloud.ground is None:
        notes.append("no ground was measured: heights count from each building's lowest point")
    if not count:
        notes.append(f"no building in {cloud.scan.name}: nothing rises from the ground")
    return tuple(notes)


def _cuts_of(street: SegmentedStreet, number: Int) -> dict[int, tuple[PlacedCut, ...]]:
    """Returns the cuts on the border of every building."""
    out: dict[int, list[PlacedCut]] = {}
    building, hidden = street.building_of_segment(), street.hidden_fronts()
    for f, front in enumerate(street.fronts):
        if f in hidden:
            continue
        for i, cut in enumerate(street.cuts[f]):
            d = street.profiles[f].offset_at(np.array([cut.s]))[0]
            x, y = front.origin + cut.s * front.along + d * front.out
            segment = street.first[f] + i
            sides = {int(number[building[segment]]), int(number[building[segment + 1]])}
            for b in sides if len(sides) == 2 else ():
                out.setdefault(b, []).append(((float(x), float(y)), float(cut.posterior)))
    return {b: tuple(c) for b, c in out.items()}


def _building(cloud: StreetCloud, b: int, index: Int, own: Int, cuts: tuple[PlacedCut, ...]) -> Building:
    """Makes building number b from its points `index` (k,) and its leaves `own` (j,).

    Its ground is the terrain under its leaves, or its lowest leaf where no ground was measured.
    """
    mean = cloud.tree.leaf.mean[own]
    if cloud.ground is None:
        ground_z = float(mean[:, 2].min())
    else:
        ground_z = float(np.median(mean[:, 2] - cloud.ground.height(mean)))
    known = footprint_of(mean[:, :2], cloud.footprints)
    return Building(
        f"B{b + 1:02d}",
        index,
        ground_z,
        known.address if known else None,
        known.ring if known else None,
        cuts=cuts,
        notes=(f"footprint {known.id}",) if known else (),
    )
