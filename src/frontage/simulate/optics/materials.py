"""The colours of surfaces: reflectance as a function of the material and of the position on it.

Every kind of material has a pattern, a function of `TextureSamples`. Patterns know the footprint of a pixel
(`blur`): joints are box-filtered exactly and noise fades before it aliases, so that one sample per pixel is
enough inside a surface. Grain, stains and joints have the sizes of real ones: there is structure at every
scale from 8 mm to metres, on which the matching of image features depends.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.simulate.optics import noise
from frontage.simulate.optics.appearance import Appearance, appearance_of
from frontage.simulate.scene import Scene

_BRICK_JOINT_M = 0.010
_MOSS = np.array([[0.10, 0.11, 0.05]], np.float32)


@dataclass(frozen=True, eq=False)
class TextureSamples:
    """Samples of one kind of material, which may be of several materials.

    u, v         (n,) float32 m, position on the texture plane
    rgb, joint   (n, 3) float32, reflectances of the base and of the joints or stains
    size         (n, 2) float32 m, width and height of one unit (brick, stone, tile)
    seed         (n,) uint32, of the material
    blur         (n,) float32 m, width of a pixel on the surface
    """

    u: Array
    v: Array
    rgb: Array
    joint: Array
    size: Array
    seed: Array
    blur: Array

    def wave(self, length: float | tuple[float, float], salt: int) -> Array:
        """Return noise (n,) of one wavelength (m), standard deviation 1, different for every material."""
        return noise.wave(self.u, self.v, length, seed=self.seed, salt=salt, blur=self.blur)

    def fractal(self, lengths: tuple[float, ...], salt: int, gain: float = 1.0) -> Array:
        """Return noise (n,) of several wavelengths (m), each `gain` times as strong as the one before."""
        return noise.fractal(self.u, self.v, lengths, seed=self.seed, salt=salt, blur=self.blur, gain=gain)


def shade(scene: Scene, surface: Array, xyz: Float, blur: float = 0.0) -> Array:
    """Return the diffuse reflectance (n, 3) float32, linear RGB 0..1, at points (n, 3) m local.

    `surface` (n,) are the indices of their surfaces; the texture is averaged over a width of `blur` m.
    """
    appearance = appearance_of(scene)
    axes = appearance.axes_of_surface[surface]
    return reflectance(appearance, np.asarray(surface), xyz, axes, np.full(len(xyz), blur, np.float32))


def reflectance(appearance: Appearance, surface: Array, xyz: Float, axes: Array, blur: Array) -> Array:
    """Return the diffuse reflectance as `shade` does, given more detail.

    `axes` (n,) uint8 are the texture axes of the triangles (see `Appearance`), `blur` (n,) m the footprints.
    """
    u, v = appearance.texture_coordinates(surface, xyz, axes)
    material = appearance.material[surface]
    kinds = appearance.kind[material]
    rgb = np.empty((len(surface), 3), np.float32)
    for kind in np.flatnonzero(np.bincount(kinds)):
        at = np.flatnonzero(kinds == kind)
        m = material[at]
        patch = TextureSamples(
            u[at],
            v[at],
            appearance.rgb[m],
            appearance.joint[m],
            appearance.size[m],
            appearance.seed[m],
            blur[at].astype(np.float32),
        )
        rgb[at] = _PATTERNS[appearance.kinds[kind]](patch)
    return np.clip(rgb, 0.004, 0.95)


def _tone(rgb: Array, tone: Array) -> Array:
    return np.asarray(rgb * tone[:, None], np.float32)


def _mix(a: Array, b: Array, share: Array) -> Array:
    return np.asarray(a + (b - a) * np.clip(share, 0.0, 1.0)[:, None], np.float32)


def _unit(p: TextureSamples, shift: float) -> tuple[Array, Array, Array]:
    """Returns column and row (n,) of the unit (brick, stone, tile) at each sample, and a contrast factor.

    Every other row is shifted by `shift` units. The factor (n,) fades the contrast between units where a
    pixel covers several of them.
    """
    row = np.floor(p.v / p.size[:, 1])
    column = np.floor(p.u / p.size[:, 0] + shift * (row % 2))
    return column, row, 1.0 / (1.0 + (p.blur / p.size[:, 1]) ** 2)


def _joints(p: TextureSamples, shift: float, width: float) -> Array:
    """Returns the share (n,) of each pixel that is joint, `width` m wide, below and left of every unit."""
    row = np.floor(p.v / p.size[:, 1])
    wide, high = p.size[:, 0], p.size[:, 1]
    bed = noise.stripes(p.v / high, width / high, p.blur / high)
    head = noise.stripes(p.u / wide + shift * (row % 2), width / wide, p.blur / wide)
    return np.asarray(1 - (1 - bed) * (1 - head))


def _weather(p: TextureSamples, strength: float) -> Array:
    """Returns a brightness (n,) about 1: patches, rain streaks, and dirt near the foot of the wall."""
    patches = 0.08 * p.fractal((5.3, 2.3, 1.1, 0.47, 0.21), 11, 0.75)
    streaks = p.wave((0.11, 2.6), 17) + 0.7 * p.wave((0.37, 4.0), 18)
    runs = 0.06 * np.minimum(0.0, streaks + 0.3)
    foot = -0.16 * np.exp(-np.clip(p.v, 0, 9) / 0.35) * (1 + 0.5 * p.wave(0.4, 19))
    return np.asarray(1 + strength * (patches + runs + foot), np.float32)


def _spots(p: TextureSamples, length: float, threshold: float, salt: int) -> Array:
    """Returns rare spots (n,) 0..1, about a third of `length` m wide: pits, repairs, chips."""
    return np.asarray(np.clip(2.5 * (p.wave(length, salt) - threshold), 0, 1), np.float32)


def _brick(p: TextureSamples) -> Array:
    column, row, calm = _unit(p, 0.5)
    tone = 1 + calm * 0.42 * (noise.cell(column, row, p.seed, 1) - 0.5)
    burnt = calm * (noise.cell(column, row, p.seed, 2) > 0.93)
    grain = 1 + 0.07 * p.fractal((0.05, 0.022, 0.010), 21)
    face = _tone(p.rgb, tone * (1 - 0.35 * burnt) * grain)
    face[:, 0] *= 1 + calm * 0.16 * (noise.cell(column, row, p.seed, 3) - 0.5)
    mortar = _tone(p.joint, 1 + 0.08 * p.fractal((0.3, 0.03), 25))
    return _tone(_mix(face, mortar, _joints(p, 0.5, _BRICK_JOINT_M)), _weather(p, 0.9))


def _ashlar(p: TextureSamples) -> Array:
    column, row, calm = _unit(p, 0.5)
    tone = 1 + calm * 0.3 * (noise.cell(column, row, p.seed, 1) - 0.5)
    tone = tone * (1 + 0.065 * p.fractal((0.35, 0.15, 0.07, 0.033, 0.014), 31))
    face = _mix(
        _tone(p.rgb, tone), 0.5 * p.joint, 0.6 * (_spots(p, 0.06, 1.9, 36) + _spots(p, 0.15, 2.0, 37))
    )
    groove = _joints(p, 0.5, 0.014)
    return _tone(_mix(face, p.joint, groove), _weather(p, 1.0))


def _stone(p: TextureSamples) -> Array:
    grain = 1 + 0.065 * p.fractal((0.25, 0.1, 0.045, 0.02, 0.009), 41)
    pits = _spots(p, 0.018, 1.7, 45) + _spots(p, 0.07, 1.9, 46)
    return _mix(_tone(p.rgb, grain * _weather(p, 0.8)), 0.6 * p.joint, 0.5 * pits)


def _plaster(p: TextureSamples) -> Array:
    base = _tone(p.rgb, 1 + 0.09 * p.fractal((0.23, 0.11, 0.05, 0.023, 0.01), 51, 0.9))
    stain = np.clip(0.7 * p.fractal((3.3, 1.7, 0.8, 0.37, 0.17, 0.08), 55, 0.8) - 0.55, 0, 1)
    crack = np.exp(-((p.wave(0.9, 58) + 0.35 * p.wave(0.16, 59)) ** 2) / 0.0006)
    crack *= (p.wave(2.7, 60) > 0.9) * np.exp(-((p.blur / 0.01) ** 2))
    chips = _spots(p, 0.055, 2.0, 61) + 0.8 * _spots(p, 0.13, 1.9, 62) + 0.5 * _spots(p, 0.3, 2.0, 63)
    wall = _mix(_tone(base, _weather(p, 1.0)), p.joint, 0.5 * stain + 0.7 * chips)
    return _tone(wall, 1 - 0.35 * crack)


def _wood(p: TextureSamples) -> Array:
    fibre = p.wave((0.012, 0.5), 71) + 0.8 * p.wave((0.035, 1.1), 72)
    board = np.floor(p.u / 0.11)
    tone = 1 + 0.06 * fibre + 0.10 * (noise.cell(board, np.zeros_like(board), p.seed, 4) - 0.5)
    gap = noise.stripes(p.u / np.float32(0.11), 0.03, p.blur / np.float32(0.11))
    return _mix(_tone(p.rgb, tone), p.joint, 0.7 * gap)


def _metal(p: TextureSamples) -> Array:
    rust = np.clip(p.fractal((0.25, 0.06, 0.02), 81) - 1.2, 0, 1)
    return _mix(_tone(p.rgb, 1 + 0.04 * p.fractal((0.4, 0.02), 85)), p.joint, 0.6 * rust)


def _glass(p: TextureSamples) -> Array:
    dust = 1 + 0.3 * p.fractal((0.5, 0.12, 0.03), 91)
    return _tone(p.rgb, dust)


def _tiles(p: TextureSamples) -> Array:
    column, row, calm = _unit(p, 0.5)
    tone = 1 + calm * 0.4 * (noise.cell(column, row, p.seed, 1) - 0.5)
    down = p.v / p.size[:, 1] - row
    lap = 1 - calm * 0.35 * np.clip(1 - 5 * down, 0, 1)
    moss = np.clip(p.fractal((1.4, 0.6, 0.25, 0.1), 101, 0.85) - 0.8, 0, 1)
    face = _tone(p.rgb, tone * lap * (1 + 0.06 * p.fractal((0.06, 0.02), 104)))
    return _mix(_mix(face, p.joint, _joints(p, 0.5, 0.008)), _MOSS, 0.5 * moss)


def _asphalt(p: TextureSamples) -> Array:
    speckle = 0.2 * p.fractal((0.13, 0.06, 0.03, 0.016, 0.008), 111)
    worn = 0.1 * p.fractal((4.0, 1.7, 0.7, 0.3), 115, 0.85)
    crack = np.exp(-((p.wave(1.9, 118) + 0.3 * p.wave(0.3, 119)) ** 2) / 0.0008)
    patch = noise.cell(np.floor(p.u / 2.3), np.floor(p.v / 1.7), p.seed, 5) > 0.93
    crack *= (p.wave(3.7, 120) > 0.8) * np.exp(-((p.blur / 0.02) ** 2))
    tone = (1 + speckle + worn - 0.22 * patch) * (1 - 0.5 * crack)
    return _tone(p.rgb, tone)


def _paving(p: TextureSamples) -> Array:
    column, row, calm = _unit(p, 0.5)
    tone = 1 + calm * 0.22 * (noise.cell(column, row, p.seed, 1) - 0.5)
    gum = np.clip(p.wave(0.12, 121) - 2.2, 0, 0.7)
    face = _tone(p.rgb, tone * (1 + 0.07 * p.fractal((1.2, 0.08, 0.02, 0.009), 122)) * (1 - gum))
    return _mix(face, p.joint, _joints(p, 0.5, 0.008))


def _leaves(p: TextureSamples) -> Array:
    tone = np.clip(1 + 0.3 * p.fractal((0.9, 0.35, 0.13, 0.05), 131), 0.3, 1.8)
    return _mix(_tone(p.rgb, tone), p.joint, 0.4 + 0.3 * p.fractal((0.7, 0.16), 135))


def _fabric(p: TextureSamples) -> Array:
    folds = 0.22 * p.wave((0.16, 6.0), 141) + 0.08 * p.wave((0.05, 3.0), 142)
    return _tone(p.rgb, 1 + folds + 0.05 * p.wave(0.02, 143))


def _paint(p: TextureSamples) -> Array:
    worn = np.clip(p.fractal((0.30, 0.06, 0.015), 151) - 1.7, 0, 1)
    return _mix(_tone(p.rgb, 1 + 0.025 * p.fractal((0.4, 0.05, 0.012), 154)), p.joint, 0.4 * worn)


_PATTERNS: dict[str, Callable[[TextureSamples], Array]] = {
    "plaster": _plaster,
    "brick": _brick,
    "ashlar": _ashlar,
    "stone": _stone,
    "wood": _wood,
    "metal": _metal,
    "glass": _glass,
    "tiles": _tiles,
    "asphalt": _asphalt,
    "paving": _paving,
    "leaves": _leaves,
    "fabric": _fabric,
    "paint": _paint,
}
KINDS = tuple(_PATTERNS)
"""The kinds of material that have a pattern."""
