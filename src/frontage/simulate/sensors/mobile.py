"""A vehicle with two profile scanners: its true motion, the navigation's trajectory, and its points."""

from dataclasses import dataclass

import numpy as np

from frontage.errors import OptionError
from frontage.geometry.arrays import Array, Float
from frontage.model import Scan
from frontage.simulate.optics.light import LightSpec
from frontage.simulate.scene import Scene
from frontage.simulate.sensors.instrument import DriveSpec, Instrument, draw_instrument
from frontage.simulate.sensors.photograph import scan_colours
from frontage.simulate.sensors.positions import rotation, street_extent
from frontage.simulate.sensors.ranging import Measurements, measure_beams
from frontage.simulate.sensors.recording import Drive
from frontage.simulate.sensors.target import Target
from frontage.simulate.sensors.track import Track, drive_along, navigation_solution, rotate_to_local
from frontage.simulate.sensors.traffic import with_moved_traffic

_SCANNERS = 2
_ARM_M = 0.25  # distance of the scanners before and behind the vehicle's reference point
_LEAN_DEG = (15.0, 30.0)  # by which profiles lean forward, so that none runs along the jambs of windows
_ROOF_RAD = np.radians(35)  # half-angle about straight down that the vehicle's roof hides
_SAMPLE_M = 0.02  # of track between stored sensor positions


@dataclass(frozen=True)
class _Mount:
    """A scanner on the vehicle: offset (3,) m and rotation (3, 3), body from scanner, true and calibrated."""

    offset: Float
    true: Float
    calibrated: Float


@dataclass(frozen=True, eq=False)
class _Survey:
    """What all scanners of a drive have in common."""

    spec: DriveSpec
    instrument: Instrument
    target: Target
    true: Track
    navigation: Track
    seed: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class _Profiles:
    """The k echoes of one scanner: gps_time (k,) s, points and sensor positions (k, 3) by the navigation."""

    measurements: Measurements
    time: Float
    xyz: Float
    sensor: Float


def drive(scene: Scene, spec: DriveSpec, seed: int, light: LightSpec | None = None) -> Drive:
    """Drive once along the road of `scene`, from before the first house to behind the last one.

    Points are placed with the trajectory of the vehicle's navigation and the calibrated mounting angles.
    `light` is that in which the vehicle's camera works. The same seed gives the same bytes.

    Raises OptionError for a road without length, MissingExtra if embreex is not installed.
    """
    rng = np.random.default_rng([seed, scene.seed, 0x3B])
    instrument = draw_instrument(spec, rng)
    lane = spec.lane if spec.lane is not None else float(rng.uniform(0.0, 2.0))
    if len(scene.road) < 2 or not np.ptp(scene.road, axis=0).any():
        raise OptionError(
            f"scene '{scene.name}' has no road to drive along; give it one of two points or more"
        )
    first, last = street_extent(scene)
    true = drive_along(scene, (first - spec.overrun, last + spec.overrun), lane, spec, rng)
    navigation = navigation_solution(true, spec, rng)
    if spec.moved:
        scene = with_moved_traffic(scene, spec.moved, seed)
    target = Target(scene, instrument.wavelength, spectral=spec.spectral, wet=spec.wet)
    lean = np.radians(rng.uniform(*_LEAN_DEG))
    survey = _Survey(spec, instrument, target, true, navigation, (seed, scene.seed, 0x3B))
    parts = [_scan_profiles(survey, _draw_mount(spec, k, lean, rng), k) for k in range(_SCANNERS)]
    return _joined(scene, survey, parts, light)


def _draw_mount(spec: DriveSpec, number: int, lean: float, rng: np.random.Generator) -> _Mount:
    """Draws the mounting of scanner `number`; the profiles of the two are tilted to opposite sides."""
    side = 1 if number == 0 else -1
    nominal = rotation(0.0, side * lean, side * np.radians(spec.tilt))
    error = np.radians(spec.boresight) * rng.normal(size=3)
    return _Mount(np.array([side * _ARM_M, 0.0, 0.0]), nominal @ rotation(*error), nominal)


def _scan_profiles(survey: _Survey, mount: _Mount, number: int) -> _Profiles:
    """Measures all profiles of scanner `number`."""
    spec, instrument, true = survey.spec, survey.instrument, survey.true
    seed = (*survey.seed, number)
    rng = np.random.default_rng([*seed, 1])
    turns = int((true.time[-1] - true.time[0]) * spec.profile_rate)
    step = np.arange(turns * spec.beams) + 0.5 * number
    time, angle = true.time[0] + step / (spec.beams * spec.profile_rate), 2 * np.pi * step / spec.beams
    # an angle of 0 points straight down
    free = np.abs((angle + np.pi) % (2 * np.pi) - np.pi) > _ROOF_RAD
    time, angle = time[free], angle[free]
    noise = instrument.sigma_angle * rng.normal(size=(2, len(angle)))
    at, attitude = true.at(time)
    beams = rotate_to_local(attitude, _profile_directions(angle + noise[0], noise[1]) @ mount.true.T)
    origins = at + rotate_to_local(attitude, np.broadcast_to(mount.offset, beams.shape))
    m = measure_beams(survey.target, instrument, origins, beams, seed)
    at, attitude = survey.navigation.at(time[m.beam])
    sensor = at + rotate_to_local(attitude, np.broadcast_to(mount.offset, at.shape))
    nominal = _profile_directions(angle[m.beam], np.zeros(len(m.beam))) @ mount.calibrated.T
    xyz = sensor + m.range[:, None] * rotate_to_local(attitude, nominal)
    return _Profiles(m, time[m.beam], xyz, sensor)


def _profile_directions(angle: Float, aside: Float) -> Float:
    """Returns unit directions (n, 3) in the scanner's frame, whose x axis is that of the mirror's rotation.

    angle (n,) rad is counted from straight down, aside (n,) rad is the deviation out of the profile.
    """
    d = np.column_stack([aside, np.sin(angle), -np.cos(angle)])
    return np.asarray(d / np.sqrt(1 + aside**2)[:, None])


def _joined(scene: Scene, survey: _Survey, parts: list[_Profiles], light: LightSpec | None) -> Drive:
    """Joins the echoes of all scanners in the order of time."""
    spec, true = survey.spec, survey.true
    time = np.concatenate([p.time for p in parts])
    order = np.lexsort((np.concatenate([p.measurements.number for p in parts]), time))
    scanner = np.repeat(np.arange(1, len(parts) + 1), [len(p.time) for p in parts])[order]

    def merged(name: str) -> Array:
        return np.asarray(np.concatenate([getattr(p.measurements, name) for p in parts])[order])

    m = Measurements(*(merged(name) for name in Measurements.__annotations__))
    xyz = np.concatenate([p.xyz for p in parts])[order]
    sensor = np.concatenate([p.sensor for p in parts])[order]
    # one stored position per scanner and step of track: a point's origin is off by at most half a step
    cell = np.floor((time[order] - true.time[0]) * spec.speed / _SAMPLE_M).astype(np.int64) * 8 + scanner
    _, first, index = np.unique(cell, return_index=True, return_inverse=True)
    scan = Scan(
        "mobile",
        xyz,
        scene.world,
        sensor[first],
        index.astype(np.int32),
        intensity=m.intensity,
        rgb=scan_colours(scene, m.surface, m.hit, sensor, light) if spec.colour else None,
        time=time[order],
        return_number=m.number,
        return_count=m.count,
        sigma_range=survey.instrument.sigma_range,
    )
    return Drive(scan, m.surface, m.kind, m.true_range, survey.navigation.table, true.table, scanner)
