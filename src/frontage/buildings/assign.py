"""Every leaf to its building, to the occluders, or to neither."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from frontage.buildings.assemble import Street
from frontage.buildings.collect import BuildingSplit, collect
from frontage.buildings.ground import Ground
from frontage.buildings.maps import same_footprint
from frontage.buildings.occluders import is_occluder
from frontage.buildings.octree import Octree, cell_height, ground_leaves, leaf_height
from frontage.buildings.options import BuildingOptions
from frontage.buildings.voxels import grouped
from frontage.buildings.walls import Columns
from frontage.geometry.arrays import Array, Bool, Float, Int, distinct
from frontage.model import Footprint, Scan
from frontage.model.masonry import MASONRY

_ATTACHED = 2.0  # m, distance to a wall within which loose cells before it are looked at closely


def assign(
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
    front_of_leaf, distance, s, d = _places(tree, columns, street)
    ground_leaf = ground_leaves(tree, ground, options)
    on_wall = (distance < tree.level.size) & wall[tree.of_leaf]
    ground_leaf &= ~(on_wall & (np.abs(leaf_height(tree, ground)) > 0.05))
    segment = street.segment(front_of_leaf, s)
    near, loose = _near(tree, distance, d, ground_leaf, ground, options)
    building = street.building_of_segment()
    if footprints:
        pairs = same_footprint(building[segment], near, tree.leaf.mean[:, :2], footprints)
        first = {int(b): int(np.argmax(building == b)) for b in distinct(building)}
        street = replace(street, joins=tuple((first[a], first[b]) for a, b in pairs))
        building = street.building_of_segment()
    label = building[segment]
    label = np.where(near, label, -1)
    occluder = loose | _occluders(tree, d, ground_leaf, near, wall, ground)
    return collect(
        scan, tree, np.where(occluder, -1, label), ground_leaf, occluder, ground, spacing, footprints, street
    )


def _places(tree: Octree, columns: Columns, street: Street) -> tuple[Int, Float, Float, Float]:
    """Of every leaf (m,): its nearest front, the distance to it, the place along and before it, m."""
    owner = np.full(len(columns.xy), -1, np.int64)
    for f, front in enumerate(street.fronts):
        owner[front.members] = f
    used = np.flatnonzero(owner >= 0)
    found = cKDTree(columns.xy[used]).query(tree.leaf.mean[:, :2])
    distance, nearest = np.asarray(found[0]), np.asarray(found[1])
    front_of_leaf = owner[used[nearest]]
    s, d = np.zeros(len(tree.leaf)), np.zeros(len(tree.leaf))
    sort, edge = grouped(front_of_leaf, len(street.fronts))
    for f, front in enumerate(street.fronts):
        own = sort[edge[f] : edge[f + 1]]
        s[own], d[own] = front.coordinates(tree.leaf.mean[own, :2])
        d[own] -= street.profiles[f].offset_at(s[own])
    return front_of_leaf, distance, s, d


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
    behind = (d <= MASONRY.relief) & (distance <= options.max_depth)
    close = behind | (distance <= _ATTACHED)
    near = close & ~ground_leaf
    low = leaf_height(tree, ground) < -options.ground_tolerance
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
    height = cell_height(tree.level, ground)
    out = is_occluder(tree.level, tree.shape, tree.touch, cell_d, height, count > 0, upright)
    return out[tree.of_leaf] & free
