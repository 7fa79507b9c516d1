"""Terrestrial scans: polar rasters that include the beams without return."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Provenance, Scan
from frontage.model.scan import Grid
from frontage.simulate.optics.light import LightSpec
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import Scene
from frontage.simulate.sensors.instrument import Instrument, ScannerSpec, draw_instrument
from frontage.simulate.sensors.photograph import scan_colours
from frontage.simulate.sensors.positions import approximate_pose, rotation, station_positions
from frontage.simulate.sensors.ranging import Measurements, measure_beams
from frontage.simulate.sensors.recording import Station
from frontage.simulate.sensors.target import Target
from frontage.simulate.sensors.traffic import with_moved_traffic

_REFERENCE_M = 10.0  # range for which `ScannerSpec.spacing` is stated
_TILT_RAD = np.radians(0.3)  # standard deviation: tripods are levelled by eye, the compensator does the rest


@dataclass(frozen=True, eq=False)
class _Setup:
    """What all stations of a scanner have in common."""

    scene: Scene
    spec: ScannerSpec
    instrument: Instrument
    target: Target
    light: LightSpec | None


def scan_stations(
    scene: Scene,
    spec: ScannerSpec,
    seed: int,
    light: LightSpec | None = None,
    only: Sequence[int] | None = None,
) -> tuple[Station, ...]:
    """Scan `scene` from every station of `spec`; the same seed gives the same bytes.

    `light` is that in which the scanner's camera works. `only` are the numbers of the stations to scan now,
    counted from 0; stations do not depend on one another.

    Raises OptionError where there is no room for a station, MissingExtra if embreex is not installed.
    """
    rng = np.random.default_rng([seed, scene.seed, 0x7E])
    instrument = draw_instrument(spec, rng)
    tracer = Tracer(scene.mesh)
    centres = station_positions(scene, spec, tracer)
    if spec.moved:
        places = tuple((float(x), float(y)) for x, y, _ in centres)
        scene = with_moved_traffic(scene, spec.moved, seed, places)
        tracer = Tracer(scene.mesh)
    target = Target(scene, instrument.wavelength, tracer, spectral=spec.spectral, wet=spec.wet)
    setup = _Setup(scene, spec, instrument, target, light)
    return tuple(
        _scan_station(setup, centres[k], k, (seed, scene.seed, 0x7E, k))
        for k in (range(len(centres)) if only is None else only)
    )


def raster(spec: ScannerSpec, forward: float) -> tuple[Float, Float]:
    """Return the azimuths (w,) and the elevations (h,) of a scan, rad.

    Azimuths are counter-clockwise, about `forward`; elevations start with the highest.
    """
    step = spec.spacing / _REFERENCE_M
    field = np.radians(spec.field)
    w = max(int(np.ceil(field / step)), 1)
    h = max(int((np.radians(spec.highest) - np.radians(spec.lowest)) / step) + 1, 1)
    azimuth = forward - field / 2 + field * (np.arange(w) + 0.5) / w
    return azimuth[::-1], np.radians(spec.highest) - step * np.arange(h)


def polar(azimuth: Float, elevation: Float) -> Float:
    """Return the unit directions (n, 3) of azimuths and elevations (n,), rad."""
    flat = np.cos(elevation)
    return np.column_stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)])


def _scan_station(setup: _Setup, centre: Float, number: int, seed: tuple[int, ...]) -> Station:
    """Scans from one station, whose scanner has its centre at `centre` (3,) m local."""
    spec, instrument = setup.spec, setup.instrument
    rng = np.random.default_rng([*seed, 1])
    tilt = _TILT_RAD * rng.normal(size=2)
    true = Rigid3("local", "scanner", rotation(tilt[0], tilt[1], rng.uniform(0, 2 * np.pi)), centre)
    given = approximate_pose(true, spec, rng) if spec.pose == "approximate" else true
    houses = true.inverse.rotate(setup.scene.local_from_street.R[None, :, 1])[0]
    azimuth, elevation = raster(spec, float(np.arctan2(houses[1], houses[0])))
    # column by column, as the head turns: neighbours in memory are neighbours in the scene
    az, el = (g.ravel() for g in np.meshgrid(azimuth, elevation, indexing="ij"))
    noise = instrument.sigma_angle * rng.normal(size=(2, len(az)))
    beams = true.rotate(polar(az + noise[0] / np.maximum(np.cos(el), 0.05), el + noise[1]))
    m = measure_beams(setup.target, instrument, np.broadcast_to(centre, beams.shape), beams, seed)
    xyz = m.range[:, None] * polar(az[m.beam], el[m.beam])
    index = np.full(len(az), -1, np.int64)
    first = np.flatnonzero(m.number == 1)
    index[m.beam[first]] = first
    grid = Grid(index.reshape(len(azimuth), len(elevation)).T)
    name = f"station {number + 1}"
    scan = _as_scan(setup, name, m, grid, xyz=given.apply(xyz), given=given, centre=centre)
    return Station(scan, m.surface, m.kind, m.true_range, true, given)


def _as_scan(
    setup: _Setup, name: str, m: Measurements, grid: Grid, *, xyz: Float, given: Rigid3, centre: Float
) -> Scan:
    """Makes a scan of the points `xyz` (n, 3) m local with the `given` pose; the scanner was at `centre`."""
    several = setup.instrument.echoes == "all"
    colours = scan_colours(setup.scene, m.surface, m.hit, centre, setup.light) if setup.spec.colour else None
    return Scan(
        name,
        xyz,
        setup.scene.world,
        given.t[None],
        np.zeros(len(xyz), np.int32),
        intensity=m.intensity,
        rgb=colours,
        grid=grid,
        sigma_range=setup.instrument.sigma_range,
        local_from_scanner=Estimate(given, _covariance(setup.spec), 0.0, Provenance.GIVEN),
        return_number=m.number if several else None,
        return_count=m.count if several else None,
    )


def _covariance(spec: ScannerSpec) -> Float:
    """Returns the covariance (6, 6) of the pose that is handed over; zero for true poses."""
    if spec.pose == "true":
        return np.zeros((6, 6))
    level, heading = np.radians([spec.sigma_level, spec.sigma_heading])
    return np.diag(np.square([*[spec.sigma_position] * 3, level, level, heading]))
