"""Every main facade of a building (paper A, sections 2.1 and 2.2)."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.facades.build import build_facade
from frontage.facades.cells import CellMap, contrast, largest_part, occupied
from frontage.facades.cloud import Cloud, prepare, voxel_first
from frontage.facades.options import FacadeOptions
from frontage.facades.paper import paper_plane
from frontage.facades.refine import Wall, refine_wall
from frontage.facades.search import search_plane
from frontage.facades.street import Side, seen_through, side_from_evidence, side_from_rays
from frontage.geometry.arrays import Float, Int
from frontage.geometry.plane import facade_axes
from frontage.model.building import Building
from frontage.model.estimate import Failed
from frontage.model.facade import Facade
from frontage.model.scan import Scan

_FEWEST = 100  # points: below, neither noise nor outline can be measured
_PARALLEL = float(np.cos(np.radians(15.0)))
_PATIENCE = 4  # rejected planes in a row before the search ends
_STOREY = 2.0  # m, least height of a facade
_PIER = 1.0  # m, least width
_FRONT = 0.35  # m: claddings, plinths and bent parts this near the plane shape the outline too
_SEEN_THROUGH = 0.5  # share of a wall's points measured through another facade that makes it an interior
_SLACK = 0.25  # m that refinement may move the plane at the facade's ends
_SHUT = 0.10  # m: what is this near the plane closes it; window frames lie deeper
_CONTRAST = 2.0  # wall area over that of neighbouring slabs: a bush or a furnished room has 1
_LEAK = 0.15  # share of the chance crossings of shut cells that an interior may still have (curtains, frames)
_GRAZING = 0.25  # sine of the angle (15 degrees) below which a surface returns nothing
_SIGHTS = 500  # lines of sight per plausible place
_AROUND = 60_000  # points of the surroundings kept without rays
_RAYS = 20_000  # lines of sight sampled per question


@dataclass(frozen=True, eq=False)
class Front:
    """A wall (oriented: normal into the building), its raster and its street side."""

    wall: Wall
    cells: CellMap
    side: Side


def find_facades(
    scan: Scan, building: Building, options: FacadeOptions | None = None, seed: int = 0
) -> tuple[Facade | Failed, ...]:
    """Every main facade of `building`, the one with the most wall first ("B07/F1").

    scan      working cloud: the building and its surroundings, which only help to tell the street side
    seed      of the sampling; same input and seed give the same facades

    Steps: thin to equal area and measure noise; search the plane with the most wall (LO-MSAC); refine it
    on all points near it; tell its street side; take its prism away and search on; drop what was
    seen through another facade. Returns `Failed` (F101 too few points, F102 no wall) instead of raising.
    """
    options = options or FacadeOptions()
    rng = np.random.default_rng(seed)
    index = building.index[np.isfinite(scan.xyz[building.index]).all(1)]
    if len(index) < _FEWEST:
        return (
            Failed(
                "F101",
                f"building {building.id} has {len(index)} points; a facade needs {_FEWEST}",
                "use a denser scan, or merge this building with its neighbour",
            ),
        )
    cloud = prepare(scan.xyz[index], index, rng, scan.sigma_range)
    around = _surroundings(scan, cloud, rng)
    if options.method == "paper":
        fronts = _paper_front(scan, cloud, around, building, options, rng)
    else:
        fronts = _all_fronts(scan, cloud, around, building, options, rng)
        fronts = _drop_interiors(fronts, scan, cloud, rng)
    if not fronts:
        return (
            Failed(
                "F102",
                f"building {building.id} has no upright plane of {options.min_area:g} m2 or more",
                "lower facades.min_area, or set facades.levelled = false if z is not the plumb line",
            ),
        )
    fronts.sort(key=lambda f: -f.cells.area)
    return tuple(
        build_facade(f"{building.id}/F{k}", building, scan, cloud, f.wall, f.cells, f.side, options, rng)
        for k, f in enumerate(fronts, 1)
    )


def _surroundings(scan: Scan, cloud: Cloud, rng: np.random.Generator) -> Float:
    """A few thousand points (k, 3) of building and surroundings, evenly in space:
    what lines of sight can meet.
    """
    if scan.has_origins:
        return np.empty((0, 3))
    finite = scan.xyz[np.isfinite(scan.xyz).all(1)]
    thin = voxel_first(finite, max(0.25, cloud.cell))
    return finite[thin[rng.permutation(len(thin))[:_AROUND]]]


def _all_fronts(
    scan: Scan,
    cloud: Cloud,
    around: Float,
    building: Building,
    options: FacadeOptions,
    rng: np.random.Generator,
) -> list[Front]:
    """Sequential search: the plane with the most wall, then the same on what it leaves."""
    fronts: list[Front] = []
    left, rejected = cloud.thin, 0
    while rejected < _PATIENCE and len(fronts) < options.max_facades and len(left) > 10:
        found = search_plane(cloud.xyz[left], cloud, options, rng)
        if found is None:
            break
        front, used = _front_at(*found, left, scan, cloud, around, building, options, rng)
        largest = max((f.cells.area for f in fronts), default=0.0)
        if front is not None and _is_facade(front, cloud.xyz[left], largest, options):
            q = front.wall.coordinates(cloud.xyz[left])
            used |= (np.abs(q[:, 1]) < _FRONT) & front.cells.within(q[:, 0], q[:, 2])
            # a balcony front or a recess belongs to the facade that has it; what stands across is another
            if not any(_is_layer_of(front, f, cloud, options) for f in fronts):
                fronts.append(front)
            rejected = 0
        else:
            rejected += 1
        left = left[~used]
    return fronts


def _is_facade(front: Front, left: Float, largest: float, options: FacadeOptions) -> bool:
    """Large enough in area, width and height, mostly wall where it claims to be, and a surface,
    not a volume.
    """
    cells = front.cells
    width, height = cells.size
    if cells.area < max(options.min_area, options.min_share * largest):
        return False
    if width < _PIER or height < _STOREY or cells.coverage < 0.25:
        return False
    q = front.wall.coordinates(left)
    return contrast(q[:, 0], q[:, 1], q[:, 2], cells, front.wall.threshold) >= _CONTRAST


def _is_layer_of(front: Front, facade: Front, cloud: Cloud, options: FacadeOptions) -> bool:
    """Whether `front` is parallel to an accepted facade and mostly within its prism."""
    if abs(front.wall.normal @ facade.wall.normal) < _PARALLEL:
        return False
    q = facade.wall.coordinates(cloud.xyz[front.wall.inliers])
    prism = (q[:, 1] > -options.depth_front) & (q[:, 1] < options.depth_back)
    return bool((prism & facade.cells.within(q[:, 0], q[:, 2])).mean() > 0.5)


def _front_at(
    normal: Float,
    point: Float,
    left: Int,
    scan: Scan,
    cloud: Cloud,
    around: Float,
    building: Building,
    options: FacadeOptions,
    rng: np.random.Generator,
) -> tuple[Front | None, np.ndarray]:
    """Refine and orient the plane found;
    also which of the points `left` it used up (at least those on it).
    """
    q = (cloud.xyz[left] - point) @ facade_axes(normal)
    near = np.abs(q[:, 1]) < 2.0 * cloud.threshold
    if near.sum() < 10:
        return None, near
    region = largest_part(*occupied(q[near, 0], q[near, 2], cloud.cell), cloud.cell, q[near])
    if region is None:
        return None, near
    used = near & region.within(q[:, 0], q[:, 2])
    if region.area < 0.5 * options.min_area:
        return None, used
    # the full cloud is read once; a slab of it serves every further step
    slab, rows = cloud.slab(normal, point, options.depth_front + _SLACK)
    wall = refine_wall(slab, normal, point, region, options, rng)
    if wall is None or abs(wall.normal[2]) > np.sin(np.radians(options.max_lean)):
        return None, used
    votes = cloud.xyz[left[used]]
    cells = _raster(wall, slab, votes)
    again = None if cells is None else refine_wall(slab, wall.normal, wall.point, cells, options, rng)
    front = orient(again or wall, scan, slab, around, votes, building.ground_z, rng)
    if front is None:
        return None, used
    return replace(front, wall=replace(front.wall, inliers=rows[front.wall.inliers])), used


def orient(
    wall: Wall,
    scan: Scan,
    cloud: Cloud,
    around: Float,
    votes: Float,
    ground_z: float,
    rng: np.random.Generator,
) -> Front | None:
    """Raster of the wall and its street side; the normal is turned into the building."""
    cells = _raster(wall, cloud, votes)
    if cells is None:
        return None
    inliers = wall.inliers if len(wall.inliers) <= _RAYS else rng.choice(wall.inliers, _RAYS, replace=False)
    side = side_from_rays(wall, cloud.xyz[inliers], scan.sensor_of(cloud.index[inliers]))
    if side is None:
        side = side_from_evidence(wall, cells, around, ground_z)
    if side.sign < 0:
        return Front(wall, cells, side)
    turned = wall.flipped()
    mirrored = _raster(turned, cloud, votes)
    sensors = side.sensors * np.array([-1.0, -1.0, 1.0])
    return None if mirrored is None else Front(turned, mirrored, Side(-1, side.told_by, sensors, side.odds))


def _raster(wall: Wall, cloud: Cloud, votes: Float) -> CellMap | None:
    """Cells of the points near the plane: the outline from all of them, the wall from those on it.

    votes (n, 3): points that say which connected part of the plane is meant.
    """
    q = wall.coordinates(cloud.xyz)
    near = np.abs(q[:, 1]) < max(_FRONT, wall.threshold)
    if not near.any():
        return None
    count, corner = occupied(q[near, 0], q[near, 2], cloud.cell)
    part = largest_part(count, corner, cloud.cell, wall.coordinates(votes))
    if part is None:
        return None
    on = np.abs(q[:, 1]) < wall.threshold
    shut = q[:, 1] < _SHUT  # what stands in front of the wall shuts it as well
    return CellMap(
        corner, cloud.cell, part.marked(q[on, 0], q[on, 2]), part.whole, part.marked(q[shut, 0], q[shut, 2])
    )


def _drop_interiors(fronts: list[Front], scan: Scan, cloud: Cloud, rng: np.random.Generator) -> list[Front]:
    """Leave out walls most of whose points were seen through the openings of a larger facade."""
    kept = []
    for inner in fronts:
        some = inner.wall.inliers
        some = some if len(some) <= _RAYS else rng.choice(some, _RAYS, replace=False)
        larger = (f for f in fronts if f.cells.area > inner.cells.area)
        if not any(_behind(outer, inner, some, scan, cloud) for outer in larger):
            kept.append(inner)
    return kept


def _behind(outer: Front, inner: Front, rows: Int, scan: Scan, cloud: Cloud) -> bool:
    """Whether `inner`, with the points `rows` of the cloud, is an interior behind `outer`.

    Without rays: from some plausible place in front of `outer` most of them are seen,
    not edge-on, through the holes of `outer` and hardly any through what is shut.
    """
    wall, xyz = outer.wall, cloud.xyz[rows]
    if outer.side.told_by == "rays":
        return seen_through(wall, outer.cells, xyz, scan.sensor_of(cloud.index[rows]))[0] > _SEEN_THROUGH
    shut = float(outer.cells.shut.sum() / max(outer.cells.whole.sum(), 1))
    for place in outer.side.sensors @ wall.axes.T + wall.point:
        sight = place - inner.wall.point
        if abs(sight @ inner.wall.normal) < _GRAZING * np.linalg.norm(sight):
            continue
        some = xyz[:: max(1, len(xyz) // _SIGHTS)]
        inside, closed = seen_through(wall, outer.cells, some, place[None], 0.5)
        if inside > _SEEN_THROUGH and closed < _LEAK * inside * shut:
            return True
    return False


def _paper_front(
    scan: Scan,
    cloud: Cloud,
    around: Float,
    building: Building,
    options: FacadeOptions,
    rng: np.random.Generator,
) -> list[Front]:
    """The paper's main plane as it is, with the frame, outline and covariance of the common path."""
    found = paper_plane(cloud.xyz, options.paper_threshold, options.paper_iterations, rng)
    if found is None or abs(found[0][2]) > 0.9:
        return []
    normal, centre, inliers = found
    fitted = refine_wall(cloud, normal, centre, None, options, rng)
    if fitted is None:
        return []
    wall = Wall(
        normal,
        centre,
        fitted.sigma,
        options.paper_threshold,
        fitted.covariance,
        np.flatnonzero(inliers),
        fitted.correlation,
        fitted.dof,
    )
    front = orient(wall, scan, cloud, around, cloud.xyz[inliers], building.ground_z, rng)
    return [] if front is None else [front]
