"""The motion of a vehicle: the true one along the road, and the one that its navigation determines."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from frontage.geometry.arrays import Float
from frontage.simulate.scene import Scene
from frontage.simulate.sensors.instrument import DriveSpec

_RATE_HZ = 100.0  # of the trajectory
_SWAY_RAD = np.radians([0.4, 0.3, 0.3])  # standard deviations of roll, pitch and heading about the road's
_BOUNCE_M = 0.01  # standard deviation of the vehicle's height on its springs
_SWAY_S, _DRIFT_S = 0.4, 1.5  # between independent values of the sway and of the navigation's error


@dataclass(frozen=True, eq=False)
class Track:
    """The motion of a vehicle at k times.

    time       (k,) s
    xyz        (k, 3) m local
    attitude   (k, 3) rad: roll (positive: right side down), pitch (positive: nose up), heading (clockwise
               from the y axis, grid north); the body axes are x forward, y left, z up
    """

    time: Float
    xyz: Float
    attitude: Float

    @property
    def table(self) -> Float:
        """The trajectory (k, 7): time, x, y, z, roll, pitch, heading."""
        return np.column_stack([self.time, self.xyz, self.attitude])

    def at(self, time: Float) -> tuple[Float, Float]:
        """Interpolate positions and attitudes (n, 3) at `time` (n,)."""
        both = np.hstack([self.xyz, self.attitude])
        values = np.column_stack([np.interp(time, self.time, column) for column in both.T])
        return values[:, :3], values[:, 3:]


def rotate_to_local(attitude: Float, directions: Float) -> Float:
    """Rotate directions (n, 3) from body axes to local axes; attitude (n, 3) as in `Track`."""
    roll, pitch, yaw = attitude[:, 0], -attitude[:, 1], np.pi / 2 - attitude[:, 2]
    x, y, z = directions.T
    c, s = np.cos(roll), np.sin(roll)
    y, z = c * y - s * z, s * y + c * z
    c, s = np.cos(pitch), np.sin(pitch)
    x, z = c * x + s * z, c * z - s * x
    c, s = np.cos(yaw), np.sin(yaw)
    return np.column_stack([c * x - s * y, s * x + c * y, z])


def drive_along(
    scene: Scene, span: tuple[float, float], lane: float, spec: DriveSpec, rng: np.random.Generator
) -> Track:
    """Draw the true motion over a `span` of s (m), `lane` m from the road's centre line towards the houses.

    Beyond its ends, the road continues straight on.
    """
    first, last = span
    time = np.arange(0.0, (last - first) / spec.speed, 1 / _RATE_HZ)
    road = scene.local_from_street.inverse.apply(scene.road)
    road = road[np.argsort(road[:, 0], kind="stable")]
    s = first + spec.speed * time
    line = np.column_stack([s, *(_extended(s, road[:, 0], road[:, k]) for k in (1, 2))])
    rise = np.gradient(line, s, axis=0)
    line[:, 1] += lane
    line[:, 2] += spec.height + _BOUNCE_M * _smooth_noise(time, _SWAY_S, 1, rng)[:, 0]
    ahead = scene.local_from_street.rotate(rise)
    level = np.hypot(ahead[:, 0], ahead[:, 1])
    course = np.column_stack(
        [np.zeros(len(s)), np.arctan2(ahead[:, 2], level), np.unwrap(np.arctan2(ahead[:, 0], ahead[:, 1]))]
    )
    attitude = course + _SWAY_RAD * _smooth_noise(time, _SWAY_S, 3, rng)
    return Track(spec.start + time, scene.local_from_street.apply(line), attitude)


def navigation_solution(true: Track, spec: DriveSpec, rng: np.random.Generator) -> Track:
    """Draw the trajectory that the navigation determines.

    Its errors are a constant offset and a random walk of the position, and a slowly varying attitude error.
    """
    time = true.time - true.time[0]
    nodes = np.arange(0.0, time[-1] + 2 * _DRIFT_S, _DRIFT_S)
    # the standard deviation of a random walk grows with the square root of the distance
    steps = spec.drift * np.sqrt(_DRIFT_S * spec.speed / 100) * rng.normal(size=(len(nodes), 3))
    walk = CubicSpline(nodes, np.cumsum(steps, axis=0))(time)
    offset = spec.offset * rng.normal(size=3)
    turn = np.radians(spec.drift_angle) * _smooth_noise(time, 4 * _DRIFT_S, 3, rng)
    return Track(true.time, true.xyz + offset + walk, true.attitude + turn)


def _extended(s: Float, at: Float, value: Float) -> Float:
    """Interpolates linearly through (at, value), and extrapolates straight on beyond both ends."""
    inside = np.interp(s, at, value)
    if len(at) < 2:
        return inside
    low, high = (value[1] - value[0]) / (at[1] - at[0]), (value[-1] - value[-2]) / (at[-1] - at[-2])
    return np.asarray(inside + low * np.minimum(s - at[0], 0) + high * np.maximum(s - at[-1], 0))


def _smooth_noise(time: Float, step: float, columns: int, rng: np.random.Generator) -> Float:
    """Draws smooth noise (k, columns) with unit variance at its nodes, which are `step` s apart."""
    nodes = np.arange(0.0, time[-1] + 3 * step, step)
    return np.asarray(CubicSpline(nodes, rng.normal(size=(len(nodes), columns)))(time))
