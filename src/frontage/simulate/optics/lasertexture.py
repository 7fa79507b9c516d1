"""Texture of the reflectance at the laser's wavelength, loosely related to the visible texture."""

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.simulate.optics.laserband import band_exponents, damp_factor, own_contrast
from frontage.simulate.optics.materials import shade
from frontage.simulate.scene import Scene

_LUMA = np.array([0.3, 0.59, 0.11])
_EXPONENT = (0.2, 0.9)  # range; the smaller, the less of the visible contrast is left for the laser
_LIMITS = (0.4, 2.0)  # of the factor on a material's mean reflectance, damp aside


class LaserTexture:
    """How much more or less of the laser each place reflects than its material does on average."""

    def __init__(
        self,
        scene: Scene,
        rng: np.random.Generator,
        wavelength: int = 1550,
        *,
        spectral: float = 0.0,
        wet: float = 0.0,
    ) -> None:
        """Draw for every material of `scene` how much of its visible contrast the laser sees.

        `wavelength` is in nm; `spectral` and `wet`, both 0..1, are explained in `laserband`.
        """
        self._scene = scene
        self._wavelength, self._spectral, self._wet = wavelength, spectral, wet
        exponent = np.asarray(rng.uniform(*_EXPONENT, len(scene.materials)))
        self._exponent = band_exponents(scene, exponent, spectral) if spectral else exponent
        self._mean = np.array([m.rgb for m in scene.materials]).reshape(-1, 3) @ _LUMA
        self._material = np.array([s.material for s in scene.surfaces], np.int64)

    def factor(self, surface: Array, xyz: Float) -> Float:
        """Return factors (n,) > 0 on the mean reflectance, at points (n, 3) m local on surfaces (n,)."""
        material = self._material[surface]
        light = np.asarray(shade(self._scene, surface, xyz), np.float64) @ _LUMA
        ratio = light / np.maximum(self._mean[material], 0.01)
        factor = ratio ** self._exponent[material]
        if self._spectral:
            factor = factor * own_contrast(self._scene, surface, xyz, self._spectral)
        factor = np.clip(factor, *_LIMITS)
        if self._wet:
            factor = factor * damp_factor(self._scene, surface, xyz, self._wet, self._wavelength)
        return np.asarray(factor)
