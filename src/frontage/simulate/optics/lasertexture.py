"""Texture of the reflectance at the laser's wavelength, loosely related to the visible texture."""

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.simulate.optics.materials import shade
from frontage.simulate.scene import Scene

_LUMA = np.array([0.3, 0.59, 0.11])
_EXPONENT = (0.2, 0.9)  # range; the smaller, the less of the visible contrast is left for the laser
_LIMITS = (0.4, 2.0)  # of the factor on a material's mean reflectance


class LaserTexture:
    """How much more or less of the laser each place reflects than its material does on average."""

    def __init__(self, scene: Scene, rng: np.random.Generator) -> None:
        """Draw for every material of `scene` how much of its visible contrast the laser sees."""
        self._scene = scene
        self._exponent = rng.uniform(*_EXPONENT, len(scene.materials))
        self._mean = np.array([m.rgb for m in scene.materials]).reshape(-1, 3) @ _LUMA
        self._material = np.array([s.material for s in scene.surfaces], np.int64)

    def factor(self, surface: Array, xyz: Float) -> Float:
        """Return factors (n,) > 0 on the mean reflectance, at points (n, 3) m local on surfaces (n,)."""
        material = self._material[surface]
        light = np.asarray(shade(self._scene, surface, xyz), np.float64) @ _LUMA
        ratio = light / np.maximum(self._mean[material], 0.01)
        return np.asarray(np.clip(ratio ** self._exponent[material], *_LIMITS))
