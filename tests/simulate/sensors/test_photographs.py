"""Photos of a few sheets (geometry, shadows, panes, sensor noise) and of a street."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from frontage.errors import OptionError
from frontage.geometry.rigid import Rigid3
from frontage.model import Camera
from frontage.simulate.optics.light import LightSpec, draw_light
from frontage.simulate.optics.litscene import LitScene
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.optics.samples import lattice
from frontage.simulate.scene import Part, Scene
from frontage.simulate.sensors.cameras import CameraSpec, Standpoint, make_camera
from frontage.simulate.sensors.imaging import develop
from frontage.simulate.sensors.photograph import scan_colours, take_photographs
from frontage.simulate.sensors.render import render
from frontage.simulate.sensors.viewpoints import plan_photos
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street
from laser_scenes import Sheet, ground, scene_of, wall

OVERCAST = LightSpec(overcast=1.0)
SUNNY = LightSpec(overcast=0.0, sun_elevation=45.0, sun_azimuth=180.0)  # behind the photographer


def painted(scene: Scene, *tones: float) -> Scene:
    """The scene in which sheet k has grey tone k, with only the slight texture of paint."""
    return replace(
        scene,
        materials=tuple(
            replace(m, rgb=(t, t, t), rgb_joint=(t, t, t))
            for m, t in zip(scene.materials, tones, strict=True)
        ),
    )


def looking_ahead(at: tuple[float, float, float], turn: float = 0.0) -> Rigid3:
    """A camera at `at` that looks along +y, turned to the right by `turn` rad."""
    c, s = np.cos(turn), np.sin(turn)
    right, forward = np.array([c, -s, 0.0]), np.array([s, c, 0.0])
    R = np.column_stack([right, [0.0, 0.0, -1.0], forward])
    return Rigid3("local", "camera", R, np.array(at, float))


def lit(scene: Scene, spec: LightSpec) -> LitScene:
    return LitScene(scene, draw_light(scene, spec))


@pytest.mark.parametrize("model", ["PINHOLE", "OPENCV", "OPENCV_FISHEYE", "EQUIRECTANGULAR"])
def test_an_edge_appears_where_the_camera_projects_it(model):
    low, high = np.array([-0.7, 0.9]), np.array([1.3, 2.4])
    board = Sheet((low[0], 8.0, low[1]), (*(high - low)[:1], 0, 0), (0, 0, (high - low)[1]))
    scene = painted(scene_of(wall(8.5), board), 0.8, 0.05)
    camera = make_camera(CameraSpec(model=model, width=480, height=320, focal=24), 3)
    pose = looking_ahead((0.2, 0.0, 1.4), 0.1)
    light = render(lit(scene, OVERCAST), camera, pose, samples=16)[..., 1]
    middle = (low + high) / 2
    for axis, end in ((0, low), (0, high), (1, low), (1, high)):
        place = middle.copy()
        place[axis] = end[axis]
        pixel = camera.project(pose.inverse.apply(np.array([[place[0], 8.0, place[1]]])))[0]
        column, row = np.floor(pixel).astype(int)
        profile = light[row, column - 2 : column + 3] if axis == 0 else light[row - 2 : row + 3, column]
        bright, dark = profile.max(), profile.min()
        share = float(((profile - dark) / (bright - dark)).sum())  # px of wall in the profile
        start = (column if axis == 0 else row) - 2
        edge = start + (share if profile[0] > profile[-1] else len(profile) - share)
        assert abs(edge - pixel[axis]) < 0.1


def test_a_shadow_falls_along_the_direction_of_the_sun():
    awning = Sheet((-2.0, 7.0, 4.0), (4.0, 0, 0), (0, 1.0, 0))
    scene = painted(scene_of(wall(8.0), awning), 0.6, 0.6)
    lit_scene = lit(scene, LightSpec(overcast=0.0, sun_elevation=50.0, sun_azimuth=165.0))
    camera = Camera("PINHOLE", 400, 400, np.array([300.0, 300.0, 200.0, 200.0]))
    pose = looking_ahead((0.0, -1.0, 2.0))
    light = render(lit_scene, camera, pose, samples=1)[..., 1]
    x, z = np.meshgrid(np.linspace(-3, 3, 61), np.linspace(0.6, 3.7, 45))
    points = np.column_stack([x.ravel(), np.full(x.size, 8.0), z.ravel()])
    # from the point towards the sun: where the ray crosses the awning's height
    cross = points + (4.0 - points[:, 2:]) / lit_scene.light.to_sun[2] * lit_scene.light.to_sun
    clear = np.minimum(np.abs(np.abs(cross[:, 0]) - 2.0), np.abs(cross[:, 1] - 7.0)) > 0.05
    shaded = (np.abs(cross[:, 0]) < 2.0) & (cross[:, 1] > 7.0)
    column, row = np.floor(camera.project(pose.inverse.apply(points))).astype(int).T
    seen = light[row, column]
    assert 0.1 < shaded.mean() < 0.6
    assert seen[shaded & clear].max() < 0.6 * seen[~shaded & clear].min()


def test_a_pane_mirrors_as_much_as_fresnel_predicts():
    """With a white wall behind the photographer and black ones elsewhere, only mirrored white is added."""
    pane = Sheet((-20, 0.0, 0.0), (60, 0, 0), (0, 0, 4), Part.PANE)
    sheets = (pane, wall(1.0, x=(-60, 60)), Sheet((80, -12, -5), (-120, 0, 0), (0, 0, 30)))
    camera = Camera("PINHOLE", 40, 40, np.array([400.0, 400.0, 20.0, 20.0]))
    reflected = []
    for degrees in (10.0, 70.0):
        pose = looking_ahead((0.0, -3.0, 2.0), np.radians(degrees))
        light = [
            render(lit(painted(scene_of(*sheets), 0.02, 0.004, tone), OVERCAST), camera, pose, 1).mean()
            for tone in (0.2, 0.8)
        ]
        c, n = np.cos(np.radians(degrees)), 1.52
        t = np.sqrt(1 - (1 - c * c) / n**2)
        r = 0.5 * (((c - n * t) / (c + n * t)) ** 2 + ((t - n * c) / (t + n * c)) ** 2)
        reflected.append((light[1] - light[0]) / (4 * r / (1 + 3 * r)))
    assert reflected[1] == pytest.approx(reflected[0], rel=0.03)
    assert reflected[0] > 0.05


def test_a_pane_shows_the_room_behind_it():
    pane = Sheet((-20, 0.0, 0.0), (60, 0, 0), (0, 0, 4), Part.PANE)
    room = Sheet((-30, 2.0, -5), (60, 0, 0), (0, 0, 25), Part.ROOM)
    camera = Camera("PINHOLE", 40, 40, np.array([400.0, 400.0, 20.0, 20.0]))
    dark, bright = (
        render(
            lit(painted(scene_of(pane, room), 0.02, t), OVERCAST), camera, looking_ahead((0, -3, 2)), 1
        ).mean()
        for t in (0.05, 0.8)
    )
    assert bright > 2 * dark


def test_samples_in_a_pixel_share_no_row_and_no_column():
    for n in (1, 2, 5, 16):
        at = lattice(n)
        assert at.shape == (n, 2) and np.abs(at).max() < 0.5
        for axis in (0, 1):
            assert np.allclose(np.sort(at[:, axis]), (np.arange(n) + 0.5) / n - 0.5)


def small_view(scene: Scene) -> tuple[LitScene, Camera, Rigid3]:
    spec = CameraSpec(width=240, height=180, most=1)
    return lit(scene, SUNNY), make_camera(spec, 1), plan_photos(scene, spec, 1)[0].true


def test_bands_leave_no_seams(houses, monkeypatch):
    view = small_view(houses)
    whole = render(*view, samples=5)
    monkeypatch.setattr("frontage.simulate.sensors.render._BAND", 7 * 240)
    monkeypatch.setattr("frontage.simulate.sensors.render._SPLIT", 1000)
    assert np.allclose(render(*view, samples=5), whole, atol=1e-5)


def test_following_a_neighbour_gives_what_casting_gives(houses):
    lit_scene, camera, pose = small_view(houses)
    y, x = np.mgrid[0:180, 0:240] + 0.5
    ways = pose.rotate(camera.ray(np.column_stack([x.ravel(), y.ravel()])))
    view = lit_scene.cast(pose.t, ways)
    left = np.arange(1, len(ways))
    left = left[(left % 240 > 0) & (view.key[left] == view.key[left - 1])]
    same = lit_scene.follow(view, left - 1, pose.t, ways[left])
    assert len(left) > 0.6 * len(ways) and len(same.paned) > 500
    assert np.abs(same.xyz - view.xyz[left]).max() < 0.005  # faces are flat to 4 mm
    cast = np.flatnonzero(np.isin(view.paned, left))
    assert (left[same.paned] == view.paned[cast]).all()
    assert np.abs(same.cosine - view.cosine[cast]).max() < 1e-6
    assert (same.lit == view.lit[left]).all()


def test_more_samples_change_edges_only_a_little():
    scene = painted(scene_of(wall(8.0), Sheet((-1, 7.5, 1), (1.9, 0, 0.1), (-0.1, 0, 1.6))), 0.8, 0.05)
    camera = Camera("PINHOLE", 120, 90, np.array([100.0, 100.0, 60.0, 45.0]))
    one, few, many = (
        render(lit(scene, OVERCAST), camera, looking_ahead((0, 0, 1.6)), n)[..., 1] for n in (1, 5, 36)
    )
    contrast = many.max() - many.min()
    rms = [np.sqrt(np.mean((x - many)[np.abs(one - many) > 0.02 * contrast] ** 2)) for x in (one, few)]
    assert rms[1] < 0.1 * contrast
    assert rms[1] < 0.4 * rms[0]


def test_noise_is_shot_noise_and_read_noise():
    light = np.full((300, 400, 3), 0.5, np.float32)
    light[:150] *= 0.1
    spec = CameraSpec(
        psf=0, vignetting=0, exposure_jitter=0, white_balance_jitter=0, read_noise=20, full_well=2000
    )
    image = develop(light, spec, np.random.default_rng(0))
    code = np.arange(256) / 255
    code = code - 0.03 * np.sin(2 * np.pi * (code - 0.5))  # the contrast curve is undone to first order
    linear = np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)
    for half in (linear[image[:150]], linear[image[150:]]):
        expected = np.sqrt(half.mean() / 2000 + (20 / 2000) ** 2)
        assert half.std() == pytest.approx(expected, rel=0.1)


def test_corners_are_darker_by_the_vignetting():
    light = np.full((300, 400, 3), 0.5, np.float32)
    flat = {"psf": 0, "exposure_jitter": 0, "white_balance_jitter": 0, "read_noise": 0, "full_well": 1e9}
    image = develop(light, CameraSpec(vignetting=0.5, **flat), np.random.default_rng(0)).astype(float)
    even = develop(light, CameraSpec(vignetting=0.0, **flat), np.random.default_rng(0)).astype(float)
    assert np.ptp(even) == 0
    assert image[148:152, 198:202].mean() == pytest.approx(even.mean(), rel=0.01)
    assert ((image[:4, :4].mean() / 255) ** 2.2) == pytest.approx(0.5 * (even.mean() / 255) ** 2.2, rel=0.15)


@pytest.fixture(scope="module")
def houses() -> Scene:
    return build_street(SceneSpec(seed=7, houses=2))


def test_neighbouring_photos_have_many_true_sift_matches():
    houses = build_street(SceneSpec(seed=2, houses=2))
    places = tuple(Standpoint(along=s, across=-9.0, pitch=14.0) for s in (6.0, 7.6))
    spec = CameraSpec(width=800, height=600, layout="places", places=places)
    a, b = take_photographs(houses, spec, seed=1)
    sift = cv2.SIFT_create(contrastThreshold=0.02)  # as COLMAP's default peak threshold
    (ka, da), (kb, db) = (
        sift.detectAndCompute(cv2.cvtColor(s.image, cv2.COLOR_RGB2GRAY), None) for s in (a, b)
    )
    pairs = cv2.BFMatcher().knnMatch(da, db, k=2)
    good = [m for m, n in pairs if m.distance < 0.8 * n.distance]
    pa = np.array([ka[m.queryIdx].pt for m in good]) + 0.5
    pb = np.array([kb[m.trainIdx].pt for m in good]) + 0.5
    (ca, ra), (cb, rb) = a.photo.ray(pa), b.photo.ray(pb)
    base = np.cross(cb - ca, ra)
    base /= np.linalg.norm(base, axis=1, keepdims=True)
    off = np.abs(np.einsum("ij,ij->i", base, rb)) * a.photo.camera.params[0]  # px from the epipolar plane
    assert (off < 1.5).sum() >= 500
    assert (off < 1.5).mean() > 0.7  # rows of equal windows are mistaken for each other, as in real streets


def test_exposure_and_colour_change_and_the_same_seed_gives_the_same_bytes(houses):
    place = Standpoint(along=5.0, across=-8.0, pitch=10.0)
    spec = CameraSpec(width=160, height=120, layout="places", places=(place, place))
    first, second = take_photographs(houses, spec, seed=4)
    again = take_photographs(houses, spec, seed=4)
    assert [s.image.tobytes() for s in again] == [first.image.tobytes(), second.image.tobytes()]
    other = take_photographs(houses, spec, seed=5)[0]
    assert (other.image != first.image).mean() > 0.5
    means = np.array([s.image.reshape(-1, 3).mean(0) for s in (first, second)])
    assert np.abs(means[0] - means[1]).max() > 1.0
    assert np.abs(np.diff(means[:, 0] / means[:, 2])) > 0.005


@pytest.mark.parametrize(("seed", "side"), [(7, 0), (101, 0), (101, 1)])
def test_a_walk_stands_in_the_street_and_sees_the_facades(seed, side):
    scene = build_street(SceneSpec(seed=seed))
    aims = plan_photos(scene, CameraSpec(most=9, side=side, pitches=(5.0, 20.0)), 2)
    assert len(aims) == 9
    assert len({a.name for a in aims}) == 9
    tracer = Tracer(scene.mesh)
    street_from_local = scene.local_from_street.inverse
    where = street_from_local.apply(np.array([a.true.t for a in aims]))
    assert np.ptp(where[:, 1]) < 1.0
    assert np.ptp(where[:, 0]) > 20.0
    for aim in aims:
        forward = street_from_local.rotate(aim.true.R[:, 2][None])[0]
        assert forward[1] * (1 - 2 * side) > 0.85
        around = aim.true.R @ np.array([[0, 0, 1.0], [0.5, 0, 0.8], [-0.5, 0, 0.8], [0, -0.3, 0.9]]).T
        distance = tracer.first_hit(aim.true.t, around.T).distance
        assert distance.min() > 0.5
        assert np.median(np.minimum(distance, 30)) > 4.0


def test_a_side_without_houses_is_refused():
    with pytest.raises(OptionError, match="no house on side 1"):
        plan_photos(build_street(SceneSpec(seed=1, houses=1, opposite=False)), CameraSpec(side=1), 0)


def test_errors_of_given_poses_match_their_sigmas():
    scene = scene_of(ground(), wall(8.0))
    places = tuple(Standpoint(along=0.1 * k, across=0.0) for k in range(60))
    spec = CameraSpec(layout="places", places=places, sigma_position=2.0, sigma_heading=4.0, sigma_level=0.7)
    shift, turn, tilt = [], [], []
    for seed in range(25):
        for aim in plan_photos(scene, spec, seed):
            shift.append(aim.given.t - aim.true.t)
            delta = aim.given.R @ aim.true.R.T
            turn.append(np.degrees(np.arctan2(delta[1, 0], delta[0, 0])))
            tilt.append(np.degrees(np.arcsin(np.clip(aim.given.R[2, 2], -1, 1))))
    assert np.sqrt(np.mean(np.square(shift))) == pytest.approx(2.0, rel=0.25)
    assert np.sqrt(np.mean(np.square(turn))) == pytest.approx(4.0, rel=0.25)
    assert np.sqrt(np.mean(np.square(tilt))) == pytest.approx(0.7, rel=0.15)
    exact = plan_photos(
        scene, spec.model_copy(update={"sigma_position": 0, "sigma_heading": 0, "sigma_level": 0}), 0
    )
    assert all(np.allclose(a.given.matrix, a.true.matrix, atol=1e-12) for a in exact)


def test_the_camera_stands_above_the_ground():
    slope = Sheet((-60, -60, -6), (120, 0, 12), (0, 120, 0), Part.GROUND)
    scene = scene_of(slope, wall(8.0))
    spec = CameraSpec(layout="places", places=(Standpoint(along=10.0, across=2.0, height=1.5),))
    (aim,) = plan_photos(scene, spec, 0)
    assert aim.true.t == pytest.approx([10.0, 2.0, 2.5], abs=1e-6)


def test_scan_colours_show_sun_and_shadow():
    awning = Sheet((-2.0, 7.0, 4.0), (4.0, 0, 0), (0, 1.0, 0))
    scene = painted(scene_of(wall(8.0), awning), 0.5, 0.5)
    points = np.array([[0.0, 8.0, 3.8], [0.0, 8.0, 1.0], [5.0, 8.0, 1.0], [0.0, 3.0, 1.0]])
    surface = np.array([0, 0, 0, -1])
    rgb = scan_colours(scene, surface, points, np.array([0.0, 0.0, 1.5]), SUNNY).astype(float).mean(1)
    assert rgb[0] < 0.8 * rgb[1]
    assert rgb[1] == pytest.approx(rgb[2], rel=0.15)
    even = scan_colours(scene, surface, points, light=SUNNY).astype(float).mean(1)
    assert even[0] == pytest.approx(even[1], rel=0.1)
    assert even[3] == rgb[3]
