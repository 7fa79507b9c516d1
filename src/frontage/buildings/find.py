"""The building stage, step by step."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from frontage.buildings.assemble import Street
from frontage.buildings.ground import Ground, find_ground
from frontage.buildings.maps import footprint_of, party_walls
from frontage.buildings.occluders import is_occluder
from frontage.buildings.options import BuildingOptions
from frontage.buildings.paper import component_buildings
from frontage.buildings.profile import Paint, Profile, paint_of, profile_of
from frontage.buildings.spacing import measure_spacing
from frontage.buildings.split import Cut, find_cuts
from frontage.buildings.street import face_street, order
from frontage.buildings.voxels import Level, Shape, adjacency, components, leaves, parents, shape_of
from frontage.buildings.walls import Columns, Front, find_fronts, wall_cells, wall_columns
from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.model import Building, Footprint, Scan

_DEFAULTS = BuildingOptions()
_FEWEST = 100  # points; fewer make no building
_ATTACHED = 2.0  # m, distance to a wall within which loose cells before it are looked at closely


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


@dataclass(frozen=True, eq=False)
class Octree:
    """Two levels of octree cells over the points, how the coarse ones touch and what lies in them."""

    leaf: Level
    of_point: Array
    level: Level
    of_leaf: Array
    touch: sparse.csr_array
    shape: Shape


def find_buildings(
    scan: Scan,
    options: BuildingOptions = _DEFAULTS,
    footprints: Sequence[Footprint] = (),
) -> BuildingSplit:
    """Divide a cloud into buildings, ground, occluders and the rest.

    Paper A, section 2.1: octree cells and connected components (`method="paper"` stops there).
    Beyond it: ground
    and occluders are taken out, and a component is cut into houses along its fronts (docs/buildings.md).
    Buildings are numbered B01, B02, ... along the longest front from left to right, then across the street.
    """
    if len(scan) < _FEWEST:
        return _nothing(
            scan, float("nan"), f"no building: {scan.name} has {len(scan)} points, fewer than {_FEWEST}"
        )
    spacing, coarse = measure_spacing(scan.xyz)
    tree = _octree(scan.xyz, options.cell or max(0.25, 3 * coarse))
    ground = find_ground(tree.level, tree.shape, np.diff(tree.touch.indptr), options)
    height = _height(tree.level, ground)
    above = height > options.ground_tolerance
    if options.method == "paper":
        label = component_buildings(tree.level, tree.touch, above)
        return _collect(
            scan, tree, label[tree.of_leaf], _ground_leaves(tree, ground, options), None, ground, spacing, ()
        )
    wall = wall_cells(tree.level, tree.shape, above)
    columns = wall_columns(tree.level, tree.shape, wall, options)
    street = _street(scan, tree, columns, wall, ground, options, footprints)
    if not street.fronts:
        return _one_or_none(scan, tree, ground, spacing, options)
    return _assign(scan, tree, columns, street, wall, ground, spacing, options, footprints)


def _octree(xyz: Float, cell: float) -> Octree:
    leaf, of_point = leaves(xyz, cell / 2)
    level, of_leaf = parents(leaf, 1)
    touch = adjacency(level)
    return Octree(leaf, of_point, level, of_leaf, touch, shape_of(level, touch))


def _height(level: Level, ground: Ground | None) -> Float:
    """Height (m,) of the cells above ground, infinite where no ground was measured."""
    return np.full(len(level), np.inf) if ground is None else ground.height(level.mean)


def _ground_leaves(tree: Octree, ground: Ground | None, options: BuildingOptions) -> Bool:
    """Leaves (m,) that are ground: within the tolerance of the terrain, and not on a wall away
    from where it was measured."""
    if ground is None:
        return np.zeros(len(tree.leaf), bool)
    row, col = ground.cell_of(tree.leaf.mean[:, :2])
    upright = (np.abs(tree.shape.normal[:, 2]) < 0.5)[tree.of_leaf]
    return (np.abs(ground.height(tree.leaf.mean)) <= options.ground_tolerance) & (
        ground.beside[row, col] | ~upright
    )


def _street(
    scan: Scan,
    tree: Octree,
    columns: Columns,
    wall: Bool,
    ground: Ground | None,
    options: BuildingOptions,
    footprints: Sequence[Footprint],
) -> Street:
    """Fronts with their street side, profiles and cuts."""
    fronts: list[Front] = []
    profiles: list[Profile] = []
    cuts: list[tuple[Cut, ...]] = []
    paint = paint_of(scan, tree.leaf, tree.of_point)
    found = find_fronts(columns, ground, tree.level.size, options)
    if not found:
        return Street([], [], [])
    owner = np.full(len(columns.xy), -1, np.int64)
    for f, front in enumerate(found):
        owner[front.members] = f
    of_cell = owner[cKDTree(columns.xy).query(tree.level.mean[:, :2])[1]]
    for f, front in enumerate(found):
        s, d = front.coordinates(tree.level.mean[:, :2])
        near = (of_cell == f) & (s > front.lo) & (s < front.hi) & (np.abs(d) < options.max_depth)
        turned = face_street(
            front, scan, tree.level, wall, (np.where(near, s, np.nan), np.where(near, d, np.nan)), ground
        )
        own = np.flatnonzero(((of_cell == f) & wall)[tree.of_leaf])
        profile = _profile(tree, turned, own, paint, ground)
        party = party_walls(turned, profile, footprints) if footprints else None
        fronts.append(turned)
        profiles.append(profile)
        cuts.append(find_cuts(profile, options, party, tree.level.size) if options.split else ())
    return Street(fronts, profiles, cuts)


def _profile(tree: Octree, front: Front, own: Int, paint: Paint, ground: Ground | None) -> Profile:
    """The profile of a front from its wall leaves `own` (k,)."""
    mean = tree.leaf.mean[own]
    s, d = front.coordinates(mean[:, :2])
    foot = mean[:, 2] - (np.min(mean[:, 2]) if len(mean) else 0.0) if ground is None else ground.height(mean)
    lab = None if paint.lab is None else paint.lab[own]
    bright = None if paint.bright is None else paint.bright[own]
    return profile_of(front.lo, front.hi, s, d, mean[:, 2], foot, Paint(lab, bright))


def _assign(
    scan: Scan,
    tree: Octree,
    columns: Columns,
    street: Street,
    wall: Bool,
    ground: Ground | None,
    spacing: float,
    options: BuildingOptions,
    footprints: Sequence[Footprint],
) -> BuildingSplit:
    """Give every leaf its building, take the occluders out, and put the split together."""
    owner = np.full(len(columns.xy), -1, np.int64)
    for f, front in enumerate(street.fronts):
        owner[front.members] = f
    used = np.flatnonzero(owner >= 0)
    found = cKDTree(columns.xy[used]).query(tree.leaf.mean[:, :2])
    distance, nearest = np.asarray(found[0]), np.asarray(found[1])
    front_of_leaf = owner[used[nearest]]
    s, d = np.zeros(len(tree.leaf)), np.zeros(len(tree.leaf))
    for f, front in enumerate(street.fronts):
        own = front_of_leaf == f
        s[own], d[own] = front.coordinates(tree.leaf.mean[own, :2])
        d[own] -= street.profiles[f].offset_at(s[own])
    ground_leaf = _ground_leaves(tree, ground, options)
    on_wall = (distance < tree.level.size) & wall[tree.of_leaf]
    ground_leaf &= ~(on_wall & (np.abs(_leaf_height(tree, ground)) > 0.05))
    label = street.building_of_segment()[street.segment(front_of_leaf, s)]
    near, loose = _near(tree, distance, d, ground_leaf, ground, options)
    label = np.where(near, label, -1)
    occluder = loose | _occluders(tree, d, ground_leaf, near, wall, ground)
    return _collect(
        scan, tree, np.where(occluder, -1, label), ground_leaf, occluder, ground, spacing, footprints, street
    )


def _leaf_height(tree: Octree, ground: Ground | None) -> Float:
    return np.full(len(tree.leaf), np.inf) if ground is None else ground.height(tree.leaf.mean)


def _near(
    tree: Octree,
    distance: Array,
    d: Float,
    ground_leaf: Bool,
    ground: Ground | None,
    options: BuildingOptions,
) -> tuple[Bool, Bool]:
    """Leaves (m,) that may be a building's, and those that stand clear of every building.

    Behind a wall everything within the building's depth may be the building's; before it what
    hangs together with
    the wall's surroundings.
    """
    behind = (d <= 0.35) & (distance <= options.max_depth)
    close = behind | (distance <= _ATTACHED)
    near = close & ~ground_leaf
    low = _leaf_height(tree, ground) < -options.ground_tolerance
    if ground is None:  # a cut-out: all of it was chosen by hand
        near[:] = True
    near &= ~(low & (distance > tree.level.size * 2))
    return near, ~near & ~ground_leaf & ~low


def _occluders(
    tree: Octree, d: Float, ground_leaf: Bool, near: Bool, wall: Bool, ground: Ground | None
) -> Bool:
    """Occluders (leaves) among what is near a wall, judged by coarse cell."""
    n = len(tree.level)
    free = near & ~ground_leaf
    count = np.bincount(tree.of_leaf[free], minlength=n)
    cell_d = np.bincount(tree.of_leaf[free], weights=d[free], minlength=n) / np.maximum(count, 1)
    upright = wall & (cell_d < 1.5)
    height = _height(tree.level, ground)
    out = is_occluder(tree.level, tree.shape, tree.touch, cell_d, height, count > 0, upright)
    return out[tree.of_leaf] & free


def _collect(
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
    known = np.unique(label[label >= 0])
    weight = np.ones(len(label))
    place = np.array(
        [np.average(tree.leaf.mean[label == b, :2], axis=0, weights=weight[label == b]) for b in known]
    )
    rank = order(street.fronts if street else [], place) if len(known) else np.empty(0, np.int64)
    number = np.full(int(label.max()) + 2, -1, np.int64)
    number[known[rank]] = np.arange(len(known))
    of_point = number[label][tree.of_point]
    sort = np.argsort(of_point, kind="stable").astype(np.int64)
    edge = np.searchsorted(of_point[sort], np.arange(len(known) + 1))
    owners = _cuts_of(street, number) if street else {}
    buildings = tuple(
        _building(
            scan,
            tree,
            b,
            sort[edge[b] : edge[b + 1]],
            number[label] == b,
            ground,
            owners.get(b, ()),
            footprints,
        )
        for b in range(len(known))
    )
    other = sort[: edge[0]]
    leaf = tree.of_point[other]
    block = np.zeros(len(leaf), bool) if occluder is None else occluder[leaf] & ~ground_leaf[leaf]
    rest = ~ground_leaf[leaf] & ~block
    notes = (
        ()
        if ground is not None
        else ("no ground was measured: heights count from each building's lowest point",)
    )
    if not buildings:
        notes = (*notes, f"no building in {scan.name}: nothing rises from the ground")
    return BuildingSplit(buildings, other[ground_leaf[leaf]], other[block], other[rest], spacing, notes)


def _cuts_of(street: Street, number: Int) -> dict[int, tuple[tuple[tuple[float, float], float], ...]]:
    """Cuts (x, y, m local; posterior) on the border of every building."""
    out: dict[int, list[tuple[tuple[float, float], float]]] = {}
    building = street.building_of_segment()
    for f, front in enumerate(street.fronts):
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
    scan: Scan,
    tree: Octree,
    b: int,
    index: Int,
    own: Bool,
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


def _one_or_none(
    scan: Scan, tree: Octree, ground: Ground | None, spacing: float, options: BuildingOptions
) -> BuildingSplit:
    """No wall was found: what rises over no ground at all is a cut-out and stays whole; over
    ground there is none."""
    tall = float(np.ptp(tree.leaf.mean[:, 2]))
    if ground is not None or tall < options.min_wall_height:
        ground_leaf = _ground_leaves(tree, ground, options)
        loose = ~ground_leaf & (_leaf_height(tree, ground) > 0)
        return _collect(
            scan, tree, np.full(len(tree.leaf), -1, np.int64), ground_leaf, loose, ground, spacing, ()
        )
    label = components(tree.touch, np.ones(len(tree.level), bool))
    split = _collect(
        scan,
        tree,
        np.zeros_like(label)[tree.of_leaf],
        np.zeros(len(tree.leaf), bool),
        None,
        None,
        spacing,
        (),
    )
    note = "no wall was recognised and no ground was measured: the whole cloud is taken as one building"
    return BuildingSplit(
        split.buildings, split.ground, split.occluders, split.rest, spacing, (*split.notes, note)
    )


def _nothing(scan: Scan, spacing: float, note: str) -> BuildingSplit:
    none = np.empty(0, np.int64)
    return BuildingSplit((), none, none, np.arange(len(scan), dtype=np.int64), spacing, (note,))
