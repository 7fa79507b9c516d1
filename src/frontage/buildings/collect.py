"""From one label per leaf to the Building nouns, numbered along the street."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.buildings.assemble import Street
from frontage.buildings.ground import Ground
from frontage.buildings.maps import footprint_of
from frontage.buildings.octree import Octree
from frontage.buildings.street import order
from frontage.buildings.voxels import grouped, mean_of
from frontage.geometry.arrays import Bool, Int, distinct
from frontage.model import Building, Footprint, Scan


@dataclass(frozen=True, eq=False)
class BuildingSplit:
    """The street divided. The four kinds of index (int64, into the scan) are disjoint and together complete.

    spacing is the median distance of neighbouring points in m; notes are sentences for the report.
    """

    buildings: tuple[Building, ...]
    ground: Int
    occluders: Int
    rest: Int
    spacing: float
    notes: tuple[str, ...] = ()


def collect(
    scan: Scan,
    tree: Octree,
    label: Int,
    ground_leaf: Bool,
    occluder: Bool | None,
    ground: Ground | None,
    spacing: float,
    footprints: Sequence[Footprint],
    street: Street | None = None,
) -> BuildingSplit:
    """Building nouns from the label (m,) of every leaf (-1 = none), numbered along the street."""
    label = np.where(ground_leaf, -1, label)
    number, count = _numbers(tree, label, street)
    own = number[label]
    sort, edge = grouped(own.astype(np.int32)[tree.of_point], count)
    leaf_sort, leaf_edge = grouped(own, count)
    owners = _cuts_of(street, number) if street else {}
    parts = [
        (sort[edge[b] : edge[b + 1]], leaf_sort[leaf_edge[b] : leaf_edge[b + 1]], owners.get(b, ()))
        for b in range(count)
    ]
    buildings = tuple(
        _building(tree, b, index, own, ground, cuts, footprints) for b, (index, own, cuts) in enumerate(parts)
    )
    other = sort[: edge[0]]
    leaf = tree.of_point[other]
    block = np.zeros(len(leaf), bool) if occluder is None else occluder[leaf] & ~ground_leaf[leaf]
    rest = ~ground_leaf[leaf] & ~block
    notes = _notes(scan, ground, len(buildings))
    return BuildingSplit(buildings, other[ground_leaf[leaf]], other[block], other[rest], spacing, notes)


def _numbers(tree: Octree, label: Int, street: Street | None) -> tuple[Int, int]:
    """Number of every label along the street (last entry, for label -1: -1), and their count."""
    known = distinct(label[label >= 0])
    inside = np.flatnonzero(label >= 0)
    at = np.searchsorted(known, label[inside])
    size = np.bincount(at, minlength=len(known)).astype(np.float64)
    place = np.column_stack([mean_of(at, tree.leaf.mean[inside, a], size) for a in (0, 1)])
    rank = order(street.fronts if street else [], place) if len(known) else np.empty(0, np.int64)
    number = np.full(int(label.max()) + 2, -1, np.int64)
    number[known[rank]] = np.arange(len(known))
    return number, len(known)


def _notes(scan: Scan, ground: Ground | None, count: int) -> tuple[str, ...]:
    """What the reader must know about the split, as sentences."""
    lost = "no ground was measured: heights count from each building's lowest point"
    none = f"no building in {scan.name}: nothing rises from the ground"
    return (*([lost] if ground is None else []), *([] if count else [none]))


def _cuts_of(street: Street, number: Int) -> dict[int, tuple[tuple[tuple[float, float], float], ...]]:
    """Cuts (x, y, m local; posterior) on the border of every building."""
    out: dict[int, list[tuple[tuple[float, float], float]]] = {}
    building, hidden = street.building_of_segment(), street.hidden_fronts()
    for f, front in enumerate(street.fronts):
        if f in hidden:
            continue
        for i, cut in enumerate(street.cuts[f]):
            d = street.profiles[f].offset_at(np.array([cut.s]))[0]
            x, y = front.origin + cut.s * front.along + d * front.out
            sides = {
                int(number[building[street.first[f] + i]]),
                int(number[building[street.first[f] + i + 1]]),
            }
            for b in sides if len(sides) == 2 else ():
                out.setdefault(b, []).append(((float(x), float(y)), float(cut.posterior)))
    return {b: tuple(c) for b, c in out.items()}


def _building(
    tree: Octree,
    b: int,
    index: Int,
    own: Int,
    ground: Ground | None,
    cuts: tuple[tuple[tuple[float, float], float], ...],
    footprints: Sequence[Footprint],
) -> Building:
    """One Building noun; its ground is the terrain under its lowest leaves."""
    mean = tree.leaf.mean[own]
    foot = float(mean[:, 2].min()) if ground is None else float(np.median(mean[:, 2] - ground.height(mean)))
    known = footprint_of(mean[:, :2], footprints)
    return Building(
        f"B{b + 1:02d}",
        index,
        foot,
        known.address if known else None,
        known.ring if known else None,
        cuts=cuts,
        notes=(f"footprint {known.id}",) if known else (),
    )
