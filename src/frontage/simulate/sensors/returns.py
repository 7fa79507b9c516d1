"""Turns the light on the paths of each beam into the echoes that the scanner records.

Pulsed ranging: paths whose ranges differ by less than the resolution merge into one echo, at their
energy-weighted mean. Phase-shift ranging: one echo per beam, in which all light adds up as phasors of the
modulation, whatever its range.
"""

from dataclasses import dataclass, fields

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.simulate.sensors.instrument import Instrument
from frontage.simulate.sensors.recording import Echo
from frontage.simulate.sensors.target import REFERENCE_M, BeamPaths

MIXED_BY_M = 0.002
"""An echo counts as mixed if light from other surfaces shifts its range by more than this."""

_DARK = 0.1  # reflectance for which `range_dark` is stated


@dataclass(frozen=True, eq=False)
class Echoes:
    """k echoes without noise, ordered by beam and range.

    beam           row of the beam
    number, count  number of the echo in its beam (from 1), and how many there are
    range          m, at which the light adds up
    energy         relative to a white surface that faces the scanner at 10 m
    width          m, standard deviation of the ranges that the light comes from
    surface, kind  surface that most of the light comes from, and `Echo`
    true_range     m, along the beam to that surface
    cosine         of the angle of incidence there
    """

    beam: Int
    number: Array
    count: Array
    range: Float
    energy: Float
    width: Float
    surface: Array
    kind: Array
    true_range: Float
    cosine: Float

    def __len__(self) -> int:
        return len(self.beam)

    def take(self, index: Array) -> "Echoes":
        """Return the echoes at `index`."""
        return Echoes(*(getattr(self, f.name)[index] for f in fields(self)))


def record_echoes(lots: tuple[BeamPaths, ...], instrument: Instrument) -> Echoes:
    """Return the echoes that the scanner detects and keeps, without noise, ordered by beam and range."""
    if instrument.ranging == "pulsed":
        lots = tuple(part for paths in lots for part in _separated(paths, instrument.resolution))
    tables = [_summary(paths, instrument) for paths in lots]
    all_ = Echoes(*(np.concatenate([getattr(t, f.name) for t in tables]) for f in fields(Echoes)))
    seen = all_.energy >= _DARK * (REFERENCE_M / instrument.range_dark) ** 2
    seen &= (all_.range >= instrument.range_min) & (all_.range <= instrument.range_max)
    found = np.flatnonzero(seen)
    order = found[np.lexsort((all_.range[found], all_.beam[found]))]
    return _kept(all_.take(order), instrument.echoes)


def _separated(paths: BeamPaths, resolution: float) -> list[BeamPaths]:
    """Splits beams into pulses: first those with one pulse, then one lot for the k-th pulse of the others."""
    back = paths.energy > 0
    far = np.where(back, paths.distance, -np.inf).max(1, initial=-np.inf)
    near = np.where(back, paths.distance, np.inf).min(1, initial=np.inf)
    split = far - near > resolution
    many = paths.take(np.flatnonzero(split))
    order = np.argsort(np.where(many.energy > 0, many.distance, np.inf), axis=1)
    columns = [
        np.take_along_axis(getattr(many, f.name), order, 1) for f in fields(BeamPaths) if f.name != "beam"
    ]
    many = BeamPaths(many.beam, *columns)
    pulse = np.zeros(many.energy.shape, np.int64)
    np.cumsum(np.diff(many.distance, axis=1) > resolution, axis=1, out=pulse[:, 1:])
    pulse[many.energy <= 0] = -1
    out = [paths.take(np.flatnonzero(~split & np.isfinite(near)))]
    for p in range(int(pulse.max(initial=-1)) + 1):
        rows = np.flatnonzero((pulse == p).any(1))
        part = many.take(rows)
        energy = np.where(pulse[rows] == p, part.energy, 0.0)
        out.append(BeamPaths(part.beam, energy, part.distance, part.surface, part.kind, part.cosine))
    return out


def _summary(paths: BeamPaths, instrument: Instrument) -> Echoes:
    """Returns one echo per row of `paths`."""
    paths = paths.take(np.flatnonzero((paths.energy > 0).any(1)))
    total = paths.energy.sum(1)
    share = paths.energy / total[:, None]
    mean = (share * paths.distance).sum(1)
    # deviations first, as a variance from raw squares would lose a millimetre at 100 m
    apart = np.where(share > 0, paths.distance - mean[:, None], 0.0)
    width = np.sqrt((share * apart**2).sum(1))
    own, best = _main_surface(paths)
    part = np.where(own, share, 0.0)
    true_range = (part * paths.distance).sum(1) / part.sum(1)
    weak = np.zeros(len(total), np.bool_)
    if instrument.ranging == "phase":
        mean, weak = _phase(share, apart, mean, instrument)
    row = np.arange(len(total))
    kind = np.where(np.abs(mean - true_range) > MIXED_BY_M, Echo.MIXED, paths.kind[row, best]).astype(
        np.uint8
    )
    one = np.ones(len(total), np.uint8)
    return Echoes(
        paths.beam, one, one, mean, np.where(weak, 0.0, total), width,
        paths.surface[row, best], kind, true_range, paths.cosine[row, best],
    )  # fmt: skip


def _phase(share: Float, apart: Float, mean: Float, instrument: Instrument) -> tuple[Float, Bool]:
    """Returns ranges from the phase of the summed modulation, and which sums are too weak to trust (n,).

    The long modulation wavelengths give the energy-weighted mean, which resolves the cycles of the fine one.
    """
    phasor = (share * np.exp((2j * np.pi / instrument.fine) * apart)).sum(1)
    return mean + np.angle(phasor) * instrument.fine / (2 * np.pi), np.abs(phasor) < instrument.coherence


def _main_surface(paths: BeamPaths) -> tuple[Bool, Int]:
    """Returns which paths (n, m) come from the surface that returns most light, and the strongest (n,)."""
    label = paths.surface.astype(np.int64) * 8 + paths.kind
    best = np.argmax(paths.energy, axis=1)
    own = label == np.take_along_axis(label, best[:, None], 1)
    several = np.flatnonzero((~own & (paths.energy > 0)).any(1))
    for rows in np.array_split(several, max(len(several) * label.shape[1] ** 2 // 4_000_000, 1)):
        same = label[rows, :, None] == label[rows, None, :]
        totals = np.einsum("nij,nj->ni", same, paths.energy[rows])
        # the path with most light, of the surface with most light
        most = totals >= totals.max(1, keepdims=True) * (1 - 1e-12)
        best[rows] = np.argmax(np.where(most, paths.energy[rows], -1.0), axis=1)
        own[rows] = label[rows] == np.take_along_axis(label[rows], best[rows, None], 1)
    return own & (paths.energy > 0), best


def _kept(echoes: Echoes, which: str) -> Echoes:
    """Returns the echoes that the scanner keeps of each beam, numbered."""
    n = len(echoes)
    start = np.flatnonzero(np.diff(echoes.beam, prepend=-1))
    count = np.diff(np.append(start, n))
    if which == "all":
        number = np.arange(n) - np.repeat(start, count) + 1
        new = {"number": number.astype(np.uint8), "count": np.repeat(count, count).astype(np.uint8)}
        return Echoes(**{f.name: new.get(f.name, getattr(echoes, f.name)) for f in fields(Echoes)})
    if which == "strongest":
        order = np.lexsort((-echoes.energy, echoes.beam))
        return echoes.take(order[start])
    return echoes.take(start if which == "first" else start + count - 1)
