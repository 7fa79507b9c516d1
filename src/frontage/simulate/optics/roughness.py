"""Rough surfaces: a random height field per surface, which is added to ranges instead of being meshed."""

import numpy as np
from scipy.special import gammaincinv

from frontage.geometry.arrays import Array, Float
from frontage.simulate.scene import Part, Scene, SceneSurface

_WAVES = 32  # number of cosines per field: their sum is Gaussian to a few percent
_SHAPE = 0.5  # a of the rational quadratic covariance
_GRAIN, _GRAIN_LENGTH_M = 0.6, 0.015  # of render, pores and joints: share of the roughness, correlation
_BULGE_M, _BULGE_LENGTH_M = (0.0015, 0.006), (0.8, 2.0)  # ranges: bulges of walls, and their correlation
_OBLIQUE_COS = 0.25  # cosine of incidence below which heights are no longer stretched along the beam
_SAMPLES = 2000  # number of points of a wall from which its mean plane is determined


class Roughness:
    """The heights of every surface: the sum of three random fields, drawn from the scene's seed.

    roughness   with the rational quadratic covariance sigma^2 (1 + d^2 / (2 a l^2))^-a, a = 1/2, where sigma
                and l are roughness and correlation of the `SceneSurface`; it is a mixture of all scales about
                l (Rasmussen & Williams 2006, eq. 4.19)
    grain       a share of the roughness, correlated over 15 mm
    bulges      of walls: some millimetres over metres, as in real scans

    Every field is a sum of cosines. The mean plane of a wall is subtracted, so that its true plane remains
    the one that it was built on.
    """

    def __init__(self, scene: Scene) -> None:
        """Draw the fields of every surface of `scene`."""
        rng = np.random.default_rng([scene.seed, 0x40])
        sigma = np.array([s.roughness for s in scene.surfaces])
        length = np.array([max(s.correlation, 1e-3) for s in scene.surfaces])
        wall = (scene.parts == Part.WALL) & (sigma > 0)
        wavy = np.where(wall, rng.uniform(*_BULGE_M, len(sigma)), 0.0)
        self._planes = np.array([_plane(s) for s in scene.surfaces]).reshape(-1, 3, 3)
        self._sigma = np.stack([sigma, _GRAIN * sigma, wavy])
        self._length = np.stack(
            [length, np.full(len(sigma), _GRAIN_LENGTH_M), rng.uniform(*_BULGE_LENGTH_M, len(sigma))]
        )
        # one wave per quantile of the scales, as 32 independent draws would miss the long ones
        scale = np.sqrt(gammaincinv(_SHAPE, (rng.permutation(_WAVES) + 0.5) / _WAVES) / _SHAPE)
        self._wave = rng.normal(size=(3, _WAVES, 2))
        self._wave[0] *= scale[:, None]
        self._phase = rng.uniform(0, 2 * np.pi, (3, len(sigma), _WAVES))
        self._mean = np.zeros((len(sigma), 3))
        for s in np.flatnonzero(wall & np.isin(np.arange(len(sigma)), scene.mesh.surface)):
            self._mean[s] = self._mean_plane(scene, int(s), rng)

    def heights(self, surface: Array, xyz: Float) -> Float:
        """Return the outward heights (n,) m of surfaces (n,) at points (n, 3) m local; smooth ones have 0."""
        out = np.zeros(len(surface))
        rough = np.flatnonzero(self._sigma[0, surface] > 0)
        s = surface[rough]
        at = self._texture(s, xyz[rough])
        total = -(self._mean[s, 0] + np.einsum("nj,nj->n", at, self._mean[s, 1:]))
        for sigma, length, waves, phase in zip(
            self._sigma, self._length, self._wave, self._phase, strict=True
        ):
            here = np.flatnonzero(sigma[s] > 0)
            k, p = s[here], at[here] / length[s[here], None]
            field = np.zeros(len(here))
            for w, wave in enumerate(waves):
                field += np.cos(p @ wave + phase[k, w])
            total[here] += sigma[k] * np.sqrt(2 / _WAVES) * field
        out[rough] = total
        return out

    def shortening(self, surface: Array, xyz: Float, cosine: Float) -> Float:
        """Return by how much (n,) m the heights shorten beams that meet surfaces at `cosine` of incidence."""
        return np.asarray(self.heights(surface, xyz) / np.maximum(cosine, _OBLIQUE_COS))

    def _texture(self, surface: Array, xyz: Float) -> Float:
        plane = self._planes[surface]
        return np.asarray(np.einsum("nij,nj->ni", plane[:, 1:], xyz - plane[:, 0]))

    def _mean_plane(self, scene: Scene, surface: int, rng: np.random.Generator) -> Float:
        """Fits a plane to a surface's heights over its area: height and two slopes (3,)."""
        corners = scene.mesh.vertices[scene.mesh.corners[scene.mesh.surface == surface]]
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        row = rng.choice(len(corners), _SAMPLES, p=area / area.sum())
        weight = rng.dirichlet(np.ones(3), _SAMPLES)
        xyz = np.einsum("nk,nkj->nj", weight, corners[row])
        which = np.full(_SAMPLES, surface)
        design = np.column_stack([np.ones(_SAMPLES), self._texture(which, xyz)])
        return np.asarray(np.linalg.lstsq(design, self.heights(which, xyz), rcond=None)[0])


def _plane(surface: SceneSurface) -> list[tuple[float, float, float]]:
    return [surface.origin, surface.u, surface.v]
