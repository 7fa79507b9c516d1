"""Facade candidates: a wall plane with its cells, the points beside it and its street side."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.facades.cells import CellMap
from frontage.facades.cloud import BuildingCloud, Slab
from frontage.facades.outline import largest_part, occupied, sloping
from frontage.facades.plane.connected import RELIEF_M
from frontage.facades.plane.refine import refine_wall
from frontage.facades.plane.wall import WallPlane, sketch_wall
from frontage.facades.scene import FacadeScene
from frontage.facades.street import StreetSide, side_from_evidence, side_from_rays
from frontage.geometry.arrays import Float, Int

MOST_RAYS = 20_000  # lines of sight sampled per question
_SHUT_M = 0.10  # m: points this near behind the plane close it; window frames lie deeper


@dataclass(frozen=True, eq=False)
class FacadeCandidate:
    """A wall that may be a facade, oriented: the normal points into the building.

    wall   the plane, sketched or refined
    cells  raster of the wall in its own frame
    slab   all points of the building beside the plane, in the wall's frame
    side   how the street side was told
    """

    wall: WallPlane
    cells: CellMap
    slab: Slab
    side: StreetSide


def sketch_candidate(
    normal: Float, point: Float, *, sigma: float, votes: Float, scene: FacadeScene, rng: np.random.Generator
) -> FacadeCandidate | None:
    """Sketches the candidate on a plane: its cells, inliers and street side.

    normal, point  (3,) unit, (3,) m local
    sigma          m, scatter of the points about the plane
    votes          (n, 3) m local, points that say which connected component of the plane is meant

    Returns None when the plane leans too much or holds no wall.
    """
    if leans_too_much(normal, scene):
        return None
    slab = scene.cloud.slab(normal, point, scene.reach)
    cells = _raster(slab, (votes - point) @ slab.axes, scene.cloud)
    wall = None if cells is None else sketch_wall(slab, cells, sigma)
    return None if cells is None or wall is None else orient(wall, cells, slab, scene, rng)


def refine_candidate(
    candidate: FacadeCandidate, votes: Float, scene: FacadeScene, rng: np.random.Generator
) -> FacadeCandidate | None:
    """Refines a candidate: plane, covariance and cells from all points of the scene's cloud.

    votes (n, 3) m local say which connected component is meant. Returns None when no wall remains.
    """
    slab = scene.cloud.slab(candidate.wall.normal, candidate.wall.point, scene.reach)
    cells = _raster(slab, (votes - candidate.wall.point) @ slab.axes, scene.cloud)
    if cells is None:
        return None
    wall = refine_wall(slab, cells, scene, rng)
    if wall is None or leans_too_much(wall.normal, scene):
        return None
    return FacadeCandidate(wall, *_in_wall_frame(cells, slab, wall), candidate.side)


def leans_too_much(normal: Float, scene: FacadeScene) -> bool:
    """Decides whether a unit normal (3,) lies further from the horizontal than a wall's may."""
    return bool(abs(normal[2]) > np.sin(np.radians(scene.options.max_lean)))


def orient(
    wall: WallPlane, cells: CellMap, slab: Slab, scene: FacadeScene, rng: np.random.Generator
) -> FacadeCandidate:
    """Tells the street side of a wall and turns its normal into the building.

    Cells and slab come in the slab's frame and are returned in that of the oriented wall.
    """
    cells, slab = _in_wall_frame(cells, slab, wall)
    inliers = sample_rays(wall.inliers, rng)
    side = side_from_rays(wall, scene.cloud.xyz[inliers], scene.sensors(inliers))
    if side is None:
        side = side_from_evidence(wall, cells, scene.around, slab.q, scene.ground_z)
    candidate = FacadeCandidate(wall, cells, slab, side)
    return candidate if side.sign < 0 else turned(candidate)


def turned(candidate: FacadeCandidate) -> FacadeCandidate:
    """Returns a candidate with its normal turned round, so that its street lies on the other side."""
    wall, cells, side = candidate.wall.flipped(), candidate.cells.mirrored, candidate.side
    slab = candidate.slab.moved(wall.axes, wall.point)
    sensors = side.sensors * np.array([-1.0, -1.0, 1.0])
    side = StreetSide(-1, side.told_by, sensors, side.odds)
    return FacadeCandidate(wall, _marked(cells, slab, wall), slab, side)


def sample_rays(rows: Int, rng: np.random.Generator) -> Int:
    """Returns the rows (n,), or `MOST_RAYS` of them drawn at random with replacement."""
    return rows if len(rows) <= MOST_RAYS else np.asarray(rows[rng.integers(0, len(rows), MOST_RAYS)])


def some_inliers(candidate: FacadeCandidate, cloud: BuildingCloud) -> Float:
    """Returns points (n, 3) m local of a wall of this cloud: every so many of them, `MOST_RAYS` at most."""
    rows = candidate.wall.inliers
    return cloud.xyz[rows[:: len(rows) // MOST_RAYS + 1]]


def _in_wall_frame(cells: CellMap, slab: Slab, wall: WallPlane) -> tuple[CellMap, Slab]:
    """Moves cells and points from the slab's frame to the wall's own."""
    x, _, z = slab.axes.T @ (wall.point - slab.point)
    slab = slab.moved(wall.axes, wall.point)
    return _marked(cells.moved(float(x), float(z)), slab, wall), slab


def _raster(slab: Slab, votes: Float, cloud: BuildingCloud) -> CellMap | None:
    """Rasters the points near the plane; every upright surface among them shapes the outline.

    votes (n, 3) m, slab frame: points that say which connected component of the plane is meant.
    """
    near = np.flatnonzero(np.abs(slab.q[:, 1]) < RELIEF_M)
    if len(near) < 10:
        return None
    x, y, z = (np.take(slab.q[:, k], near) for k in range(3))
    count, corner, flat = occupied(x, z, cloud.raster)
    on = np.bincount(flat[np.abs(y) < 2.0 * cloud.threshold], minlength=count.size).reshape(count.shape) > 0
    count[sloping(y, count, flat, cloud.raster) & ~on] = 0
    return largest_part(count, corner, cloud.raster, votes)


def _marked(cells: CellMap, slab: Slab, wall: WallPlane) -> CellMap:
    """Marks cells as wall where points lie on the plane, and as shut where points lie on or before it."""
    y = slab.q[:, 1]
    flat = cells.flat(slab.q[:, 0], slab.q[:, 2])
    on, shut = np.zeros((2, cells.whole.size), np.bool_)
    on[flat[np.abs(y) < wall.threshold]] = True
    shut[flat[y < _SHUT_M]] = True
    shape = cells.whole.shape
    return replace(cells, wall=on.reshape(shape) & cells.whole, shut=shut.reshape(shape) & cells.whole)
