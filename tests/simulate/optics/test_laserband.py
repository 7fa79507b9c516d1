"""Another spectral band and damp: what the laser sees and the camera does not."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.simulate.optics.laserband import band_reflectance, damp_factor
from frontage.simulate.optics.lasertexture import LaserTexture
from frontage.simulate.optics.materials import KINDS, shade
from frontage.simulate.scene import Part, Scene
from laser_scenes import scene_of, wall


def two_walls(kind: str = "plaster", **more: object) -> Scene:
    return scene_of(wall(10.0, **more), wall(14.0, **more), kind=kind)  # type: ignore[arg-type]


def points(n: int, low: float = -2.0, high: float = 20.0) -> np.ndarray:
    rng = np.random.default_rng(1)
    return np.column_stack([rng.uniform(-30, 30, n), np.full(n, 10.0), rng.uniform(low, high, n)])


def texture(scene: Scene, seed: int = 2, **more: float) -> LaserTexture:
    return LaserTexture(scene, np.random.default_rng(seed), **more)  # type: ignore[arg-type]


ZERO = np.zeros(20_000, np.int64)


@pytest.mark.parametrize(("wavelength", "least", "most"), [(1550, 0.3, 0.45), (905, 0.7, 0.85)])
def test_damp_patches_are_darker_to_the_laser_and_as_bright_as_before_to_the_camera(wavelength, least, most):
    scene = two_walls()
    xyz = points(len(ZERO))
    factor = damp_factor(scene, ZERO, xyz, 0.3, wavelength)
    assert least < factor.min() < most and factor.max() == 1.0
    damp, dry = factor < 0.99 * factor.min() + 0.01, factor == 1.0
    wet_wall = texture(scene, wavelength=wavelength, wet=0.3).factor(ZERO, xyz)
    plain = texture(scene, wavelength=wavelength).factor(ZERO, xyz)
    np.testing.assert_array_equal(wet_wall[dry], plain[dry])
    assert np.median(wet_wall[damp] / plain[damp]) == pytest.approx(factor.min(), rel=0.02)
    luma = shade(scene, ZERO, xyz).mean(1)
    assert luma[damp].mean() == pytest.approx(luma[dry].mean(), rel=0.03)


@pytest.mark.parametrize("wet", [0.1, 0.3, 0.6])
def test_the_stated_share_of_a_surface_is_damp(wet):
    high = points(len(ZERO), low=3.0)  # above the rising damp at the foot
    inside = damp_factor(two_walls(), ZERO, high, wet, 1550)
    assert ((1 - inside) / (1 - inside.min()) > 0.5).mean() == pytest.approx(wet, abs=0.08)


def test_walls_are_damper_near_their_foot():
    foot, above = (points(len(ZERO), *z) for z in ((-5.0, -4.8), (4.0, 6.0)))
    wet, dry = (damp_factor(two_walls(), ZERO, xyz, 0.2, 1550).mean() for xyz in (foot, above))
    assert wet < dry - 0.2


def test_all_or_nothing_is_damp():
    xyz = points(500)
    assert (damp_factor(two_walls(), ZERO[:500], xyz, 0.0, 1550) == 1).all()
    assert np.ptp(damp_factor(two_walls(), ZERO[:500], xyz, 1.0, 1550)) == 0


@pytest.mark.parametrize("scene", [two_walls("metal"), two_walls("plaster", part=Part.ROOM)])
def test_metal_and_rooms_stay_dry(scene):
    assert (damp_factor(scene, ZERO, points(len(ZERO)), 0.9, 1550) == 1).all()


def test_nothing_changes_without_the_keys():
    scene, xyz = two_walls(), points(2000)
    plain = LaserTexture(scene, np.random.default_rng(2)).factor(ZERO[:2000], xyz)
    off = texture(scene, spectral=0.0, wet=0.0, wavelength=905).factor(ZERO[:2000], xyz)
    np.testing.assert_array_equal(off, plain)
    own = [m.laser for m in scene.materials]
    np.testing.assert_array_equal(band_reflectance(scene, 905, 0.0), own)


def coloured(count: int, kind: str) -> Scene:
    """Returns walls of one kind of material, every other one dark, to the laser as to the eye."""
    scene = scene_of(*[wall(10.0 + k) for k in range(count)], kind=kind)
    tones = [0.1, 0.7] * (count // 2)
    materials = [replace(m, rgb=(t,) * 3, laser=t) for m, t in zip(scene.materials, tones, strict=True)]
    return replace(scene, materials=tuple(materials))


def test_in_another_band_dark_materials_are_as_bright_as_light_ones():
    scene = coloured(200, "wood")
    ratios = [np.log(b[1::2] / b[::2]) for b in (band_reflectance(scene, 1064, s) for s in (0, 0.5, 1))]
    assert (ratios[0] > 1.9).all()
    assert np.median(ratios[1]) == pytest.approx(np.median(ratios[0]) / 2, abs=0.2)
    assert abs(np.median(ratios[2])) < 0.2
    assert 0.35 < (ratios[2] < 0).mean() < 0.65  # half of the pairs have the opposite contrast


def test_leaves_are_bright_in_the_near_infrared_only():
    leaves = coloured(40, "leaves")
    at = {nm: np.median(band_reflectance(leaves, nm, 1.0)) for nm in (532, 905, 1550)}
    assert at[905] > 2 * at[532] and at[905] > 1.5 * at[1550]


def test_texture_of_another_band_is_unrelated_to_the_visible_one():
    scene = scene_of(*[wall(10.0 + k) for k in range(40)], kind="brick")
    scene = replace(
        scene,
        materials=tuple(
            replace(m, rgb=(0.35, 0.15, 0.1), rgb_joint=(0.5, 0.48, 0.45), seed=k)
            for k, m in enumerate(scene.materials)
        ),
    )
    xyz, alike = points(3000), {0.0: [], 1.0: []}
    for k in range(40):
        surface = np.full(3000, k)
        visible = np.log(shade(scene, surface, xyz).mean(1))
        for spectral, found in alike.items():
            laser = np.log(texture(scene, spectral=spectral).factor(surface, xyz))
            found.append(np.corrcoef(visible, laser)[0, 1])
    assert min(alike[0.0]) > 0.7
    assert min(alike[1.0]) < -0.4 and abs(np.median(alike[1.0])) < 0.5
    assert 0.25 < np.mean(np.array(alike[1.0]) < 0) < 0.75


def test_every_kind_of_material_has_a_band():
    for kind in KINDS:
        band = band_reflectance(coloured(2, kind), 1550, 1.0)
        assert (band > 0).all() and (band <= 0.9).all()
        assert (kind == "glass") == bool((band == [0.1, 0.7]).all())
