"""Procedural materials: textured at every scale, prefiltered, repeatable."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.simulate.optics.appearance import appearance_of
from frontage.simulate.optics.materials import KINDS, reflectance, shade
from frontage.simulate.scene import Scene
from laser_scenes import scene_of, wall


def wall_of(kind: str, seed: int = 3) -> Scene:
    scene = scene_of(wall(0.0))
    material = replace(
        scene.materials[0],
        kind=kind,
        rgb=(0.5, 0.4, 0.3),
        rgb_joint=(0.2, 0.2, 0.2),
        size=(0.25, 0.083),
        seed=seed,
    )
    return replace(scene, materials=(material,))


def grid(n: int, step: float) -> np.ndarray:
    x, z = np.meshgrid((np.arange(n) + 0.5) * step, (np.arange(n) + 0.5) * step)
    return np.column_stack([x.ravel() + 1.0, np.zeros(x.size), z.ravel() + 1.0])


def picture(scene: Scene, n: int, step: float) -> np.ndarray:
    xyz, zero = grid(n, step), np.zeros(n * n, np.int64)
    blur = np.full(n * n, step, np.float32)
    return reflectance(appearance_of(scene), zero, xyz, np.zeros(n * n, np.uint8), blur).reshape(n, n, 3)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_a_reflectance_with_texture_that_its_seed_decides(kind):
    scene = wall_of(kind)
    zero, xyz = np.zeros(10000, np.int64), grid(100, 0.01)
    rgb = shade(scene, zero, xyz)
    assert rgb.shape == (10000, 3) and rgb.dtype == np.float32
    assert rgb.min() > 0 and rgb.max() <= 0.95
    assert rgb.mean(1).std() > 0.005
    assert (shade(scene, zero, xyz) == rgb).all()
    assert (shade(wall_of(kind, 4), zero, xyz) != rgb).mean() > 0.5
    assert rgb.mean() == pytest.approx(0.4, abs=0.2)


@pytest.mark.parametrize("kind", ["brick", "ashlar", "plaster", "tiles", "paving"])
def test_coarse_pixels_are_the_mean_of_fine_ones(kind):
    scene = wall_of(kind)
    fine, coarse = picture(scene, 480, 0.005), picture(scene, 48, 0.05)
    mean = fine.reshape(48, 10, 48, 10, 3).mean((1, 3))
    points = shade(scene, np.zeros(48 * 48, np.int64), grid(48, 0.05)).reshape(48, 48, 3)
    miss, aliased = (np.sqrt(np.mean((x - mean) ** 2)) for x in (coarse, points))
    assert miss < 0.75 * aliased
    assert coarse.mean() == pytest.approx(fine.mean(), rel=0.05)


def test_bricks_lie_in_courses_with_broken_joints():
    rgb = picture(wall_of("brick"), 500, 0.002)[..., 0]
    rows = rgb.mean(1)
    spectrum = np.abs(np.fft.rfft(rows - rows.mean()))
    assert 1.0 / np.fft.rfftfreq(500, 0.002)[np.argmax(spectrum)] == pytest.approx(0.083, rel=0.05)


def test_each_face_of_a_box_is_textured_along_its_own_axes():
    """A sill's top must not be smeared along the direction that its texture plane does not have."""
    scene = scene_of(wall(0.0))
    top = replace(scene.surfaces[0], u=(1.0, 0.0, 0.0), v=(0.0, 0.0, 1.0))
    mesh = scene.mesh
    flat = mesh.vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0]  # the same sheet lying level
    scene = replace(scene, surfaces=(top,), mesh=replace(mesh, vertices=flat))
    appearance = appearance_of(scene)
    assert (appearance.axes == 1).all()
    xyz = np.column_stack([np.zeros(200), np.linspace(0, 1, 200), np.zeros(200)])
    assert np.ptp(shade(scene, np.zeros(200, np.int64), xyz)[:, 0]) > 0.01
