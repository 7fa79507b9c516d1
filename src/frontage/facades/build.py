"""From a refined wall to the `Facade` noun: frame, covariance, layers, support, notes."""

import numpy as np

from frontage.facades.cells import CellMap
from frontage.facades.cloud import Cloud, surface_spacing
from frontage.facades.layers import find_layers
from frontage.facades.options import FacadeOptions
from frontage.facades.refine import Wall, bend
from frontage.facades.street import Side
from frontage.geometry.arrays import Float
from frontage.geometry.plane import lean
from frontage.geometry.rigid import Rigid3
from frontage.model.building import Building
from frontage.model.estimate import Estimate
from frontage.model.facade import Facade
from frontage.model.scan import Scan

_BEND_REACH = 0.5  # m: how far a bent wall may leave its plane and still count as the same wall
_UNDECIDED = 1 / 3  # odds above which the street side is doubtful


def build_facade(
    name: str,
    building: Building,
    scan: Scan,
    cloud: Cloud,
    wall: Wall,
    cells: CellMap,
    side: Side,
    options: FacadeOptions,
    rng: np.random.Generator,
) -> Facade:
    """The facade of an oriented wall; its support is every building point in the outline's prism.

    The prism reaches from `depth_front` before the plane to `depth_back` behind it.
    """
    frame = Rigid3("local", "facade", wall.axes, wall.point)
    near = np.flatnonzero(_between(cloud.xyz, wall, options))
    q = wall.coordinates(cloud.xyz[near])
    inside = cells.within(q[:, 0], q[:, 2])
    near, q = near[inside], q[inside]
    some = q if len(q) <= 200_000 else q[np.sort(rng.choice(len(q), 200_000, replace=False))]
    curvature = bend(some[:, 0], some[:, 1], wall.threshold, _BEND_REACH)
    spacing = surface_spacing(cloud.xyz[wall.inliers], rng)
    return Facade(
        id=name,
        building=building.id,
        local_from_facade=Estimate(frame, pose_covariance(wall.covariance), wall.dof),
        world=scan.world,
        outline=cells.outline,
        layers=find_layers(some, cells, wall.sigma, (-options.depth_front, options.depth_back)),
        support=cloud.index[near],
        inliers=cloud.index[wall.inliers],
        roughness=wall.sigma,
        spacing=spacing if np.isfinite(spacing) else 0.5 * cloud.cell,
        coverage=cells.coverage,
        oriented_by=side.told_by,
        curvature=curvature,
        notes=_notes(wall, side, curvature),
    )


def _between(xyz: Float, wall: Wall, options: FacadeOptions) -> np.ndarray:
    offset = xyz @ wall.normal - wall.point @ wall.normal
    return np.asarray((offset > -options.depth_front) & (offset < options.depth_back))


def pose_covariance(plane: Float) -> Float:
    """Covariance (6, 6) of the facade frame (translation m, rotation rad, facade axes) from that of (c,
    a, b).

    The plane y = c + a x + b z moves the frame by c along Y and turns it by -b about X and by a about Z.
    The origin's place in the plane and the horizontal X are definitions, not estimates: they have no error.
    """
    jacobian = np.zeros((6, 3))
    jacobian[1, 0], jacobian[5, 1], jacobian[3, 2] = 1.0, 1.0, -1.0
    return np.asarray(jacobian @ plane @ jacobian.T, np.float64)


def _notes(wall: Wall, side: Side, curvature: tuple[float, float]) -> tuple[str, ...]:
    """What a user should know before trusting the plane."""
    notes = []
    sagitta, sigma = curvature
    if abs(sagitta) > max(3.0 * sigma, wall.threshold):
        way = "back" if sagitta > 0 else "forward"
        notes.append(
            f"the wall is bent: its middle lies {abs(sagitta) * 100:.0f} cm (sigma {sigma * 100:.1f} cm) "
            f"further {way} than its ends; the plane fits its largest flat part"
        )
    tilt, sigma_tilt = lean(wall.normal), float(np.sqrt(wall.covariance[2, 2]))
    if abs(tilt) > 3.0 * sigma_tilt and abs(tilt) > np.radians(0.1):
        notes.append(
            f"the wall leans {'towards' if tilt > 0 else 'away from'} the street by "
            f"{np.degrees(abs(tilt)):.2f} degrees (t = {abs(tilt) / sigma_tilt:.0f})"
        )
    if side.odds > _UNDECIDED:
        notes.append("the street side is doubtful: both sides explain the points about equally well")
    return tuple(notes)
