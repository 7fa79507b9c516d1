"""Every main facade of a building (paper A, sections 2.1 and 2.2)."""

from dataclasses import replace

import numpy as np

from frontage.facades.build import build_facade
from frontage.facades.cells import BESIDE, CellMap, contrast
from frontage.facades.cloud import Cloud, columns, prepare
from frontage.facades.front import FRONT, RAYS, Front, Scene, measured, sketched, straightened
from frontage.facades.interiors import drop_interiors
from frontage.facades.layers import find_layers
from frontage.facades.options import FacadeOptions
from frontage.facades.paper import paper_plane
from frontage.facades.search import search_plane, stack_rise
from frontage.geometry.arrays import Bool, Float
from frontage.model.building import Building
from frontage.model.estimate import Failed
from frontage.model.facade import Facade
from frontage.model.masonry import TOLERANCES
from frontage.model.scan import Scan

_FEWEST = 100  # points: below, neither noise nor outline can be measured
_PATIENCE = 3  # rejected planes in a row before the search ends
_STOREY = 2.0  # m, least height of a facade
_PIER = 1.0  # m, least width
_END = 0.5  # m at the border of a facade in which the next one may stand
_COVERED = 0.25  # share of the outline with wall
_CONTRAST = 2.0  # wall area over that of slabs beside it: a bush or a furnished room has 1
_LAYERED = 100_000  # points that tell whether a larger wall is before a plane
_STACK = 3.0  # voxels on top of each other that may be a wall
_THINNED = 0.5  # one point per voxel leaves cells of a turned raster empty: share of the area that must show


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
    index = building.index
    everything = len(index) == len(scan) and np.array_equal(index, np.arange(len(scan)))
    xyz = scan.xyz if everything else np.take(scan.xyz, index, axis=0)
    if not np.isfinite(xyz.sum()):  # a sum with anything that is no number is no number
        finite = np.isfinite(xyz).all(1)
        index, xyz = index[finite], xyz[finite]
    if len(index) < _FEWEST:
        return (_too_few(building, len(index)),)
    cloud = prepare(xyz, index, rng, scan.sigma_range)
    scene = Scene(scan, cloud, building.ground_z, options)
    fronts = _paper_front(scene, rng) if options.method == "paper" else _fronts(scene, rng)
    if not fronts:
        return (
            Failed(
                "F102",
                f"building {building.id} has no upright plane of {options.min_area:g} m2 or more",
                "lower facades.min_area, or set facades.levelled = false if z is not the plumb line",
            ),
        )
    fronts.sort(key=lambda f: -f.cells.area)
    return tuple(build_facade(f"{building.id}/F{k}", front, scene, rng) for k, front in enumerate(fronts, 1))


def _too_few(building: Building, number: int) -> Failed:
    return Failed(
        "F101",
        f"building {building.id} has {number} points; a facade needs {_FEWEST}",
        "use a denser scan, or merge this building with its neighbour",
    )


def _fronts(scene: Scene, rng: np.random.Generator) -> list[Front]:
    """Every front: found among a bounded number of points, then each measured with all of them."""
    few = replace(scene, cloud=scene.cloud.bounded())
    found = drop_interiors(sketch_fronts(few, rng), few, rng)
    final = (_measured(f, few.cloud.xyz[f.wall.inliers], scene, rng) for f in found)
    least = scene.options.min_area
    return [front for front in final if front is not None and _is_large(front.cells, least)]


def _measured(front: Front, votes: Float, scene: Scene, rng: np.random.Generator) -> Front | None:
    """A sketched front, measured; on the wall before it, if that is larger than what was found.

    Bars and panes at several depths may hold more voxels than their wall, but not more area at one depth.
    """
    found = measured(front, votes, scene, rng)
    if found is None:
        return None
    q, wall = found.slab.q[:: len(found.slab.q) // _LAYERED + 1], found.wall
    q = q[np.abs(q[:, 1]) < FRONT]
    flat = found.cells.flat(q[:, 0], q[:, 2])
    inside = found.cells.whole.ravel()[flat]
    layers = find_layers(q[inside, 1], flat[inside], found.cells, wall.sigma, (-FRONT, FRONT))
    own = max((layer.area for layer in layers if layer.y == 0.0), default=0.0)
    ahead = [layer for layer in layers if layer.y < 0.0 and layer.area > own]
    if not ahead:
        return found
    y = max(ahead, key=lambda layer: layer.area).y
    return measured(replace(found, wall=replace(wall, point=wall.point + y * wall.normal)), votes, scene, rng)


def sketch_fronts(scene: Scene, rng: np.random.Generator) -> list[Front]:
    """Sequential search among thinned points: the plane with the most wall, then the same on what it leaves.

    The search ends when no plane holds enough points for a facade, connected or not.
    """
    cloud, options = scene.cloud, scene.options
    thin = np.take(cloud.xyz, cloud.thin, axis=0)
    rise = stack_rise(thin, cloud.cell)
    if options.levelled:  # ground and roofs are no walls
        thin, rise = thin[rise >= _STACK], rise[rise >= _STACK]
    whole = thin
    fronts: list[Front] = []
    rejected = 0
    while rejected < _PATIENCE and len(fronts) < options.max_facades and len(thin) > 10:
        largest = max((f.cells.area for f in fronts), default=0.0)
        least = max(options.min_area, options.min_share * largest)
        found = search_plane(thin, rise, cloud, options, rng)
        if found is None:
            break
        plane = straightened(*found, thin, cloud, options.levelled, rng)
        if plane.held < least or not plane.own.any():
            break
        used, front = plane.own, None
        if plane.area >= _THINNED * least:
            front = sketched(plane.normal, plane.point, plane.sigma, thin[used], scene, rng)
        if front is None or not _is_large(front.cells, least):
            rejected += 1
            thin, rise = thin[~used], rise[~used]
            continue
        q = front.wall.coordinates(thin)
        used = used | ((np.abs(q[:, 1]) < FRONT) & front.cells.within(q[:, 0], q[:, 2]))
        if not _is_surface(front, whole, cloud):
            rejected += 1
        else:
            rejected = 0
            used |= _in_prism(q, front, options)
            if not any(_is_layer_of(front, f, cloud, options) for f in fronts):
                fronts.append(front)
        thin, rise = thin[~used], rise[~used]
    return fronts


def _is_large(cells: CellMap, least: float) -> bool:
    """Large enough in area, width and height, and mostly wall where it claims to be."""
    width, height = cells.size
    return cells.area >= least and width >= _PIER and height >= _STOREY and cells.coverage >= _COVERED


def _is_surface(front: Front, thin: Float, cloud: Cloud) -> bool:
    """Whether the plane stands out from what lies beside it among all thinned points (n, 3), those of
    planes already taken away as well: a slice of a bush would stand alone without its neighbours.
    """
    q = columns(thin - front.wall.point, front.wall.axes)
    q = q[np.abs(q[:, 1]) < BESIDE]
    return contrast(q[:, 0], q[:, 1], q[:, 2], front.cells, cloud.threshold) >= _CONTRAST


def _in_prism(q: Float, front: Front, options: FacadeOptions) -> Bool:
    """Which points (n, 3), facade coordinates, belong to an accepted facade: its balconies, recesses, bays.

    What stands at its ends (the next face round the corner) does not.
    """
    deep = (q[:, 1] > -options.depth_front) & (q[:, 1] < options.depth_back)
    return np.asarray(deep & front.cells.within(q[:, 0], q[:, 2], front.cells.shrunk(_END)), np.bool_)


def _is_layer_of(front: Front, facade: Front, cloud: Cloud, options: FacadeOptions) -> bool:
    """Whether `front` is parallel to an accepted facade and mostly within its prism."""
    if abs(front.wall.normal @ facade.wall.normal) < TOLERANCES.parallel_cos:
        return False
    some = cloud.xyz[front.wall.inliers[:: len(front.wall.inliers) // RAYS + 1]]
    return bool(_in_prism(facade.wall.coordinates(some), facade, options).mean() > 0.5)


def _paper_front(scene: Scene, rng: np.random.Generator) -> list[Front]:
    """The paper's main plane as it is, with the frame, outline and covariance of the common path."""
    cloud, options = scene.cloud, scene.options
    found = paper_plane(cloud.xyz, options.paper_threshold, options.paper_iterations, rng)
    if found is None or abs(found[0][2]) > 0.9:
        return []
    normal, centre, inliers = found
    sketch = sketched(normal, centre, options.paper_threshold / 3, cloud.xyz[inliers], scene, rng)
    front = None if sketch is None else measured(sketch, cloud.xyz[inliers], scene, rng)
    if front is None:
        return []
    sign = 1.0 if normal @ front.wall.normal > 0 else -1.0
    wall = replace(
        front.wall,
        normal=sign * normal,
        point=centre,
        threshold=options.paper_threshold,
        inliers=np.flatnonzero(inliers),
    )
    shift = front.wall.axes.T @ (centre - front.wall.point)
    cells = front.cells.moved(float(shift[0]), float(shift[2]))
    return [Front(wall, cells, front.slab.moved(wall.axes, centre), front.side)]
