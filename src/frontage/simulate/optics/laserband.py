"""What a laser sees and a camera does not: reflectances of another spectral band, damp in porous surfaces.

Both are off unless a scanner's specification asks for them. They are properties of the scene: drawn from its
seed, from generators of their own, and the same for every scanner.
"""

import numpy as np
from scipy.special import ndtri

from frontage.geometry.arrays import Array, Float
from frontage.simulate.optics import noise
from frontage.simulate.optics.appearance import appearance_of
from frontage.simulate.scene import Part, Scene

_WAVELENGTHS = (532, 905, 1064, 1550)  # nm, columns of the table below
# rough reflectances by kind of material: what looks dark may be bright in the infrared, and the reverse
_BAND: dict[str, tuple[float, float, float, float]] = {
    "plaster": (0.55, 0.60, 0.58, 0.45), "brick": (0.16, 0.38, 0.44, 0.50),
    "ashlar": (0.42, 0.52, 0.52, 0.46), "stone": (0.42, 0.52, 0.52, 0.46), "wood": (0.22, 0.55, 0.58, 0.36),
    "metal": (0.30, 0.40, 0.42, 0.50), "tiles": (0.16, 0.36, 0.42, 0.48),
    "asphalt": (0.10, 0.15, 0.17, 0.22), "paving": (0.30, 0.36, 0.37, 0.36),
    "leaves": (0.12, 0.55, 0.55, 0.28), "fabric": (0.25, 0.55, 0.58, 0.48),
    "paint": (0.40, 0.45, 0.45, 0.40),
}  # fmt: skip
_SPREAD = 0.4  # one sigma of the logarithm of a material's reflectance about that of its kind
_RANGE = (0.04, 0.9)  # of reflectances
_EXPONENT = (-0.7, 0.7)  # of the visible contrast at full strength: half of the materials invert it
_OWN_LENGTHS_M = (1.7, 0.6, 0.22, 0.08, 0.03)  # wavelengths of the contrast that only the laser sees
_OWN = 0.12  # its standard deviation, as a share of the reflectance

_POROUS = ("plaster", "brick", "ashlar", "stone", "tiles", "asphalt", "paving")
_SOAKED = {532: 0.85, 905: 0.78, 1064: 0.72, 1550: 0.38}  # reflectance by nm when damp, relative to dry
_PATCH_LENGTHS_M = (2.9, 1.3, 0.6, 0.25)
_RUN_M = (0.30, 3.5)  # width and height of the runs that water leaves on walls
_EDGE = 0.25  # width of a patch's edge, in standard deviations of the field
_FOOT, _FOOT_M = 1.5, 0.35  # rising damp: standard deviations added at the foot of walls; its height
_STREAM = 0x57E7


def band_reflectance(scene: Scene, wavelength: int, spectral: float) -> Float:
    """Return the diffuse reflectance (m,) of every material for a laser of `wavelength` nm.

    `spectral` 0 gives those of the scene, which half follow the colours. 1 gives those of another band, which
    depend on the kind of material and not on its colour; between them lie their geometric means. Glass keeps
    its own.
    """
    own = np.array([m.laser for m in scene.materials], np.float64)
    if not spectral:
        return own
    column = _WAVELENGTHS.index(wavelength)
    table = [_BAND[m.kind][column] if m.kind in _BAND else m.laser for m in scene.materials]
    spread = np.random.default_rng([scene.seed, _STREAM, 1]).normal(0, _SPREAD, len(own))
    kept = np.array([m.kind not in _BAND for m in scene.materials])
    band = np.clip(np.array(table) * np.exp(spread), *_RANGE)
    return np.where(kept, own, own ** (1 - spectral) * band**spectral)


def band_exponents(scene: Scene, exponent: Float, spectral: float) -> Float:
    """Return the powers (m,) of the materials' visible contrast, from `exponent` (m,) to a new draw."""
    drawn = np.random.default_rng([scene.seed, _STREAM, 2]).uniform(*_EXPONENT, len(exponent))
    return np.asarray(exponent + spectral * (drawn - exponent))


def own_contrast(scene: Scene, surface: Array, xyz: Float, spectral: float) -> Float:
    """Return factors (n,) of the contrast that is invisible to cameras, at points (n, 3) m local."""
    appearance = appearance_of(scene)
    u, v = appearance.texture_coordinates(surface, xyz, appearance.axes_of_surface[surface])
    field = noise.fractal(
        u,
        v,
        _OWN_LENGTHS_M,
        seed=appearance.seed[appearance.material[surface]],
        salt=211,
        blur=np.zeros(len(u), np.float32),
    )
    return np.asarray(np.exp(spectral * _OWN * field.astype(np.float64)))


def damp_factor(scene: Scene, surface: Array, xyz: Float, wet: float, wavelength: int) -> Float:
    """Return factors (n,) on the reflectance at points (n, 3) m local of surfaces (n,): below 1 where damp.

    A share `wet` of every porous surface outdoors is damp, in patches and, on walls, in runs; walls are
    damper near their foot. Water absorbs much at 1550 nm and little at the other wavelengths (nm).
    """
    dampness = np.zeros(len(surface))
    appearance = appearance_of(scene)
    kinds = np.array([k in _POROUS for k in appearance.kinds])
    porous = kinds[appearance.kind[appearance.material[surface]]] & (appearance.part[surface] != Part.ROOM)
    at = np.flatnonzero(porous)
    if len(at) and wet > 0:
        dampness[at] = np.clip((_damp_field(scene, surface[at], xyz[at]) + ndtri(wet)) / _EDGE + 0.5, 0, 1)
    return 1 - (1 - _SOAKED[wavelength]) * dampness


def _damp_field(scene: Scene, surface: Array, xyz: Float) -> Float:
    """Returns a field (n,) of mean 0 and standard deviation 1, raised near the foot of walls."""
    appearance = appearance_of(scene)
    u, v = appearance.texture_coordinates(surface, xyz, appearance.axes_of_surface[surface])
    seed, blur = appearance.seed[appearance.material[surface]], np.zeros(len(u), np.float32)
    field = noise.fractal(u, v, _PATCH_LENGTHS_M, seed=seed, salt=223, blur=blur, gain=0.7)
    upright = np.isin(appearance.part[surface], (Part.WALL, Part.PLINTH, Part.ORIEL, Part.CHIMNEY))
    runs = noise.wave(u, v, _RUN_M, seed=seed, salt=227, blur=blur)
    field = np.where(upright, 0.8 * field + 0.6 * runs, field)
    low = np.isin(appearance.part[surface], (Part.WALL, Part.PLINTH))
    foot = _FOOT * np.exp(-np.clip(v, 0, 9).astype(np.float64) / _FOOT_M)
    return np.asarray(field + np.where(low, foot, 0.0))
