"""Echoes: how light from several surfaces adds up, for pulsed and phase-shift ranging, and through glass."""

import numpy as np
import pytest

from frontage.simulate.optics.glass import Panes, pane_optics
from frontage.simulate.optics.roughness import Roughness
from frontage.simulate.scene import Part, Scene
from frontage.simulate.sensors.footprint import sub_rays
from frontage.simulate.sensors.instrument import Instrument
from frontage.simulate.sensors.ranging import measure_beams
from frontage.simulate.sensors.recording import Echo
from frontage.simulate.sensors.returns import Echoes, record_echoes
from frontage.simulate.sensors.target import Target
from laser_scenes import Sheet, instrument, scene_of, towards, wall

ORIGIN = np.zeros(3)


def echoes(scene: Scene, beam: Instrument, points: np.ndarray, target: Target | None = None) -> Echoes:
    """Noise-free echoes of beams from the origin towards points (n, 3)."""
    d = towards(points, ORIGIN)
    rays = sub_rays(beam, np.zeros(d.shape), d, 0)
    return record_echoes((target or Target(scene, beam.wavelength)).trace(beam, *rays), beam)


def across(x: np.ndarray, y: float) -> np.ndarray:
    """Points (n, 3) at `x` on the plane y, level with the scanner."""
    return np.column_stack([x, np.full(len(x), y), np.zeros(len(x))])


def step(gap: float, near: float = 0.5, far: float = 0.5) -> Scene:
    """A wall at y = 20 for x < 0, in front of a wall that is `gap` m farther away."""
    return scene_of(wall(20.0, x=(-30, 0), laser=near), wall(20.0 + gap, laser=far))


WIDE = {"exit_beam": 0.006, "divergence": 0.4e-3}


def test_one_wall_gives_one_echo_at_the_middle_of_the_footprint() -> None:
    beam = instrument(**WIDE)
    points = across(np.linspace(-20, 20, 300), 20.0)
    e = echoes(scene_of(wall(20.0)), beam, points)
    assert (e.beam == np.arange(300)).all() and (e.kind == Echo.PLAIN).all()
    np.testing.assert_allclose(e.range, np.linalg.norm(points, axis=1), atol=1e-4)
    # an oblique wall spreads the ranges over the footprint: width = tan(incidence) x sigma of the beam
    slope = np.abs(points[:, 0]) / 20
    sigma = np.array([beam.footprint(r) / 4 for r in np.linalg.norm(points, axis=1)])
    np.testing.assert_allclose(e.width, slope * sigma, rtol=0.02, atol=1e-5)


def test_pulsed_echoes_closer_than_the_resolution_merge_by_energy() -> None:
    beam = instrument(**WIDE, resolution=0.3)
    x = np.linspace(-0.01, 0.01, 81)
    e = echoes(step(0.1, near=0.6, far=0.2), beam, across(x, 20.0))
    assert len(e) == len(x)
    share = (e.range - 20.0) / 0.1
    assert share[0] == pytest.approx(0, abs=1e-3) and share[-1] == pytest.approx(1, abs=1e-3)
    assert ((share > 0.02) & (share < 0.98)).sum() > 10
    # three times brighter near wall: at the edge itself a quarter of the way, not half
    assert np.median(share[38:43]) == pytest.approx(0.25, abs=0.12)
    mixed = e.kind == Echo.MIXED
    assert mixed[(share > 0.1) & (share < 0.9)].all() and not mixed[[0, -1]].any()
    assert set(e.surface[mixed]) == {0, 1}


@pytest.mark.parametrize(("which", "expected"), [("first", 20.0), ("last", 21.0), ("strongest", 21.0)])
def test_pulsed_echoes_farther_apart_stay_two(which: str, expected: float) -> None:
    scene = step(1.0, near=0.2, far=0.8)
    at_edge = across(np.array([0.0]), 20.0)
    both = echoes(scene, instrument(**WIDE, resolution=0.3, echoes="all"), at_edge)
    np.testing.assert_allclose(both.range, [20.0, 21.0], atol=1e-3)
    assert both.number.tolist() == [1, 2] and both.count.tolist() == [2, 2]
    assert (both.kind == Echo.PLAIN).all() and both.surface.tolist() == [0, 1]
    one = echoes(scene, instrument(**WIDE, resolution=0.3, echoes=which), at_edge)
    np.testing.assert_allclose(one.range, [expected], atol=1e-3)


def test_phase_shift_gives_one_range_per_beam_or_none() -> None:
    x = np.linspace(-0.01, 0.01, 401)
    phase = {"ranging": "phase", "fine": 1.2, "coherence": 0.5}
    close = echoes(step(0.3), instrument(**WIDE, **phase), across(x, 20.0))
    assert len(close) == len(x)
    assert ((close.range > 20.05) & (close.range < 20.25)).sum() > 20
    # half a fine wavelength apart the two phasors cancel where both walls return alike
    far = echoes(step(0.6), instrument(**WIDE, **phase), across(x, 20.0))
    assert 5 < len(x) - len(far) < 250
    assert (np.abs(x[np.setdiff1d(np.arange(len(x)), far.beam)]) < 0.006).all()


def test_a_whole_fine_wavelength_apart_phases_agree_on_a_wrong_range() -> None:
    """The phasors add up, and the coarse mean can only choose between whole cycles."""
    beam = instrument(**WIDE, ranging="phase", fine=1.2, coherence=0.5)
    e = echoes(step(1.2), beam, across(np.linspace(-0.01, 0.01, 101), 20.0))
    assert len(e) == 101
    near, far = np.abs(e.range - 20.0) < 0.02, np.abs(e.range - 21.2) < 0.02
    assert (near | far).all() and near.any() and far.any()


def window(room: float = 4.0, turned: float = 0.0) -> Scene:
    """A pane in a wall at y = 20, a room behind it, and a wall behind the scanner, 10 m away."""
    back = Sheet((30.0, -10.0, -5.0), (-60.0, 0, 0), (0, 0, 25.0), laser=0.8)
    pane = Sheet((-1.0, 20.0 - turned, -1.0), (2.0, 2 * turned, 0), (0, 0, 2.0), Part.PANE, 0.0)
    left, right = wall(20.0, x=(-30, -1.0)), wall(20.0, x=(1.0, 30))
    return scene_of(left, right, pane, wall(20.0 + room, laser=0.6), back)


def target_with(scene: Scene, beam: Instrument, sheets: int, coating: float, dirt: float) -> Target:
    target = Target(scene, beam.wavelength)
    target.panes = Panes(*(np.array([v]) for v in (sheets, coating, 0.0, dirt)))
    return target


def test_light_through_a_pane_obeys_the_square_of_its_transmission() -> None:
    beam = instrument(exit_beam=0.002, divergence=1e-4, echoes="all", range_dark=300.0, near=0.1, falloff=1.0)
    scene = window()
    point = across(np.array([0.5]), 20.0)
    e = echoes(scene, beam, point, target_with(scene, beam, 1, 0.0, 1e-9))
    inside = e.take(np.flatnonzero(e.kind == Echo.THROUGH_GLASS))
    cosine = 20 / np.linalg.norm(point)
    _, through = pane_optics(Panes(*(np.array([v]) for v in (1, 0.0, 0.0, 0.0))), np.array([cosine]))
    assert inside.range[0] == pytest.approx(24 / cosine, abs=1e-4)
    assert inside.energy[0] == pytest.approx(
        0.6 * cosine * through[0] ** 2 * (10 * cosine / 24) ** 2, rel=1e-3
    )


def test_a_mirrored_wall_is_recorded_straight_behind_the_pane() -> None:
    beam = instrument(
        exit_beam=0.002, divergence=1e-4, echoes="strongest", range_dark=300.0, near=0.1, falloff=1.0
    )
    scene = window(room=4.0)
    point = across(np.array([0.6]), 20.0)
    e = echoes(scene, beam, point, target_with(scene, beam, 2, 0.9, 1e-9))
    assert e.kind.tolist() == [Echo.GHOST] and e.surface.tolist() == [4]
    cosine = 20 / np.linalg.norm(point)
    assert e.range[0] == pytest.approx((20 + 30) / cosine, abs=1e-4)


def test_the_strongest_light_at_a_window_is_recorded() -> None:
    """The same window: a dark room gives no echo, a dirty pane and a bright room do."""
    scene, points = window(), across(np.linspace(0.3, 0.9, 50), 20.0)
    beam = instrument(range_dark=60.0, echoes="strongest", resolution=0.3)

    def kinds(coating: float, dirt: float) -> set[int]:
        return set(echoes(scene, beam, points, target_with(scene, beam, 2, coating, dirt)).kind.tolist())

    assert kinds(0.0, 1e-5) == {Echo.THROUGH_GLASS}
    assert kinds(0.78, 1e-5) == {Echo.GHOST}
    assert kinds(0.6, 1e-5) <= {Echo.GHOST, Echo.THROUGH_GLASS}
    assert kinds(0.78, 0.2) == {Echo.PANE}
    assert (
        echoes(scene, instrument(range_dark=12.0), points, target_with(scene, beam, 2, 0.5, 1e-5)).beam.size
        == 0
    )


def test_a_pane_that_faces_the_scanner_dazzles() -> None:
    beam, scene = instrument(echoes="strongest"), window()
    e = echoes(scene, beam, across(np.array([0.0, 0.5]), 20.0), target_with(scene, beam, 2, 0.0, 1e-5))
    assert e.kind[0] == Echo.PANE and e.range[0] == pytest.approx(20.0, abs=1e-3)
    assert e.kind[1] != Echo.PANE and e.energy[0] > 50 * e.energy[1]


def test_dark_and_far_surfaces_are_lost_beyond_the_stated_range() -> None:
    beam = instrument(range_dark=40.0, range_max=200.0, falloff=1.0, near=0.1)
    for laser, limit in ((0.1, 40.0), (0.4, 80.0)):
        for y in (0.97 * limit, 1.03 * limit):
            e = echoes(scene_of(wall(y, laser=laser)), beam, across(np.zeros(1), y))
            assert len(e) == (y < limit), (laser, y)


def test_range_limits_are_kept() -> None:
    beam = instrument(range_min=5.0, range_max=30.0)
    for y, seen in ((4.9, 0), (5.1, 1), (29.9, 1), (30.1, 0)):
        assert len(echoes(scene_of(wall(y)), beam, across(np.zeros(1), y))) == seen


def test_intensity_follows_reflectance_cosine_and_range() -> None:
    beam = instrument(
        falloff=1.2, near=2.0, gain=0.05, sigma_range=0.0, strays=0.0, subrays=7, range_dark=500.0
    )
    values = {}
    for laser in (0.2, 0.8):
        for y in (4.0, 15.0, 45.0):
            points = across(np.linspace(0, 1.5 * y, 40), y)
            d = towards(points, ORIGIN)
            target = Target(scene_of(wall(y, x=(-100, 100), laser=laser)), 905)
            m = measure_beams(target, beam, np.zeros((40, 3)), d, (1,))
            albedo = laser * target.texture.factor(
                m.surface, m.hit
            )  # the mean of the material and its texture
            r = np.linalg.norm(points, axis=1)
            law = 0.05 * albedo * (y / r) ** 1.2 * (10 / r) ** 2 * (1 - np.exp(-((r / 2.0) ** 2)))
            np.testing.assert_allclose(m.intensity, law, rtol=3e-3)
            values[laser, y] = m.intensity[0]
    assert values[0.8, 15.0] / values[0.2, 15.0] == pytest.approx(4, rel=0.01)


def test_range_noise_grows_with_decreasing_energy() -> None:
    beam = instrument(sigma_range=0.002, exponent=0.4, spread=0.0, strays=0.0, near=0.1)

    def scatter(y: float) -> float:
        points = across(np.linspace(-0.2, 0.2, 4000) * y / 10, y)
        d = towards(points, ORIGIN)
        m = measure_beams(Target(scene_of(wall(y, laser=1.0)), 905), beam, np.zeros(d.shape), d, (3,))
        return float(np.std(m.range - np.linalg.norm(points, axis=1)))

    assert scatter(10.0) == pytest.approx(0.002, rel=0.06)
    assert scatter(40.0) == pytest.approx(0.002 * 16**0.4, rel=0.06)


def rough_heights(seed: int) -> np.ndarray:
    """Heights (40, 40) m of a rough wall, 16 x 16 m, on a grid of 0.4 m."""
    scene = scene_of(wall(10.0, x=(-8, 8), z=(-8, 8), roughness=0.003), seed=seed)
    x, z = np.meshgrid(np.arange(-7.8, 8, 0.4), np.arange(-7.8, 8, 0.4))
    points = np.column_stack([x.ravel(), np.full(x.size, 10.0), z.ravel()])
    return Roughness(scene).heights(np.zeros(x.size, int), points).reshape(x.shape)


def test_rough_walls_bulge_about_the_plane_they_were_built_on() -> None:
    fields = np.array([rough_heights(seed) for seed in range(12)])
    # roughness 3 mm, its grain 1.8 mm, waves of 1.5 to 6 mm
    assert np.hypot(0.003, 0.0015) < np.sqrt((fields**2).mean()) < np.hypot(0.004, 0.006)
    assert np.abs(fields.mean((1, 2))).max() < 5e-4 < fields.std()
    slope = np.polyfit(np.arange(40) * 0.4, fields.mean(1).T, 1)[0]
    assert np.abs(slope).max() < 1e-4


def test_neighbouring_heights_are_alike_and_distant_ones_are_not() -> None:
    fields = np.array([rough_heights(seed) for seed in range(12)])

    def correlation(k: int) -> float:
        return float(np.corrcoef(fields[:, :, :-k].ravel(), fields[:, :, k:].ravel())[0, 1])

    assert correlation(1) > 0.55 > 0.3 > correlation(12)


def test_heights_shorten_the_ranges() -> None:
    beam = instrument(sigma_range=0.0, strays=0.0)
    target = Target(scene_of(wall(10.0, x=(-40, 40), z=(-20, 20), roughness=0.003)), 905)
    x = np.linspace(-20, 20, 1000)
    m = measure_beams(target, beam, across(x, 0.0), np.tile([0.0, 1.0, 0.0], (1000, 1)), (1,))
    np.testing.assert_allclose(10.0 - m.range, target.roughness.heights(m.surface, m.hit), atol=1e-9)
    assert np.abs(m.true_range - 10).max() < 1e-6


def test_texture_of_the_wall_shows_in_the_intensity() -> None:
    bricks = Target(scene_of(wall(10.0), wall(11.0), kind="brick"), 905)
    x, z = np.meshgrid(np.arange(0, 3, 0.01), np.arange(0, 3, 0.01))
    points = np.column_stack([x.ravel(), np.full(x.size, 10.0), z.ravel()])
    factor = bricks.texture.factor(np.zeros(x.size, int), points)
    assert 0.02 < factor.std() / factor.mean() < 0.5 and (factor > 0).all()
    assert bricks.texture.factor(np.zeros(x.size, int), points).tobytes() == factor.tobytes()
