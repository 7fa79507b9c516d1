"""True ortho-images: openings, surfaces and depths at the right pixels."""

import numpy as np
import pytest

from frontage.simulate.optics.materials import shade
from frontage.simulate.scene import Part, Scene
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street
from frontage.simulate.truth.ortho import OrthoTruth, true_ortho

GSD = 0.03


@pytest.fixture(scope="module")
def scene() -> Scene:
    return build_street(SceneSpec(seed=2, houses=1))


@pytest.fixture(scope="module")
def ortho(scene: Scene) -> OrthoTruth:
    return true_ortho(scene, 0, 0, GSD)


def parts(scene: Scene, ortho: OrthoTruth) -> np.ndarray:
    return np.where(ortho.surface >= 0, scene.parts[ortho.surface].astype(int), -1)


def centre_of(ring: np.ndarray, ortho: OrthoTruth) -> tuple[int, int]:
    x, z = (ring.min(0) + ring.max(0)) / 2
    return int((ortho.corner[1] - z) / ortho.gsd), int((x - ortho.corner[0]) / ortho.gsd)


def test_every_opening_has_its_position_and_area(scene, ortho):
    plan = scene.houses[0].facades[0]
    assert len(plan.openings) > 2
    for k, opening in enumerate(plan.openings):
        assert ortho.opening[centre_of(opening.ring, ortho)] == k + 1
        x, z = opening.ring.T
        area = 0.5 * abs(np.dot(x, np.roll(z, -1)) - np.dot(z, np.roll(x, -1)))
        around = np.hypot(*(np.roll(opening.ring, -1, axis=0) - opening.ring).T).sum()
        assert (ortho.opening == k + 1).sum() * GSD**2 == pytest.approx(area, abs=0.3 * around * GSD)


def test_depth_is_that_of_the_parts(scene, ortho):
    part = parts(scene, ortho)
    on_wall = (part == Part.WALL) & (ortho.opening == 0) & (np.abs(ortho.depth) < 0.02)
    assert on_wall.mean() > 0.2
    assert np.abs(ortho.depth[on_wall]).max() < 1e-5
    for k, opening in enumerate(scene.houses[0].facades[0].openings):
        pane = (ortho.opening == k + 1) & (part == Part.PANE)
        if opening.glazed and pane.any():
            expected = opening.wall_y + opening.glass_depth
            assert np.median(ortho.depth[pane]) == pytest.approx(expected, abs=0.03)


def test_neither_obstacles_nor_the_underground_are_shown(scene, ortho):
    part = parts(scene, ortho)
    for loose in (Part.TREE, Part.CAR, Part.LAMP, Part.PERSON, Part.GROUND):
        assert not (part == loose).any()
    assert np.isnan(ortho.depth[part == -1]).all()
    assert not ortho.rgb[part == -1].any()
    bottom = np.flatnonzero((part != -1).any(1)).max()
    assert abs(ortho.corner[1] - bottom * GSD) < 1.2


def test_texture_lies_at_the_pixels_it_belongs_to(scene):
    fine = true_ortho(scene, 0, 0, 0.02)
    plan = scene.houses[0].facades[0]
    part = parts(scene, fine)
    rows, columns = np.nonzero((part == Part.WALL) & (np.abs(fine.depth) < 1e-4))
    rows, columns = rows[::5], columns[::5]
    seen = fine.rgb[rows, columns].mean(1)
    match = []
    for dx, dz in ((0, 0), (0.4, 0), (-0.4, 0), (0, 0.4), (0, -0.4)):
        x = fine.corner[0] + (columns + 0.5 + dx) * 0.02
        z = fine.corner[1] - (rows + 0.5 + dz) * 0.02
        xyz = plan.local_from_facade.apply(np.column_stack([x, 0 * x, z]))
        expected = shade(scene, fine.surface[rows, columns], xyz, blur=0.02).mean(1)
        match.append(np.corrcoef(seen, expected)[0, 1])
    assert match[0] > 0.95
    assert match[0] > max(match[1:])


def test_the_image_is_evenly_lit_and_not_mirrored(scene, ortho):
    wall = parts(scene, ortho) == Part.WALL
    grey = ortho.rgb[wall].mean(1)
    assert 40 < grey.mean() < 230
    holes = ortho.rgb[parts(scene, ortho) == Part.PANE].mean()
    assert holes < grey.mean()
    middle = [centre_of(o.ring, ortho)[1] for o in scene.houses[0].facades[0].openings]
    left = [o.ring[:, 0].mean() for o in scene.houses[0].facades[0].openings]
    assert (np.argsort(middle, kind="stable") == np.argsort(left, kind="stable")).mean() > 0.5
    again = true_ortho(scene, 0, 0, GSD)
    assert again.rgb.tobytes() == ortho.rgb.tobytes()
