"""Terrestrial stations: polar rasters with the beams that came back empty."""

from collections.abc import Sequence

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Provenance, Scan
from frontage.model.scan import Grid
from frontage.simulate.optics.light import LightSpec
from frontage.simulate.scene import Scene
from frontage.simulate.sensors.instrument import Instrument, ScannerSpec, draw_instrument
from frontage.simulate.sensors.photograph import scan_colours
from frontage.simulate.sensors.positions import approximate_pose, rotation, station_positions
from frontage.simulate.sensors.ranging import measure_beams
from frontage.simulate.sensors.recording import Station
from frontage.simulate.sensors.target import Target

_REFERENCE = 10.0  # m, where `ScannerSpec.spacing` is stated
_TILT = np.radians(0.3)  # rad, one sigma: tripods are levelled by eye, the compensator does the rest


def scan_stations(
    scene: Scene,
    spec: ScannerSpec,
    seed: int,
    light: LightSpec | None = None,
    only: Sequence[int] | None = None,
) -> tuple[Station, ...]:
    """Scan `scene` from every station of `spec`, its camera in `light`; the same seed gives the same bytes.

    `only` = the numbers of those to scan now, counted from 0: stations do not depend on one another.

    Raises OptionError where a station cannot stand, MissingExtra without the ray tracer.
    """
    rng = np.random.default_rng([seed, scene.seed, 0x7E])
    instrument = draw_instrument(spec, rng)
    target = Target(scene, instrument.wavelength)
    centres = station_positions(scene, spec, target.tracer)
    return tuple(
        _station(scene, spec, instrument, target, centres[k], k, (seed, scene.seed, 0x7E, k), light)
        for k in (range(len(centres)) if only is None else only)
    )


def raster(spec: ScannerSpec, forward: float) -> tuple[Float, Float]:
    """Azimuths (w,) counter-clockwise about `forward`, and elevations (h,) from the highest down, rad."""
    step = spec.spacing / _REFERENCE
    field = np.radians(spec.field)
    w = max(int(np.ceil(field / step)), 1)
    h = max(int((np.radians(spec.highest) - np.radians(spec.lowest)) / step) + 1, 1)
    azimuth = forward - field / 2 + field * (np.arange(w) + 0.5) / w
    return azimuth[::-1], np.radians(spec.highest) - step * np.arange(h)


def polar(azimuth: Float, elevation: Float) -> Float:
    """Unit directions (n, 3) of azimuths and elevations (n,), rad."""
    flat = np.cos(elevation)
    return np.column_stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)])


def _station(
    scene: Scene,
    spec: ScannerSpec,
    instrument: Instrument,
    target: Target,
    centre: Float,
    number: int,
    seed: tuple[int, ...],
    light: LightSpec | None,
) -> Station:
    rng = np.random.default_rng([*seed, 1])
    tilt = _TILT * rng.normal(size=2)
    true = Rigid3("local", "scanner", rotation(tilt[0], tilt[1], rng.uniform(0, 2 * np.pi)), centre)
    given = approximate_pose(true, spec, rng) if spec.pose == "approximate" else true
    houses = true.inverse.rotate(scene.local_from_street.R[None, :, 1])[0]
    azimuth, elevation = raster(spec, float(np.arctan2(houses[1], houses[0])))
    # column by column, as the head turns: neighbours in memory are neighbours in the scene
    az, el = (g.ravel() for g in np.meshgrid(azimuth, elevation, indexing="ij"))
    noise = instrument.sigma_angle * rng.normal(size=(2, len(az)))
    beams = true.rotate(polar(az + noise[0] / np.maximum(np.cos(el), 0.05), el + noise[1]))
    m = measure_beams(target, instrument, np.broadcast_to(centre, beams.shape), beams, seed)
    xyz = m.range[:, None] * polar(az[m.beam], el[m.beam])
    index = np.full(len(az), -1, np.int64)
    first = np.flatnonzero(m.number == 1)
    index[m.beam[first]] = first
    several = instrument.echoes == "all"
    scan = Scan(
        f"station {number + 1}",
        given.apply(xyz),
        scene.world,
        given.t[None],
        np.zeros(len(xyz), np.int32),
        intensity=m.intensity,
        rgb=scan_colours(scene, m.surface, m.hit, centre, light) if spec.colour else None,
        grid=Grid(index.reshape(len(azimuth), len(elevation)).T),
        sigma_range=instrument.sigma_range,
        local_from_scanner=Estimate(given, _covariance(spec), 0.0, Provenance.GIVEN),
        return_number=m.number if several else None,
        return_count=m.count if several else None,
    )
    return Station(scan, m.surface, m.kind, m.true_range, true, given)


def _covariance(spec: ScannerSpec) -> Float:
    """Of the pose handed over (6, 6): nothing for true ones."""
    if spec.pose == "true":
        return np.zeros((6, 6))
    level, heading = np.radians([spec.sigma_level, spec.sigma_heading])
    return np.diag(np.square([*[spec.sigma_position] * 3, level, level, heading]))
