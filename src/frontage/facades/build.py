"""Build the `Facade` noun from a refined candidate: frame, covariance, layers, support and notes."""

from dataclasses import replace

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from frontage.facades.candidate import FacadeCandidate
from frontage.facades.cells import CellMap
from frontage.facades.layers import find_layers
from frontage.facades.outline import CLOSING, radius_asked
from frontage.facades.plane.curvature import wall_sagitta
from frontage.facades.plane.wall import WallPlane
from frontage.facades.porticoes import depth_behind
from frontage.facades.scene import FacadeScene
from frontage.facades.street import StreetSide
from frontage.geometry.arrays import Bool, Float, Int
from frontage.geometry.plane import lean
from frontage.geometry.rigid import Rigid3
from frontage.model.canonical import is_mirrored
from frontage.model.estimate import Estimate
from frontage.model.facade import Facade
from frontage.model.masonry import TOLERANCES

_MOST_FOR_BEND = 50_000  # points that tell whether a wall is bent
_MOST_LAYERED = 100_000  # points that tell its layers
_SPARSE = 2.0  # times wider disks are asked for where a wall is too sparse to tell the spacing of the facade
_BLOCKS = 48  # blocks of 3 x 3 cells in which the spacing is measured
_BEND_REACH_M = 0.5  # m: how far a bent wall may leave its plane and still count as the same wall
_BEND_INSET_M = 0.5  # m at its ends, where a corner, a pilaster or the next face may stand
# sigmas of the sagitta from which a wall is bent: strips are few, their modes not Gaussian
_LEAN_SIGMAS = 3.0  # sigmas of the lean from which it is reported
_LEAN_RAD = np.radians(0.1)  # rad, least lean that is reported
_UNDECIDED = 1 / 3  # odds above which the street side is doubtful


def build_facade(
    name: str, candidate: FacadeCandidate, scene: FacadeScene, rng: np.random.Generator
) -> Facade:
    """Builds the facade with id `name` from an oriented, refined wall.

    Its support is every point of the building in the prism over the outline, from `depth_front` m before the
    plane to `depth_back` m behind it. Behind a portico it reaches as deep as the wall there.
    """
    wall, cells, slab = candidate.wall, candidate.cells, candidate.slab
    options, cloud = scene.options, scene.cloud
    frame = Rigid3("local", "facade", wall.axes, wall.point)
    flat = cells.flat(slab.q[:, 0], slab.q[:, 2])
    inside = cells.whole.ravel()[flat]
    back = depth_behind(slab.q[:, 1], flat, cells, (options.depth_back, options.depth_front))
    inside &= (slab.q[:, 1] > -options.depth_front) & (slab.q[:, 1] < back.ravel()[flat])
    near = np.flatnonzero(inside)
    inner = cells.shrunk(_BEND_INSET_M).ravel()[flat]
    some = _at_most(np.flatnonzero(inner & inside), _MOST_FOR_BEND, rng)
    curvature = wall_sagitta(slab.q[some, 0], slab.q[some, 1], wall.threshold, _BEND_REACH_M)
    layered = _at_most(near, _MOST_LAYERED, rng)
    spacing = wall_spacing(slab.q, flat, cells, wall.threshold)
    return Facade(
        id=name,
        building=name.rsplit("/", 1)[0],
        local_from_facade=Estimate(frame, pose_covariance(wall.covariance), wall.dof),
        world=scene.scan.world,
        outline=cells.outline,
        layers=find_layers(
            np.take(slab.q[:, 1], layered),
            flat[layered],
            cells,
            wall.sigma,
            (-options.depth_front, float(back.max())),
        ),
        support=cloud.index[slab.rows[near]],
        inliers=cloud.index[wall.inliers],
        roughness=wall.sigma,
        spacing=spacing if np.isfinite(spacing) else 0.5 * cloud.raster,
        coverage=cells.coverage,
        oriented_by=candidate.side.told_by,
        curvature=curvature,
        notes=_notes(wall, candidate.side, curvature),
    )


def as_seen(facade: Facade, axes: Float) -> Facade:
    """Returns a facade that was found in the frame of `axes` (3, 3) as one in the frame of the scan."""
    side = np.array([-1.0 if is_mirrored(axes) else 1.0, 1.0])  # of x and z in the plane
    flip = np.array([side[0], 1.0, 1.0])
    # a rotation about an axis in the mirror keeps its sense only about the mirror's own normal
    signs = np.concatenate([flip, flip * side[0]])
    pose = facade.local_from_facade
    frame = Rigid3("local", "facade", axes @ facade.frame.R * flip, axes @ facade.frame.t)

    def ring(outline: Float) -> Float:
        """Returns an outline (k, 2) m that still runs the same way round."""
        return np.asarray((outline * side)[:: int(side[0])], np.float64)

    return replace(
        facade,
        local_from_facade=Estimate(frame, pose.covariance * np.outer(signs, signs), pose.dof),
        outline=ring(facade.outline),
        layers=tuple(replace(layer, outline=ring(layer.outline)) for layer in facade.layers),
    )


def _at_most(rows: Int, most: int, rng: np.random.Generator) -> Int:
    """Returns at most `most` of the rows (n,), drawn at random and kept in order."""
    return rows if len(rows) <= most else np.sort(rng.choice(rows, most, replace=False))


def wall_spacing(q: Float, flat: Int, cells: CellMap, threshold: float) -> float:
    """Measures the median distance (m) between neighbouring points on the wall, in blocks of cells.

    q          (n, 3) m, facade coordinates; flat (n,) the points' cells
    threshold  m, half thickness of the wall

    The blocks are spread evenly along the wall: a row of houses is scanned more and more sparsely towards its
    ends, and a few blocks drawn at random told spacings that differed by a half. Parts that are too sparse
    for the cells do not count where there are others, because wider cells are used there. Returns NaN
    when no block holds two points.
    """
    count = np.bincount(flat[np.abs(q[:, 1]) < threshold], minlength=cells.wall.size)
    dense = cells.wall & (radius_asked(count.reshape(cells.wall.shape), cells.cell) <= _SPARSE * CLOSING)
    columns, rows = np.nonzero((dense if dense.any() else cells.wall).T)
    if len(rows) == 0:
        return float("nan")
    block = np.zeros(cells.wall.shape, np.bool_)
    block[rows, columns] = _evenly(len(rows), _BLOCKS)
    block = ndimage.binary_dilation(block, np.ones((3, 3), np.bool_)) & cells.wall
    near = np.flatnonzero(block.ravel()[flat])
    near = near[np.abs(q[near, 1]) < threshold]
    if len(near) < 2:
        return float("nan")
    apart = np.asarray(cKDTree(q[near]).query(q[near], k=2)[0])[:, 1]
    apart = apart[np.isfinite(apart) & (apart > 1e-6)]
    return float(np.median(apart)) if len(apart) else float("nan")


def _evenly(number: int, most: int) -> Bool:
    """Returns which `most` of a `number` of things (n,) lie in the middles of equal parts of them."""
    picked = np.zeros(number, np.bool_)
    picked[((np.arange(most) + 0.5) * number / most).astype(np.int64)] = True
    return picked


def pose_covariance(plane: Float) -> Float:
    """Propagates the covariance (3, 3) of a plane (c, a, b) to that of the facade frame (6, 6).

    The result is in facade axes, translation in m and rotation in rad. The plane y = c + a x + b z moves the
    frame by c along Y and turns it by -b about X and by a about Z. The origin's place in the plane and the
    horizontal X axis are definitions, not estimates, and have no error.
    """
    jacobian = np.zeros((6, 3))
    jacobian[1, 0], jacobian[5, 1], jacobian[3, 2] = 1.0, 1.0, -1.0
    return np.asarray(jacobian @ plane @ jacobian.T, np.float64)


def _notes(wall: WallPlane, side: StreetSide, curvature: tuple[float, float]) -> tuple[str, ...]:
    """Writes what a user should know before trusting the plane."""
    notes = []
    sagitta, sigma = curvature
    if abs(sagitta) > max(TOLERANCES.bent_sigmas * sigma, wall.threshold):
        way = "back" if sagitta > 0 else "forward"
        notes.append(
            f"the wall is bent: its middle lies {abs(sagitta) * 100:.0f} cm (sigma {sigma * 100:.1f} cm) "
            f"further {way} than its ends; the plane fits its largest flat part"
        )
    tilt, sigma_tilt = lean(wall.normal), float(np.sqrt(wall.covariance[2, 2]))
    if abs(tilt) > _LEAN_SIGMAS * sigma_tilt and abs(tilt) > _LEAN_RAD:
        notes.append(
            f"the wall leans {'towards' if tilt > 0 else 'away from'} the street by "
            f"{np.degrees(abs(tilt)):.2f} degrees (t = {abs(tilt) / sigma_tilt:.0f})"
        )
    if side.odds > _UNDECIDED:
        notes.append("the street side is doubtful: both sides explain the points about equally well")
    return tuple(notes)
