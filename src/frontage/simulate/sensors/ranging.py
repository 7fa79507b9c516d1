"""Measures with a laser: true beams in, noisy ranges and intensities out."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Float, Int
from frontage.simulate.sensors.footprint import sub_rays
from frontage.simulate.sensors.instrument import Instrument
from frontage.simulate.sensors.recording import Echo
from frontage.simulate.sensors.returns import Echoes, record_echoes
from frontage.simulate.sensors.target import Target

_BATCH = 20_000  # beams traced together, so that their sub-rays stay in the processor's cache
_ENERGY_FLOOR, _ENERGY_CEILING = 1e-4, 4.0  # between which the range noise depends on the energy

_LOG = 255.0  # steepness of the logarithmic curve: its slope at 0 is 46 times that of a straight line


def _linear(value: Float) -> Float:
    return value


def _log(value: Float) -> Float:
    return np.asarray(np.log1p(_LOG * value) / np.log1p(_LOG))


_CURVES: dict[str, Callable[[Float], Float]] = {"linear": _linear, "root": np.sqrt, "log": _log}


@dataclass(frozen=True, eq=False)
class Measurements:
    """The k echoes of all beams, in order, as they are recorded.

    beam           (k,) number of the beam
    number, count  (k,) uint8, number of the echo in its beam (from 1), and how many there are
    range          (k,) m, as recorded
    intensity      (k,) float32, 0..1
    surface, kind, true_range   (k,), as in `recording.Recording`
    hit            (k, 3) m local, where the light was scattered
    """

    beam: Int
    number: Array
    count: Array
    range: Float
    intensity: Array
    surface: Array
    kind: Array
    true_range: Float
    hit: Float


def measure_beams(
    target: Target, instrument: Instrument, origins: Float, directions: Float, seed: tuple[int, ...]
) -> Measurements:
    """Send beams from `origins` (n, 3) m along true unit `directions` (n, 3), local; return the echoes.

    All noise is drawn from `seed`.
    """
    lots = [
        _measure_batch(
            target, instrument, origins[k : k + _BATCH], directions[k : k + _BATCH], first=k, seed=seed
        )
        for k in range(0, len(directions), _BATCH)
    ]
    return Measurements(
        *(np.concatenate([getattr(m, name) for m in lots]) for name in Measurements.__annotations__)
    )


def _measure_batch(
    target: Target,
    instrument: Instrument,
    origins: Float,
    directions: Float,
    *,
    first: int,
    seed: tuple[int, ...],
) -> Measurements:
    """Measures with some beams, of which the first has the number `first`."""
    rng = np.random.default_rng([*seed, first])
    paths = target.trace(instrument, *sub_rays(instrument, origins, directions, first))
    e = _with_strays(record_echoes(paths, instrument), len(directions), instrument, rng)
    hit = origins[e.beam] + e.true_range[:, None] * directions[e.beam]
    real = np.flatnonzero(np.isin(e.kind, (Echo.PLAIN, Echo.MIXED, Echo.THROUGH_GLASS)))
    near, texture = np.zeros(len(e)), np.ones(len(e))
    near[real] = target.roughness.shortening(e.surface[real], hit[real], e.cosine[real])
    texture[real] = target.texture.factor(e.surface[real], hit[real])
    energy = e.energy * texture
    scale = np.clip(energy, _ENERGY_FLOOR, _ENERGY_CEILING) ** -instrument.exponent
    sigma = np.hypot(
        instrument.sigma_range * scale, instrument.spread * e.width * (instrument.sigma_range > 0)
    )
    return Measurements(
        first + e.beam,
        e.number,
        e.count,
        e.range - near + sigma * rng.normal(size=len(e)),
        _intensity(energy, instrument, rng),
        e.surface,
        e.kind,
        e.true_range,
        hit,
    )


def _intensity(energy: Float, instrument: Instrument, rng: np.random.Generator) -> Array:
    """Returns the recorded intensity (k,) float32 in 0..1: gain, speckle, saturation, curve, quantisation."""
    value = energy * instrument.gain * (1 + instrument.speckle * rng.normal(size=len(energy)))
    top = instrument.levels - 1
    curve = _CURVES[instrument.response]
    return (np.rint(curve(np.clip(value, 0, 1)) * top) / top).astype(np.float32)


def _with_strays(echoes: Echoes, beams: int, instrument: Instrument, rng: np.random.Generator) -> Echoes:
    """Lets some beams record dust, rain or sunlight somewhere in front of a surface, instead of it."""
    stray = np.flatnonzero(rng.random(beams) < instrument.strays)
    own = echoes.take(np.flatnonzero(~np.isin(echoes.beam, stray)))
    limit = np.full(beams, instrument.range_max)
    np.minimum.at(limit, echoes.beam, echoes.range)
    at = instrument.range_min + rng.random(len(stray)) * (limit[stray] - instrument.range_min)
    one, zero = np.ones(len(stray), np.uint8), np.zeros(len(stray))
    faint = rng.uniform(0.001, 0.02, len(stray))
    kind, none = np.full(len(stray), Echo.STRAY, np.uint8), np.full(len(stray), -1, np.int32)
    extra = Echoes(stray, one, one, at, faint, zero, none, kind, at, zero)
    both = Echoes(*(np.concatenate([getattr(own, n), getattr(extra, n)]) for n in Echoes.__annotations__))
    return both.take(np.argsort(both.beam, kind="stable"))
