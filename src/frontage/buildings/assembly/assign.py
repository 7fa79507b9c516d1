"""Assign every leaf to its building, to the occluders, or to neither."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from frontage.buildings.assembly.collect import BuildingSplit, collect
from frontage.buildings.assembly.occluders import find_occluders
from frontage.buildings.assembly.segments import SegmentedStreet
from frontage.buildings.cloud import StreetCloud
from frontage.buildings.fronts.wall_map import WallMap
from frontage.buildings.groups import grouped
from frontage.buildings.split.maps import same_footprint
from frontage.geometry.arrays import Array, Bool, Float, Int, distinct
from frontage.model.masonry import MASONRY

_ATTACHED_M = 2.0  # m from a wall within which loose cells before it are examined
_RELIEF_M = MASONRY.relief  # m before a wall: still its relief
_OFF_GROUND_M = 0.05  # m: leaves of a wall further from the terrain than this are not ground
_FRONT_WALL_M = 1.5  # m before a front; wall cells further out are not part of it


@dataclass(frozen=True, eq=False)
class _LeafPlaces:
    """Where the leaves (m,) lie: nearest front, distance to it, place s along and d before it, m."""

    front: Int
    distance: Array
    s: Float
    d: Float


def assign_points(cloud: StreetCloud, walls: WallMap, street: SegmentedStreet) -> BuildingSplit:
    """Gives every leaf its building, takes the occluders out, and puts the split together."""
    tree = cloud.tree
    places = _places(cloud, walls, street)
    on_wall = (places.distance < tree.level.size) & walls.cells[tree.of_leaf]
    ground = cloud.ground_leaves & ~(on_wall & (np.abs(cloud.leaf_height) > _OFF_GROUND_M))
    segment = street.segment(places.front, places.s)
    near, loose = _near(cloud, places, ground)
    building = street.building_of_segment()
    if cloud.footprints:
        pairs = same_footprint(building[segment], near, tree.leaf.mean[:, :2], cloud.footprints)
        first = {int(b): int(np.argmax(building == b)) for b in distinct(building)}
        street = replace(street, joins=tuple((first[a], first[b]) for a, b in pairs))
        building = street.building_of_segment()
    occluder = loose | _occluders(cloud, walls, places.d, near & ~ground)
    label = np.where(near & ~occluder, building[segment], -1)
    return collect(cloud, label, ground, occluder, street)


def _places(cloud: StreetCloud, walls: WallMap, street: SegmentedStreet) -> _LeafPlaces:
    """Finds the nearest front of every leaf, and the leaf's place along and before it."""
    leaf = cloud.tree.leaf
    owner = np.full(len(walls.xy), -1, np.int64)
    for f, front in enumerate(street.fronts):
        owner[front.members] = f
    used = np.flatnonzero(owner >= 0)
    found = cKDTree(walls.xy[used]).query(leaf.mean[:, :2])
    distance, nearest = np.asarray(found[0]), np.asarray(found[1])
    front_of_leaf = owner[used[nearest]]
    s, d = np.zeros(len(leaf)), np.zeros(len(leaf))
    sort, edge = grouped(front_of_leaf, len(street.fronts))
    for f, front in enumerate(street.fronts):
        own = sort[edge[f] : edge[f + 1]]
        s[own], d[own] = front.coordinates(leaf.mean[own, :2])
        d[own] -= street.profiles[f].face_at(s[own])
    return _LeafPlaces(front_of_leaf, distance, s, d)


def _near(cloud: StreetCloud, places: _LeafPlaces, ground: Bool) -> tuple[Bool, Bool]:
    """Returns the leaves (m,) that may be a building's, and those that stand clear of every building.

    Behind a wall, everything within the depth of a building may belong to it; before the wall, what lies
    within two metres. A cloud without ground was cut out by hand, and all of it was chosen.
    """
    behind = (places.d <= _RELIEF_M) & (places.distance <= cloud.options.max_depth)
    close = behind | (places.distance <= _ATTACHED_M)
    near = close & ~ground
    is_low = cloud.leaf_height < -cloud.options.ground_tolerance
    if cloud.ground is None:
        near[:] = True
    near &= ~(is_low & (places.distance > cloud.tree.level.size * 2))
    return near, ~near & ~ground & ~is_low


def _occluders(cloud: StreetCloud, walls: WallMap, d: Float, free: Bool) -> Bool:
    """Returns the occluders among the leaves `free` (m,) near a wall; coarse cells are judged.

    d (m,) m: how far each leaf lies before its front
    """
    tree = cloud.tree
    n = len(tree.level)
    count = np.bincount(tree.of_leaf[free], minlength=n)
    cell_d = np.bincount(tree.of_leaf[free], weights=d[free], minlength=n) / np.maximum(count, 1)
    upright = walls.cells & (cell_d < _FRONT_WALL_M)
    return find_occluders(cloud, cell_d, count > 0, upright)[tree.of_leaf] & free
