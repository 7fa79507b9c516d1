"""Positions of terrestrial scanners, and the errors of the poses that they hand over."""

import numpy as np

from frontage.errors import OptionError
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import Part, Scene
from frontage.simulate.sensors.instrument import ScannerSpec

_CLEARANCE_M = 1.0  # free radius that a tripod needs
_STEP_M = 0.5  # along the street, to the next place that is tried
_DROP_M = 4.0  # height above the road from which the ground is looked for
_TURNS = np.linspace(0, 2 * np.pi, 24, endpoint=False)


def rotation(roll: float, pitch: float, yaw: float) -> Float:
    """Return the rotation (3, 3) about x, then y, then z (rad): ``Rz(yaw) Ry(pitch) Rx(roll)``."""
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    rx = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    ry = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    rz = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return np.asarray(rz @ ry @ rx)


def street_extent(scene: Scene) -> tuple[float, float]:
    """Return the first and the last s (m) of the houses on side 0, or of all houses if that side is empty.

    Without any houses, returns the extent of the road.
    """
    own = [h.footprint for h in scene.houses if h.side == 0] or [h.footprint for h in scene.houses]
    xyz = np.vstack([np.column_stack([f, np.zeros(len(f))]) for f in own]) if own else scene.road
    s = scene.local_from_street.inverse.apply(xyz)[:, 0]
    return float(s.min()), float(s.max())


def station_positions(scene: Scene, spec: ScannerSpec, tracer: Tracer) -> list[Float]:
    """Return the scanner's centre (3,) m local at every station.

    Stations are where the specification says, or else spread along the street where there is room.

    Raises OptionError for a position that is not above the ground or has no free space around it.
    """
    if spec.positions is not None:
        found = [_free_position(scene, tracer, s, d, spec.height) for s, d in spec.positions]
        for (s, d), place in zip(spec.positions, found, strict=True):
            if place is None:
                raise OptionError(
                    f"scanner position [{s:g}, {d:g}] is not free ground; move it to where a tripod can stand"
                )
        return [p for p in found if p is not None]
    first, last = street_extent(scene)
    road = scene.local_from_street.inverse.apply(scene.road)
    out = []
    for k in range(spec.stations):
        s = first + (k + 0.5) / spec.stations * (last - first)
        # on alternate sides of the road's middle, so that a car hides different things from neighbours
        d = float(np.interp(s, road[:, 0], road[:, 1])) + (-1.5 if k % 2 else 0.5)
        tries = [s + sign * i * _STEP_M for i in range(20) for sign in (1, -1)]
        free = (_free_position(scene, tracer, t, d, spec.height) for t in tries)
        place = next((p for p in free if p is not None), None)
        if place is None:
            raise OptionError(
                f"no free ground within 10 m of [{s:.1f}, {d:.1f}] for station {k + 1}; state `positions`"
            )
        out.append(place)
    return out


def ground_below(scene: Scene, tracer: Tracer, xyz: Float) -> Float:
    """Return the height z (n,) m of the ground below points (n, 3) local; NaN where something covers it."""
    hits = tracer.first_hit(xyz, np.tile([0.0, 0.0, -1.0], (len(xyz), 1)))
    part = scene.parts[scene.mesh.surface[hits.triangle]]
    return np.where(hits.found & (part == Part.GROUND), xyz[:, 2] - hits.distance, np.nan)


def _free_position(scene: Scene, tracer: Tracer, s: float, d: float, height: float) -> Float | None:
    """Returns the scanner's centre `height` m above the ground at [s, d], None without free space there."""
    road = scene.local_from_street.inverse.apply(scene.road)
    z = float(np.interp(s, road[:, 0], road[:, 2]))
    above = scene.local_from_street.apply(np.array([[s, d, z + _DROP_M]]))
    ground = ground_below(scene, tracer, above)[0]
    if np.isnan(ground):
        return None
    place = np.array([above[0, 0], above[0, 1], ground + height])
    around = np.column_stack([np.cos(_TURNS), np.sin(_TURNS), np.zeros(len(_TURNS))])
    legs = place - [0, 0, 0.7 * height]
    blocked = tracer.blocked(
        np.repeat([place, legs], len(_TURNS), 0), np.vstack([around, around]), _CLEARANCE_M
    )
    return None if blocked.any() else place


def approximate_pose(true: Rigid3, spec: ScannerSpec, rng: np.random.Generator) -> Rigid3:
    """Draw the pose that GPS, compass and level give for a station whose pose is `true`."""
    level = np.radians(spec.sigma_level) * rng.normal(size=2)
    turn = rotation(level[0], level[1], np.radians(spec.sigma_heading) * rng.normal())
    return Rigid3(true.to, true.frm, turn @ true.R, true.t + spec.sigma_position * rng.normal(size=3))
