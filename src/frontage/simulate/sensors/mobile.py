"""A vehicle with two profile scanners: true motion, the trajectory it believes in, and its points."""

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

_SCANNERS = 2
_ARM = 0.25  # m, scanners before and behind the vehicle's reference point
_LEAN = (15.0, 30.0)  # degrees by which profiles lean forward: none runs along the jambs of windows
_ROOF = np.radians(35)  # rad about straight down that the vehicle's roof hides
_SAMPLE = 0.02  # m of track between stored sensor positions


@dataclass(frozen=True)
class _Mount:
    """A scanner on the vehicle: offset (3,) m and rotation (3, 3), body from scanner, true and calibrated."""

    offset: Float
    true: Float
    calibrated: Float


def drive(scene: Scene, spec: DriveSpec, seed: int, light: LightSpec | None = None) -> Drive:
    """Drive once along the road of `scene`, from before the first house to behind the last.

    Points are placed with the trajectory that the vehicle believes in and the calibrated mounting angles.
    `light` is the day that the vehicle's camera works in. The same seed gives the same bytes.

    Raises OptionError for a road without length, MissingExtra without the ray tracer.
    """
    rng = np.random.default_rng([seed, scene.seed, 0x3B])
    instrument = draw_instrument(spec, rng)
    lane = spec.lane if spec.lane is not None else float(rng.uniform(0.0, 2.0))
    if len(scene.road) < 2 or not np.ptp(scene.road, axis=0).any():
        raise OptionError(
            f"scene '{scene.name}' has no road to drive along; give it one of two points or more"
        )
    first, last = street_extent(scene)
    true = drive_along(scene, first - spec.overrun, last + spec.overrun, lane, spec, rng)
    navigation = navigation_solution(true, spec, rng)
    target = Target(scene, instrument.wavelength)
    lean = np.radians(rng.uniform(*_LEAN))
    parts = []
    for k in range(_SCANNERS):
        mount = _mount(spec, k, lean, rng)
        parts.append(
            _profiles(spec, instrument, target, mount, k, true, navigation, (seed, scene.seed, 0x3B, k))
        )
    return _joined(scene, spec, instrument, true, navigation, parts, light)


def _mount(spec: DriveSpec, number: int, lean: float, rng: np.random.Generator) -> _Mount:
    """Scanner `number`: its profiles turned out of the cross-section by the tilt, one to each side."""
    side = 1 if number == 0 else -1
    nominal = rotation(0.0, side * lean, side * np.radians(spec.tilt))
    error = np.radians(spec.boresight) * rng.normal(size=3)
    return _Mount(np.array([side * _ARM, 0.0, 0.0]), nominal @ rotation(*error), nominal)


def _profiles(
    spec: DriveSpec,
    instrument: Instrument,
    target: Target,
    mount: _Mount,
    number: int,
    true: Track,
    navigation: Track,
    seed: tuple[int, ...],
) -> tuple[Measurements, Float, Float, Float]:
    """Echoes of one scanner, with gps_time (k,), points (k, 3) and sensor positions (k, 3) as navigation."""
    rng = np.random.default_rng([*seed, 1])
    turns = int((true.time[-1] - true.time[0]) * spec.profile_rate)
    step = np.arange(turns * spec.beams) + 0.5 * number
    time, angle = true.time[0] + step / (spec.beams * spec.profile_rate), 2 * np.pi * step / spec.beams
    # angle 0 looks straight down
    free = np.abs((angle + np.pi) % (2 * np.pi) - np.pi) > _ROOF
    time, angle = time[free], angle[free]
    noise = instrument.sigma_angle * rng.normal(size=(2, len(angle)))
    at, attitude = true.at(time)
    beams = rotate_to_local(attitude, _profile(angle + noise[0], noise[1]) @ mount.true.T)
    origins = at + rotate_to_local(attitude, np.broadcast_to(mount.offset, beams.shape))
    m = measure_beams(target, instrument, origins, beams, seed)
    at, attitude = navigation.at(time[m.beam])
    sensor = at + rotate_to_local(attitude, np.broadcast_to(mount.offset, at.shape))
    ray = rotate_to_local(attitude, _profile(angle[m.beam], np.zeros(len(m.beam))) @ mount.calibrated.T)
    return m, time[m.beam], sensor + m.range[:, None] * ray, sensor


def _profile(angle: Float, aside: Float) -> Float:
    """Unit directions (n, 3) in the scanner's frame: x along the mirror's axis, angle from straight down."""
    d = np.column_stack([aside, np.sin(angle), -np.cos(angle)])
    return np.asarray(d / np.sqrt(1 + aside**2)[:, None])


def _joined(
    scene: Scene,
    spec: DriveSpec,
    instrument: Instrument,
    true: Track,
    navigation: Track,
    parts: list[tuple[Measurements, Float, Float, Float]],
    light: LightSpec | None,
) -> Drive:
    """The echoes of all scanners in order of time."""
    time = np.concatenate([p[1] for p in parts])
    order = np.lexsort((np.concatenate([p[0].number for p in parts]), time))
    scanner = np.repeat(np.arange(1, len(parts) + 1), [len(p[1]) for p in parts])[order]

    def merged(name: str) -> Array:
        return np.asarray(np.concatenate([getattr(p[0], name) for p in parts])[order])

    m = Measurements(*(merged(name) for name in Measurements.__annotations__))
    xyz, sensor = (np.concatenate([p[i] for p in parts])[order] for i in (2, 3))
    # one stored position per scanner and step of track: a point's origin is at most half a step off
    cell = np.floor((time[order] - true.time[0]) * spec.speed / _SAMPLE).astype(np.int64) * 8 + scanner
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
        sigma_range=instrument.sigma_range,
    )
    return Drive(scan, m.surface, m.kind, m.true_range, navigation.table, true.table, scanner)
