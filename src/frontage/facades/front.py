"""From a plane found among thinned points to a wall with its cells and its street side."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from frontage.facades.bend import level
from frontage.facades.cells import CellMap, largest_part, occupied, sloping
from frontage.facades.cloud import Cloud, Slab, columns, voxel_first
from frontage.facades.options import FacadeOptions
from frontage.facades.refine import Wall, refine_thin, refine_wall, sketch_wall
from frontage.facades.search import sharp_plane
from frontage.facades.street import Side, side_from_evidence, side_from_rays
from frontage.geometry.arrays import Bool, Float, Int
from frontage.geometry.plane import facade_axes
from frontage.model.masonry import MASONRY
from frontage.model.scan import Scan

FRONT = MASONRY.relief  # m: claddings, plinths and bent parts this near the plane shape the outline too
_BOW = 1.5  # m from its tangent plane at one end that a bent wall may reach at the other
_SLACK = 0.10  # m that the last step may move the plane at the facade's ends
_SHUT = 0.10  # m: what is this near the plane closes it; window frames lie deeper
_AROUND = 200_000  # points of the surroundings, at most
_AROUND_CELL = 0.25  # m between them
RAYS = 20_000  # lines of sight sampled per question


@dataclass(frozen=True, eq=False)
class Front:
    """A wall (oriented: normal into the building), its raster, the points beside it, its street side."""

    wall: Wall
    cells: CellMap
    slab: Slab
    side: Side


@dataclass(frozen=True, eq=False)
class Scene:
    """What every step looks at: the scan, the building's points in it, its ground (z m), the options."""

    scan: Scan
    cloud: Cloud
    ground_z: float = 0.0
    options: FacadeOptions = field(default_factory=FacadeOptions)

    @property
    def reach(self) -> float:
        """m from a plane that a facade's points reach, with room for the plane's last step."""
        return max(self.options.depth_front, self.options.depth_back) + _SLACK

    @cached_property
    def around(self) -> Float:
        """Points (k, 3) m of building and surroundings, evenly in space: what lines of sight can meet."""
        xyz = self.scan.xyz
        if not np.isfinite(xyz.sum()):
            xyz = xyz[np.isfinite(xyz).all(1)]
        thin = voxel_first(xyz, max(_AROUND_CELL, self.cloud.cell))
        return xyz[thin[:: len(thin) // _AROUND + 1]]


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane through `point` (3,) m with unit `normal` (3,), as found among thinned points.

    sigma       m, spread of the points about it
    own         (n,) the thinned points on its largest connected part
    area, held  m2 that part covers; m2 that all points near the plane would cover side by side
    """

    normal: Float
    point: Float
    sigma: float
    own: Bool
    area: float
    held: float


def straightened(
    normal: Float, point: Float, thin: Float, cloud: Cloud, levelled: bool, rng: np.random.Generator
) -> Plane:
    """A plane found, fitted to the connected part of it that has most of the thinned points (n, 3)."""
    axes = facade_axes(normal)
    q = columns(thin - point, axes)
    near = np.flatnonzero(np.abs(q[:, 1]) < 2.0 * cloud.threshold)
    own, held = np.zeros(len(thin), np.bool_), len(near) * cloud.cell**2
    if len(near) < 10:
        own[near] = True
        return Plane(normal, point, cloud.noise, own, 0.0, held)
    on = q[near]
    cell = 2.0 * cloud.cell  # a turned raster of single points has empty cells
    count, corner, _ = occupied(on[:, 0], on[:, 2], cell)
    region = largest_part(count, corner, cell, on)
    if region is None:
        own[near] = True
        return Plane(normal, point, cloud.noise, own, 0.0, held)
    beside = q[np.abs(q[:, 1]) < _BOW]
    wide = beside[np.abs(beside[:, 1]) < FRONT]
    wide = wide[region.within(wide[:, 0], wide[:, 2])]
    sharp = sharp_plane(wide, cloud, rng) if levelled else None
    own[near] = region.within(on[:, 0], on[:, 2])
    fit, sigma = refine_thin(q[own], wide, cloud, sharp)
    own |= np.abs(q @ [-fit[1], 1.0, -fit[2]] - fit[0]) < 2.0 * cloud.threshold
    own &= region.within(q[:, 0], q[:, 2])
    shift, slope = level(beside[:, 0], beside @ [-fit[1], 1.0, -fit[2]] - fit[0], cloud.threshold)
    straight = axes @ np.array([-fit[1] - slope, 1.0, -fit[2]])
    straight /= np.linalg.norm(straight)
    return Plane(straight, point + axes[:, 1] * (fit[0] + shift), sigma, own, region.area, held)


def sketched(
    normal: Float, point: Float, sigma: float, votes: Float, scene: Scene, rng: np.random.Generator
) -> Front | None:
    """The front on a plane with noise `sigma` m: cells, inliers, street side; None when there is no wall.

    votes  (n, 3) m: points that say which connected part of the plane is meant
    """
    if abs(normal[2]) > np.sin(np.radians(scene.options.max_lean)):
        return None
    slab = scene.cloud.slab(normal, point, scene.reach)
    cells = _raster(slab, (votes - point) @ slab.axes, scene.cloud)
    wall = None if cells is None else sketch_wall(slab, cells, sigma)
    return None if cells is None or wall is None else orient(wall, cells, slab, scene, rng)


def measured(front: Front, votes: Float, scene: Scene, rng: np.random.Generator) -> Front | None:
    """A sketched front with its plane, covariance and cells from all points of the scene's cloud."""
    slab = scene.cloud.slab(front.wall.normal, front.wall.point, scene.reach)
    cells = _raster(slab, (votes - front.wall.point) @ slab.axes, scene.cloud)
    if cells is None:
        return None
    wall = refine_wall(slab, cells, scene.cloud, scene.scan, scene.options, rng)
    if wall is None or abs(wall.normal[2]) > np.sin(np.radians(scene.options.max_lean)):
        return None
    return Front(wall, *_seated(cells, slab, wall), front.side)


def _seated(cells: CellMap, slab: Slab, wall: Wall) -> tuple[CellMap, Slab]:
    """Cells and points in the wall's own frame; both came in that of the slab."""
    x, _, z = slab.axes.T @ (wall.point - slab.point)
    slab = slab.moved(wall.axes, wall.point)
    return _marked(cells.moved(float(x), float(z)), slab, wall), slab


def orient(wall: Wall, cells: CellMap, slab: Slab, scene: Scene, rng: np.random.Generator) -> Front:
    """Tell the street side and turn the wall, its cells (of the slab's frame) and its points to it."""
    cells, slab = _seated(cells, slab, wall)
    inliers = some_of(wall.inliers, rng)
    scan, cloud = scene.scan, scene.cloud
    side = side_from_rays(wall, cloud.xyz[inliers], scan.sensor_of(cloud.index[inliers]))
    if side is None:
        side = side_from_evidence(wall, cells, scene.around, scene.ground_z)
    if side.sign < 0:
        return Front(wall, cells, slab, side)
    wall, cells = wall.flipped(), cells.mirrored
    slab = slab.moved(wall.axes, wall.point)
    sensors = side.sensors * np.array([-1.0, -1.0, 1.0])
    return Front(wall, _marked(cells, slab, wall), slab, Side(-1, side.told_by, sensors, side.odds))


def some_of(rows: Int, rng: np.random.Generator) -> Int:
    """At most RAYS of the rows (n,), at random."""
    return rows if len(rows) <= RAYS else np.asarray(rows[rng.integers(0, len(rows), RAYS)])


def _raster(slab: Slab, votes: Float, cloud: Cloud) -> CellMap | None:
    """Cells of the points near the plane: the outline from all of them that are upright surfaces.

    votes (n, 3) m, slab frame: points that say which connected part of the plane is meant.
    """
    near = np.flatnonzero(np.abs(slab.q[:, 1]) < FRONT)
    if len(near) < 10:
        return None
    x, y, z = (np.take(slab.q[:, k], near) for k in range(3))
    count, corner, flat = occupied(x, z, cloud.raster)
    on = np.bincount(flat[np.abs(y) < 2.0 * cloud.threshold], minlength=count.size).reshape(count.shape) > 0
    count[sloping(y, count, flat, cloud.raster) & ~on] = 0
    return largest_part(count, corner, cloud.raster, votes)


def _marked(cells: CellMap, slab: Slab, wall: Wall) -> CellMap:
    """The cells with the wall marked where points lie on it, and shut where points lie on it or before it."""
    y = slab.q[:, 1]
    flat = cells.flat(slab.q[:, 0], slab.q[:, 2])
    on, shut = np.zeros((2, cells.whole.size), np.bool_)
    on[flat[np.abs(y) < wall.threshold]] = True
    shut[flat[y < _SHUT]] = True
    shape = cells.whole.shape
    return replace(cells, wall=on.reshape(shape) & cells.whole, shut=shut.reshape(shape) & cells.whole)
