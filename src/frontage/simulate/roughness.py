"""Rough surfaces: a smooth random height field per surface, added to ranges rather than meshed."""

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.simulate.scene import Scene, Surface

_WAVES = 24  # cosines per field: their sum is Gaussian to a few percent
_FLATTEST = 0.25  # cosine of incidence below which heights are no longer stretched along the beam


class Roughness:
    """Heights of every surface: cosines whose wave vectors give a Gaussian covariance.

    cov(h(p), h(q)) = sigma^2 exp(-|p - q|^2 / (2 l^2)), with sigma = `Surface.roughness`, l = `.correlation`.
    """

    def __init__(self, scene: Scene) -> None:
        """Draw the waves of every surface from the scene's seed and the surface's number."""
        self._sigma = np.array([s.roughness for s in scene.surfaces])
        self._length = np.array([max(s.correlation, 1e-3) for s in scene.surfaces])
        self._planes = np.array([_plane(s) for s in scene.surfaces]).reshape(-1, 3, 3)
        rng = np.random.default_rng([scene.seed, 0x40])
        self._wave = rng.normal(size=(_WAVES, 2))
        self._phase = rng.uniform(0, 2 * np.pi, (len(scene.surfaces), _WAVES))

    def heights(self, surface: Array, xyz: Float) -> Float:
        """Height (n,) m of surfaces (n,) at points (n, 3) m local, outward; 0 where the surface is smooth."""
        out = np.zeros(len(surface))
        rough = np.flatnonzero(self._sigma[surface] > 0)
        s, plane = surface[rough], self._planes[surface[rough]]
        at = np.einsum("nij,nj->ni", plane[:, 1:], xyz[rough] - plane[:, 0]) / self._length[s, None]
        total = np.zeros(len(rough))
        for k, wave in enumerate(self._wave):
            total += np.cos(at @ wave + self._phase[s, k])
        out[rough] = self._sigma[s] * np.sqrt(2 / _WAVES) * total
        return out

    def shortening(self, surface: Array, xyz: Float, cosine: Float) -> Float:
        """How much nearer (n,) m the surface is along beams that meet it at `cosine` of incidence."""
        return np.asarray(self.heights(surface, xyz) / np.maximum(cosine, _FLATTEST))


def _plane(surface: Surface) -> list[tuple[float, float, float]]:
    return [surface.origin, surface.u, surface.v]
