"""The building stage, step by step."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from frontage.buildings.assemble import Street
from frontage.buildings.assign import assign
from frontage.buildings.collect import BuildingSplit, collect
from frontage.buildings.gaps import open_bins
from frontage.buildings.ground import Ground, find_ground
from frontage.buildings.maps import mapped_row
from frontage.buildings.octree import Octree, cell_height, ground_leaves, leaf_height, octree
from frontage.buildings.options import BuildingOptions
from frontage.buildings.paper import component_buildings
from frontage.buildings.profile import Leaves, Paint, Profile, paint_of, profile_of
from frontage.buildings.spacing import measure_spacing
from frontage.buildings.split import Cut, find_cuts
from frontage.buildings.street import face_street
from frontage.buildings.voxels import components, grouped
from frontage.buildings.walls import Columns, Front, find_fronts, wall_cells, wall_columns
from frontage.geometry.arrays import Bool, Int
from frontage.model import Footprint, Scan

_DEFAULTS = BuildingOptions()
_FEWEST = 100  # points; fewer make no building


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
    tree = octree(scan.xyz, options.cell or max(0.25, 3 * coarse))
    ground = find_ground(tree.level, tree.shape, np.diff(tree.touch.indptr), options)
    height = cell_height(tree.level, ground)
    above = height > options.ground_tolerance
    if options.method == "paper":
        label = component_buildings(tree.level, tree.touch, above)
        return collect(
            scan, tree, label[tree.of_leaf], ground_leaves(tree, ground, options), None, ground, spacing, ()
        )
    wall = wall_cells(tree.level, tree.shape, above)
    columns = wall_columns(tree.level, tree.shape, wall, options)
    street = _street(scan, tree, columns, wall, ground, options, footprints)
    if not street.fronts:
        return _one_or_none(scan, tree, ground, spacing, options)
    return assign(scan, tree, columns, street, wall, ground, spacing, options, footprints)


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
        return Street([], [], [], options.max_depth)
    owner = np.full(len(columns.xy), -1, np.int64)
    for f, front in enumerate(found):
        owner[front.members] = f
    height = cell_height(tree.level, ground)
    of_cell = owner[cKDTree(columns.xy).query(tree.level.mean[:, :2])[1]]
    leaf_sort, leaf_edge = grouped(of_cell[tree.of_leaf], len(found))
    for f, front in enumerate(found):
        s, d = front.coordinates(tree.level.mean[:, :2])
        near = (of_cell == f) & (s > front.lo) & (s < front.hi) & (np.abs(d) < options.max_depth)
        turned = face_street(
            front, scan, tree.level, wall, (np.where(near, s, np.nan), np.where(near, d, np.nan)), ground
        )
        own = leaf_sort[leaf_edge[f] : leaf_edge[f + 1]]
        profile = _profile(tree, turned, own, wall, paint, ground)
        row = mapped_row(turned, profile, footprints, options.snap) if footprints else None
        fronts.append(turned)
        profiles.append(profile)
        s, d = turned.coordinates(tree.level.mean[:, :2])
        open_ = open_bins(profile, s, d, height, tree.level.weight)
        cuts.append(find_cuts(profile, options, open_, row, tree.level.size) if options.split else ())
    return Street(fronts, profiles, cuts, options.max_depth)


def _profile(
    tree: Octree, front: Front, own: Int, wall: Bool, paint: Paint, ground: Ground | None
) -> Profile:
    """The profile of a front from the leaves `own` (k,) around it; wall (m,) cells."""
    mean = tree.leaf.mean[own]
    s, d = front.coordinates(mean[:, :2])
    foot = mean[:, 2] - (np.min(mean[:, 2]) if len(mean) else 0.0) if ground is None else ground.height(mean)
    lab = None if paint.lab is None else paint.lab[own]
    bright = None if paint.bright is None else paint.bright[own]
    at = Leaves(s, d, mean[:, 2], foot, tree.leaf.size)
    return profile_of(front.lo, front.hi, at, wall[tree.of_leaf[own]], Paint(lab, bright))


def _one_or_none(
    scan: Scan, tree: Octree, ground: Ground | None, spacing: float, options: BuildingOptions
) -> BuildingSplit:
    """No wall was found: what rises over no ground at all is a cut-out and stays whole; over
    ground there is none."""
    tall = float(np.ptp(tree.leaf.mean[:, 2]))
    if ground is not None or tall < options.min_wall_height:
        ground_leaf = ground_leaves(tree, ground, options)
        loose = ~ground_leaf & (leaf_height(tree, ground) > 0)
        return collect(
            scan, tree, np.full(len(tree.leaf), -1, np.int64), ground_leaf, loose, ground, spacing, ()
        )
    label = components(tree.touch, np.ones(len(tree.level), bool))
    split = collect(
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
