"""Texture in the laser's reflectance: bricks, joints and stains, as the eye sees them but only loosely so."""

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.simulate.optics.materials import shade
from frontage.simulate.scene import Scene

_LUMA = np.array([0.3, 0.59, 0.11])
_LIKENESS = (0.2, 0.9)  # exponent range: how much of the contrast in light is left in the infrared
_LIMITS = (0.4, 2.0)  # of the factor on a material's mean reflectance


class LaserTexture:
    """The factor by which a place reflects more or less of the laser than its material does on average."""

    def __init__(self, scene: Scene, rng: np.random.Generator) -> None:
        """Draw how alike laser and light are for every material of `scene`."""
        self._scene = scene
        self._likeness = rng.uniform(*_LIKENESS, len(scene.materials))
        self._mean = np.array([m.rgb for m in scene.materials]).reshape(-1, 3) @ _LUMA
        self._material = np.array([s.material for s in scene.surfaces], np.int64)

    def factor(self, surface: Array, xyz: Float) -> Float:
        """Factors (n,) at points (n, 3) m local on surfaces (n,), all >= 0."""
        material = self._material[surface]
        light = np.asarray(shade(self._scene, surface, xyz), np.float64) @ _LUMA
        ratio = light / np.maximum(self._mean[material], 0.01)
        return np.asarray(np.clip(ratio ** self._likeness[material], *_LIMITS))
