"""Follows sub-rays of a laser to the surfaces that return light, also through panes and mirrored in them.

Energies are relative to a white (reflectance 1) diffuse surface that faces the scanner at 10 m.
"""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.simulate.optics.glass import Panes, draw_panes, pane_optics
from frontage.simulate.optics.laserband import band_reflectance
from frontage.simulate.optics.lasertexture import LaserTexture
from frontage.simulate.optics.rays import Hits, Tracer
from frontage.simulate.optics.roughness import Roughness
from frontage.simulate.scene import Part, Scene
from frontage.simulate.sensors.footprint import beam_pattern
from frontage.simulate.sensors.instrument import Instrument
from frontage.simulate.sensors.recording import Echo

REFERENCE_M = 10.0
"""Range at which a white surface that faces the scanner returns the energy 1."""

_SKIP_M = 1e-3  # beyond a pane, where the ray continues
_PANES = 4  # greatest number of panes that a ray passes: in and out through two windows
_LOBE_RAD = 0.15  # half-width of the reflection of gloss paint, slates, car bodies
_GLOSSY = 0.05 / (2 * _LOBE_RAD**2)  # peak of a lobe with 5 % of the light, relative to a diffuse reflector
_FLAT_RAD = 3e-3  # waviness of panes: within this angle, the mirrored beam comes straight back
_DAZZLE = 1e3  # energy of a perfect mirror that faces the scanner at the reference range; saturates the echo


Columns = tuple[Float, Float, Array, Array, Float]
"""Energy, distance, surface, kind and cosine of some paths, as in `BeamPaths`."""


@dataclass(frozen=True, eq=False)
class BeamPaths:
    """The light on m paths of each of n beams: of its sub-rays and, at panes, of their branches.

    beam       (n,) row of the beam; all other fields are (n, m)
    energy     0 = no light
    distance   m along the beam, as the scanner would record it; 0 = no light
    surface    index of the surface that scattered the light; -1 = none
    kind       `Echo`
    cosine     of the angle of incidence on that surface
    """

    beam: Array
    energy: Float
    distance: Float
    surface: Array
    kind: Array
    cosine: Float

    def take(self, rows: Array) -> "BeamPaths":
        """Return the beams at `rows`."""
        return BeamPaths(*(getattr(self, f)[rows] for f in self.__annotations__))


@dataclass(frozen=True, eq=False)
class _AtPanes:
    """n rays that meet a pane: origins o and directions d (n, 3), panes, hits on them, and power (n,)."""

    o: Float
    d: Float
    panes: Panes
    hits: Hits
    power: Float


class Target:
    """A scene as a target of one laser: tracer, reflectances, panes, roughness."""

    def __init__(
        self,
        scene: Scene,
        wavelength: int,
        tracer: Tracer | None = None,
        *,
        spectral: float = 0.0,
        wet: float = 0.0,
    ) -> None:
        """Prepare `scene` for a laser of `wavelength` nm; panes are drawn from the scene's seed.

        `spectral` and `wet`, both 0..1, are explained in `laserband`.

        Raises MissingExtra if embreex is not installed and no `tracer` is given.
        """
        self.tracer = tracer or Tracer(scene.mesh)
        self.roughness = Roughness(scene)
        rng = np.random.default_rng([scene.seed, 0x71])
        self.texture = LaserTexture(scene, rng, wavelength, spectral=spectral, wet=wet)
        laser = band_reflectance(scene, wavelength, spectral)
        material = [scene.materials[s.material] for s in scene.surfaces]
        self._albedo = laser[np.array([s.material for s in scene.surfaces], np.int64)]
        self._gloss = np.array([m.gloss for m in material])
        self._surface = scene.mesh.surface
        self._normal = scene.mesh.normals
        self.is_pane = scene.parts == Part.PANE
        self._pane_row = np.cumsum(self.is_pane) - 1
        house = np.array([s.house + 1 for s in scene.surfaces], np.int64)
        rng = np.random.default_rng([scene.seed, 0x91])
        self.panes = draw_panes(house[self.is_pane], wavelength, rng)

    def trace(self, instrument: Instrument, origins: Float, directions: Float) -> tuple[BeamPaths, ...]:
        """Follow the k sub-rays of n beams, with origins (n, k, 3) m local and unit directions (n, k, 3).

        Returns two lots: the beams that meet no pane (m = k paths), and those that do (m = 3 k paths: direct,
        through the panes, mirrored by them).
        """
        n, k = directions.shape[:2]
        o, d = origins.reshape(-1, 3), directions.reshape(-1, 3)
        hits = self.tracer.first_hit(o, d)
        surface = np.where(hits.found, self._surface[hits.triangle], -1).astype(np.int32)
        power = np.tile(beam_pattern(k)[1], n)
        at = np.flatnonzero(hits.found & self.is_pane[surface])
        energy = power * self._scattered(instrument, surface, hits)
        kind = np.full(n * k, Echo.PLAIN, np.uint8)
        one, optics = hits.take(at), self.panes.take(self._pane_row[surface[at]])
        energy[at], kind[at] = power[at] * self._from_pane(instrument, optics, one), Echo.PANE
        direct = (energy, np.where(hits.found, hits.distance, 0.0), surface, kind, hits.cosine)
        glazed = np.zeros(n, np.bool_)
        glazed[at // k] = True
        paned = _AtPanes(o[at], d[at], optics, one, power[at])
        branches = [f(instrument, paned) for f in (self._through, self._mirrored)]
        columns = [direct, *(_spread(b, at, n * k) for b in branches)]
        return (_lot(columns[:1], np.flatnonzero(~glazed), n), _lot(columns, np.flatnonzero(glazed), n))

    def _scattered(
        self, instrument: Instrument, surface: Array, hits: Hits, extra: Float | None = None
    ) -> Float:
        """Returns the energy (n,) of beams that end on surfaces (n,), diffuse and glossy.

        `extra` (n,) m is added to the distance.
        """
        cosine = hits.cosine
        albedo, gloss = self._albedo[surface], self._gloss[surface]
        # the mirrored direction and that back to the scanner differ by twice the angle of incidence
        lobe = gloss * _GLOSSY * np.exp((cosine * cosine - 1) * (2 / _LOBE_RAD**2))
        back = albedo * cosine**instrument.falloff + lobe
        distance = hits.distance if extra is None else hits.distance + extra
        return np.where(surface >= 0, back * _received(instrument, distance), 0.0)

    def _from_pane(self, instrument: Instrument, panes: Panes, hits: Hits) -> Float:
        """Returns the energy (n,) from panes: of dirt, and of mirrored beams that come straight back."""
        cosine = hits.cosine
        reflected, _ = pane_optics(panes, cosine)
        straight = _DAZZLE * reflected * np.exp((cosine * cosine - 1) * (2 / _FLAT_RAD**2))
        back = panes.dirt * cosine**instrument.falloff + straight
        return np.asarray(back * _received(instrument, hits.distance))

    def _through(self, instrument: Instrument, rays: _AtPanes) -> Columns:
        """Returns the light that passes the pane, and perhaps more panes, there and back."""
        n, o, d = len(rays.o), rays.o, rays.d
        share = pane_optics(rays.panes, rays.hits.cosine)[1]
        done = Hits(np.full(n, -1, np.int64), np.full(n, np.inf), np.zeros(n))
        going, here = np.arange(n), rays.hits.distance.copy()
        for _ in range(_PANES):
            ahead = self.tracer.first_hit(o[going] + here[going, None] * d[going], d[going], _SKIP_M)
            here[going] += ahead.distance
            surface = self._surface[ahead.triangle]
            again = ahead.found & self.is_pane[surface]
            end = going[~again]
            done.triangle[end], done.distance[end] = ahead.triangle[~again], here[end]
            done.cosine[end] = ahead.cosine[~again]
            going = going[again]
            more = self.panes.take(self._pane_row[surface[again]])
            share[going] *= pane_optics(more, ahead.cosine[again])[1]
        surface = np.where(done.found, self._surface[done.triangle], -1).astype(np.int32)
        energy = rays.power * share**2 * self._scattered(instrument, surface, done)
        kind = np.full(n, Echo.THROUGH_GLASS, np.uint8)
        return energy, np.where(done.found, done.distance, 0.0), surface, kind, done.cosine

    def _mirrored(self, instrument: Instrument, rays: _AtPanes) -> Columns:
        """Returns the light that the pane mirrors to something else and back: recorded behind the pane."""
        d, hits = rays.d, rays.hits
        normal = self._normal[hits.triangle]
        away = d - 2 * np.einsum("ij,ij->i", d, normal)[:, None] * normal
        found = self.tracer.first_hit(rays.o + hits.distance[:, None] * d, away, _SKIP_M)
        surface = np.where(found.found, self._surface[found.triangle], -1).astype(np.int32)
        surface[surface >= 0] = np.where(self.is_pane[s := surface[surface >= 0]], -1, s)
        share = pane_optics(rays.panes, hits.cosine)[0]
        energy = rays.power * share**2 * self._scattered(instrument, surface, found, hits.distance)
        distance = np.where(surface >= 0, found.distance + hits.distance, 0.0)
        return energy, distance, surface, np.full(len(d), Echo.GHOST, np.uint8), found.cosine


def _received(instrument: Instrument, distance: Float) -> Float:
    """Returns the received share of the scattered light: 1/R^2 with a near-range roll-off, 0 at infinity."""
    r = np.maximum(distance, 1e-3)
    return np.asarray((REFERENCE_M / r) ** 2 * -np.expm1(-((r / instrument.near) ** 2)))


def _spread(branch: Columns, at: Array, n: int) -> Columns:
    """Spreads the columns of the paths `at` to columns of all n paths, empty elsewhere."""
    out = []
    for values, empty in zip(branch, (0, 0, -1, 0, 0), strict=True):
        full = np.full(n, empty, values.dtype)
        full[at] = values
        out.append(full)
    return out[0], out[1], out[2], out[3], out[4]


def _lot(columns: list[Columns], rows: Array, n: int) -> BeamPaths:
    """Puts the paths of the beams `rows`, out of n, side by side."""
    fields = [np.concatenate([c[i].reshape(n, -1)[rows] for c in columns], axis=1) for i in range(5)]
    return BeamPaths(rows, *fields)
