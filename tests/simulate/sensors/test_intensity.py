"""The recorded intensity: its curve and its steps, and what damp and another band change in a scan."""

import numpy as np
import pytest

from frontage.simulate.scene import Scene
from frontage.simulate.sensors.instrument import Instrument, ScannerSpec, draw_instrument
from frontage.simulate.sensors.ranging import Measurements, measure_beams
from frontage.simulate.sensors.target import Target
from laser_scenes import instrument, scene_of, towards, wall


def measured(scene: Scene, beam: Instrument, **keys: float) -> Measurements:
    x = np.linspace(-15, 15, 4000)
    points = np.column_stack([x, np.full(len(x), 10.0), 6 + 4 * np.sin(5 * x)])
    d = towards(points, np.zeros(3))
    return measure_beams(Target(scene, 1550, **keys), beam, np.zeros(d.shape), d, (3,))


def test_curves_of_the_intensity_are_monotonic_and_keep_black_and_white() -> None:
    scene = scene_of(wall(10.0))
    linear, root, logarithmic = (
        measured(scene, instrument(gain=0.8, response=r)).intensity for r in ("linear", "root", "log")
    )
    np.testing.assert_allclose(root, np.sqrt(linear), atol=1e-4)
    np.testing.assert_allclose(logarithmic, np.log1p(255 * linear) / np.log(256), atol=1e-4)
    near = measured(scene_of(wall(10.0, laser=0.9)), instrument(gain=50.0, response="log")).intensity
    assert near.max() == 1.0


def test_the_intensity_has_the_stated_number_of_steps() -> None:
    for bits in (8, 12):
        beam = draw_instrument(ScannerSpec(bits=bits), np.random.default_rng(1))
        value = measured(scene_of(wall(10.0)), beam).intensity * (2**bits - 1)
        np.testing.assert_allclose(value, np.rint(value), atol=1e-3)
        assert len(np.unique(value)) > 20
    drawn = {draw_instrument(ScannerSpec(), np.random.default_rng(k)).levels for k in range(20)}
    assert drawn == {4096, 65536}


def test_how_the_intensity_is_recorded_changes_no_other_draw() -> None:
    free = draw_instrument(ScannerSpec(), np.random.default_rng(4))
    keys = ScannerSpec(bits=8, response="log", wet=0.5, spectral=1.0, moved=1.0)
    stated = draw_instrument(keys, np.random.default_rng(4))
    changed = {n for n in Instrument.__annotations__ if getattr(free, n) != getattr(stated, n)}
    assert changed == {"levels", "response"}


def test_damp_lowers_the_intensity_in_places_and_moves_no_point() -> None:
    scene, beam = scene_of(wall(10.0, laser=0.6), kind="plaster"), instrument()
    dry, damp = measured(scene, beam), measured(scene, beam, wet=0.3)
    for name in ("beam", "range", "surface", "kind", "hit"):
        np.testing.assert_array_equal(getattr(damp, name), getattr(dry, name))
    ratio = damp.intensity / dry.intensity
    assert ratio.min() == pytest.approx(0.38, abs=0.01) and ratio.max() == pytest.approx(1.0, abs=1e-4)
    assert 0.1 < (ratio < 0.69).mean() < 0.5


def test_another_band_decides_which_of_two_walls_is_brighter() -> None:
    walls = scene_of(wall(10.0, x=(-30, 0), laser=0.1), wall(10.0, x=(0, 30), laser=0.6), kind="paint")
    beam, ratios = instrument(gain=0.2), []
    for keys in ({}, {"spectral": 1.0}):
        m = measured(walls, beam, **keys)
        left, right = (np.median(m.intensity[m.surface == k]) for k in (0, 1))
        ratios.append(right / left)
    assert ratios[0] == pytest.approx(6, rel=0.3) and 0.3 < ratios[1] < 3
