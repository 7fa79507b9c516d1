"""From a plane found among thinned points to a wall with its cells and its street side."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.facades.bend import level
from frontage.facades.cells import CellMap, largest_part, occupied, sloping
from frontage.facades.cloud import Cloud, Slab, voxel_first
from frontage.facades.options import FacadeOptions
from frontage.facades.refine import Wall, refine_thin, refine_wall
from frontage.facades.street import Side, side_from_evidence, side_from_rays
from frontage.geometry.arrays import Bool, Float, Int
from frontage.geometry.plane import facade_axes
from frontage.model.building import Building
from frontage.model.scan import Scan

FRONT = 0.35  # m: claddings, plinths and bent parts this near the plane shape the outline too
_BOW = 1.5  # m from its tangent plane at one end that a bent wall may reach at the other
_SLACK = 0.10  # m that the last step may move the plane at the facade's ends
_SHUT = 0.10  # m: what is this near the plane closes it; window frames lie deeper
_AROUND = 60_000  # points of the surroundings kept without rays
RAYS = 20_000  # lines of sight sampled per question


@dataclass(frozen=True, eq=False)
class Front:
    """A wall (oriented: normal into the building), its raster, its street side, the points beside it."""

    wall: Wall
    cells: CellMap
    side: Side
    slab: Slab


@dataclass(frozen=True, eq=False)
class Scene:
    """What every step looks at; `around` (k, 3) m: the surroundings that lines of sight can meet."""

    scan: Scan
    cloud: Cloud
    around: Float
    building: Building
    options: FacadeOptions


def surroundings(scan: Scan, cloud: Cloud, rng: np.random.Generator) -> Float:
    """A few thousand points (k, 3) of building and surroundings, evenly in space:
    what lines of sight can meet. None are needed where the points know their sensors.
    """
    if scan.has_origins:
        return np.empty((0, 3))
    finite = scan.xyz[np.isfinite(scan.xyz).all(1)]
    thin = voxel_first(finite, max(0.25, cloud.cell))
    return finite[thin[rng.permutation(len(thin))[:_AROUND]]]


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane through `point` (3,) m with unit `normal` (3,), the thinned points `own` (n,) on its wall, and
    whether that is `enough` to look closer.
    """

    normal: Float
    point: Float
    own: Bool
    enough: bool


def straightened(normal: Float, point: Float, thin: Float, cloud: Cloud, least: float) -> Plane:
    """A plane found, fitted to the connected part of it that has most of the thinned points (n, 3);
    not `enough` when that part covers less than `least` m2.
    """
    axes = facade_axes(normal)
    q = (thin - point) @ axes
    near = np.abs(q[:, 1]) < 2.0 * cloud.threshold
    if np.count_nonzero(near) < 10:
        return Plane(normal, point, near, False)
    count, corner, _ = occupied(q[near, 0], q[near, 2], cloud.cell)
    region = largest_part(count, corner, cloud.cell, q[near])
    if region is None:
        return Plane(normal, point, near, False)
    own = near.copy()
    own[near] = region.within(q[near, 0], q[near, 2])
    if region.area < least:
        return Plane(normal, point, own, False)
    fit, _ = refine_thin(q[own], cloud)
    beside = np.abs(q[:, 1]) < _BOW
    shift, slope = level(q[beside, 0], q[beside] @ [-fit[1], 1.0, -fit[2]] - fit[0], cloud.threshold)
    straight = axes @ np.array([-fit[1] - slope, 1.0, -fit[2]])
    return Plane(straight / np.linalg.norm(straight), point + axes[:, 1] * (fit[0] + shift), own, True)


def front_at(plane: Plane, votes: Float, scene: Scene, rng: np.random.Generator) -> Front | None:
    """The front on a straightened plane, from all points near it; None when there is no wall after all.

    votes  (n, 3) m: points that say which connected part of the plane is meant
    """
    cloud, options = scene.cloud, scene.options
    reach = max(options.depth_front, options.depth_back) + _SLACK
    slab = cloud.slab(plane.normal, plane.point, reach)
    cells = _raster(slab, (votes - plane.point) @ slab.axes, cloud)
    if cells is None:
        return None
    wall = refine_wall(slab, cells, cloud, scene.scan, options, rng)
    if wall is None or abs(wall.normal[2]) > np.sin(np.radians(options.max_lean)):
        return None
    return orient(wall, cells, slab, scene, rng)


def orient(wall: Wall, cells: CellMap, slab: Slab, scene: Scene, rng: np.random.Generator) -> Front:
    """Tell the street side and turn the wall, its cells (of the slab's frame) and its points to it."""
    x, _, z = slab.axes.T @ (wall.point - slab.point)
    cells = cells.moved(float(x), float(z))
    slab = slab.moved(wall.axes, wall.point)
    cells = _marked(cells, slab, wall)
    inliers = some_of(wall.inliers, rng)
    scan, cloud = scene.scan, scene.cloud
    side = side_from_rays(wall, cloud.xyz[inliers], scan.sensor_of(cloud.index[inliers]))
    if side is None:
        side = side_from_evidence(wall, cells, scene.around, scene.building.ground_z)
    if side.sign < 0:
        return Front(wall, cells, side, slab)
    wall, cells = wall.flipped(), cells.mirrored
    slab = Slab(slab.rows, slab.q * np.array([-1.0, -1.0, 1.0]), wall.axes, wall.point)
    sensors = side.sensors * np.array([-1.0, -1.0, 1.0])
    return Front(wall, _marked(cells, slab, wall), Side(-1, side.told_by, sensors, side.odds), slab)


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
    count, corner, flat = occupied(x, z, cloud.cell)
    on = np.bincount(flat[np.abs(y) < 2.0 * cloud.threshold], minlength=count.size).reshape(count.shape) > 0
    count[sloping(y, count, flat, cloud.cell) & ~on] = 0
    return largest_part(count, corner, cloud.cell, votes)


def _marked(cells: CellMap, slab: Slab, wall: Wall) -> CellMap:
    """The cells with the wall marked where points lie on it, and shut where points lie on it or before it."""
    y = slab.q[:, 1]
    flat = cells.flat(slab.q[:, 0], slab.q[:, 2])
    on, shut = np.zeros((2, cells.whole.size), np.bool_)
    on[flat[np.abs(y) < wall.threshold]] = True
    shut[flat[y < _SHUT]] = True
    shape = cells.whole.shape
    return replace(cells, wall=on.reshape(shape) & cells.whole, shut=shut.reshape(shape) & cells.whole)
