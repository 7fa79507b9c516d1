"""Divide a street cloud into buildings (paper A, section 2.1), step by step."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.buildings.assembly.assign import assign_points
from frontage.buildings.assembly.collect import BuildingSplit, as_seen, collect, nothing_found
from frontage.buildings.assembly.segments import SegmentedStreet
from frontage.buildings.cloud import StreetCloud, prepare_cloud
from frontage.buildings.fronts.find import StreetFronts, find_fronts
from frontage.buildings.fronts.leaves import colour_of
from frontage.buildings.fronts.profile import FrontProfile, front_profile
from frontage.buildings.fronts.wall_map import WallMap, map_walls
from frontage.buildings.groups import grouped
from frontage.buildings.octree.components import component_buildings
from frontage.buildings.options import BuildingOptions
from frontage.buildings.split.find import Cut, find_cuts
from frontage.buildings.split.gaps import open_bins
from frontage.buildings.split.maps import mapped_row
from frontage.model import Footprint, Scan
from frontage.model.canonical import canonical_axes, is_mirrored, turned

_DEFAULTS = BuildingOptions()
_FEWEST_POINTS = 100  # points of a building, at least


def find_buildings(
    scan: Scan,
    options: BuildingOptions = _DEFAULTS,
    footprints: Sequence[Footprint] = (),
) -> BuildingSplit:
    """Divides a street cloud into buildings, ground, occluders and the rest.

    Paper A, section 2.1, distributes the points into the cells of an octree and takes each connected
    component as a building; ``method="paper"`` stops there. Beyond the paper, ground and occluders are taken
    out, and the components are cut into houses along their street fronts (docs/methods/buildings.md). Where
    footprints are given, they decide.

    Neither the order of the points nor the direction of north decides anything: all steps work in the
    canonical frame of the cloud. Buildings are numbered B01, B02, ... along the longest front from left to
    right, then across the street.
    Raises InputError when the cloud is too wide for an octree.
    """
    if len(scan) < _FEWEST_POINTS:
        return nothing_found(scan, f"no building: {_too_few(scan)}")
    axes = canonical_axes(scan.xyz)
    mapped = [replace(f, ring=f.ring @ axes[:2, :2]) for f in footprints]
    cloud = replace(prepare_cloud(turned(scan, axes), options, mapped), mirrored=is_mirrored(axes))
    return as_seen(_split(cloud), axes)


def _split(cloud: StreetCloud) -> BuildingSplit:
    """Divides a cloud in its canonical frame."""
    if cloud.options.method == "paper":
        return _connected_components(cloud)
    walls = map_walls(cloud)
    fronts = find_fronts(cloud, walls)
    if not len(fronts):
        walls = map_walls(cloud, sparse=True)
        fronts = find_fronts(cloud, walls)
    if not len(fronts):
        return _whole_or_none(cloud)
    street = _cut_into_houses(cloud, walls, fronts)
    return assign_points(cloud, walls, street)


def _too_few(scan: Scan) -> str:
    """Says how many points are too few."""
    return f"{scan.name} has {len(scan)} points, fewer than {_FEWEST_POINTS}"


def _connected_components(cloud: StreetCloud) -> BuildingSplit:
    """Splits as paper A does: every connected component of the octree's cells is a building."""
    label = component_buildings(cloud.tree, cloud.above_ground)[cloud.tree.of_leaf]
    return collect(replace(cloud, footprints=()), label, cloud.ground_leaves)


def _cut_into_houses(cloud: StreetCloud, walls: WallMap, fronts: StreetFronts) -> SegmentedStreet:
    """Measures the profile of every front and cuts it into houses."""
    tree, options = cloud.tree, cloud.options
    colour = colour_of(cloud)
    leaf_sort, leaf_edge = grouped(fronts.of_cell[tree.of_leaf], len(fronts))
    profiles: list[FrontProfile] = []
    cuts: list[tuple[Cut, ...]] = []
    for f, front in enumerate(fronts.fronts):
        own = leaf_sort[leaf_edge[f] : leaf_edge[f + 1]]
        profile = front_profile(cloud, walls, front, own, colour)
        profiles.append(profile)
        if not options.split:
            cuts.append(())
            continue
        row = mapped_row(front, profile, cloud.footprints, options.snap) if cloud.footprints else None
        s, d = front.coordinates(tree.level.mean[:, :2])
        gaps = open_bins(profile, s, d, cloud.cell_height, tree.level.weight)
        cuts.append(find_cuts(profile, options, gaps, row, tree.level.size))
    return SegmentedStreet(fronts.fronts, tuple(profiles), tuple(cuts), options.max_depth, walls.xy)


def _whole_or_none(cloud: StreetCloud) -> BuildingSplit:
    """Splits a cloud without walls: over no ground at all it is one building that was cut out, else none."""
    leaf = cloud.tree.leaf
    cloud = replace(cloud, footprints=())
    tall = float(np.ptp(leaf.mean[:, 2]))
    if cloud.ground is not None or tall < cloud.options.min_wall_height:
        ground = cloud.ground_leaves
        loose = ~ground & (cloud.leaf_height > 0)
        return collect(cloud, np.full(len(leaf), -1, np.int64), ground, loose)
    split = collect(cloud, np.zeros(len(leaf), np.int64), np.zeros(len(leaf), bool))
    note = "no wall was recognised and no ground was measured: the whole cloud is taken as one building"
    return replace(split, notes=(*split.notes, note))
