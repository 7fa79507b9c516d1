"""The ortho-image: right place, right photo, nothing smeared, nothing invented."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from pydantic import ValidationError

import ortho_wall as wall
from frontage.errors import OptionError
from frontage.geometry.rigid import Rigid3
from frontage.model import NOT_SEEN, Failed, Photo, Scan
from frontage.ortho import OrthoOptions, make_ortho

PLANE = OrthoOptions(margin=0.0)


@pytest.fixture(scope="module")
def scene():
    facade = wall.facade(8.0, 6.0)
    return facade, wall.texture(8.0, 6.0), wall.wall_cloud(facade)


def seen(ortho):
    """The pixels (h, w) that have a source."""
    return ~np.isin(ortho.source, (0, NOT_SEEN))


def images(facade, picture, photos, depth=None):
    made = {p.id: wall.render(p, facade, picture, depth) for p in photos}
    return made.__getitem__


def test_true_poses_with_distortion_give_a_third_of_a_pixel(scene):
    facade, picture, cloud = scene
    photo = wall.photo(facade, wall.camera(1200, 900), (-3.0, -8.0, -1.5))
    ortho = make_ortho(facade, cloud, [photo], images(facade, picture, [photo]), options=PLANE)
    assert ortho.size == (800, 600)
    shifts = np.linalg.norm(wall.displacement(ortho.pixels, picture), axis=1)
    assert 0.0 < np.median(shifts) <= 0.3
    assert np.abs(ortho.pixels[..., :3].astype(int) - picture).mean() < 12, "mirrored or upside down"


def test_the_papers_homography_is_off_by_the_distortion(scene):
    facade, picture, cloud = scene
    photo = wall.photo(facade, wall.camera(1200, 900), (-3.0, -8.0, -1.5))
    options = OrthoOptions(margin=0.0, projection="homography", interpolation="bilinear")
    ortho = make_ortho(facade, cloud, [photo], images(facade, picture, [photo]), options=options)
    shifts = np.linalg.norm(wall.displacement(ortho.pixels, picture), axis=1)
    assert np.median(shifts) > 1.0
    assert np.isnan(ortho.depth).all()


def test_the_relief_removes_the_displacement_of_recesses(scene):
    facade, picture, _ = scene
    depth = lambda x, z: np.where((np.abs(x) < 2.0) & (np.abs(z) < 1.5), 0.3, 0.0)  # noqa: E731
    cloud = wall.wall_cloud(facade, depth=depth)
    photo = wall.photo(facade, wall.camera(1200, 900), (-5.0, -7.0, 0.0))
    image_of = images(facade, picture, [photo], depth)
    inside = (slice(200, 400), slice(300, 550))
    errors = {}
    for relief in (True, False):
        ortho = make_ortho(facade, cloud, [photo], image_of, options=OrthoOptions(margin=0.0, relief=relief))
        shift = wall.displacement(ortho.pixels[inside], picture[inside], 64)
        errors[relief] = np.median(np.linalg.norm(shift, axis=1))
    assert errors[True] < 0.5
    assert errors[False] > 10.0


def test_a_window_edge_of_the_relief_is_straight(scene):
    facade, _, _ = scene
    depth = lambda x, z: np.where((np.abs(x) < 0.6) & (np.abs(z) < 0.9), 0.15, 0.0)  # noqa: E731
    cloud = wall.wall_cloud(facade, spacing=0.02, depth=depth, noise=0.004)
    ortho = make_ortho(facade, cloud, options=PLANE)
    deep = ortho.depth > 0.075
    left = np.argmax(deep[230:370], axis=1)  # first recessed pixel of each row
    assert np.abs(left - 340).max() <= 3, "the reveal at x = -0.6 m is column 340"
    assert left.std() < 1.5, "within half a cell of 3 cm"
    assert np.nanmedian(ortho.depth[250:350, 360:440]) == pytest.approx(0.15, abs=0.003)


@pytest.mark.parametrize("reveal", [0.08, 0.15, 0.3])
@pytest.mark.parametrize("eye", [(0.5, -12.0, -2.5), (6.0, -8.0, -3.0)])
def test_window_edges_of_the_relief_are_unbiased(reveal, eye):
    """A scan every 3 cm that looks into the recess obliquely: one side of it is in shadow."""
    facade = wall.facade(5.0, 4.0, spacing=0.03)
    cloud = wall.scanned_window(facade, (-0.43, -0.62, 0.57, 0.78), reveal, eye, spacing=0.03)
    ortho = make_ortho(facade, cloud, options=PLANE)
    deep = ortho.depth > 0.5 * reveal
    left, right = 250 + np.array([-43, 57])
    top, bottom = 200 - np.array([78, -62])
    rows, columns = slice(top + 12, bottom - 12), slice(left + 12, right - 12)
    middle_row, middle = (top + bottom) // 2, (left + right) // 2
    found = [
        middle - np.argmin(deep[rows, middle::-1], axis=1) + 1 - left,
        middle + np.argmin(deep[rows, middle:], axis=1) - right,
        middle_row - np.argmin(deep[middle_row::-1, columns], axis=0) + 1 - top,
        middle_row + np.argmin(deep[middle_row:, columns], axis=0) - bottom,
    ]
    medians = np.array([np.median(e) for e in found])
    assert np.abs(medians).max() <= 1.5, "half a spacing, whatever the depth and the side"
    assert max(e.std() for e in found) < 1.0
    assert np.nanmedian(ortho.depth[rows, columns]) == pytest.approx(reveal, abs=0.003)


def test_glass_without_returns_lies_at_its_frame(scene):
    facade, picture, _ = scene
    pane = lambda x, z: (np.abs(x) < 0.5) & (np.abs(z) < 0.7)  # noqa: E731
    depth = lambda x, z: np.where((np.abs(x) < 0.6) & (np.abs(z) < 0.8), 0.2, 0.0)  # noqa: E731
    cloud = wall.wall_cloud(facade, depth=depth)
    seen = ~pane(*facade.frame.inverse.apply(cloud.xyz)[:, [0, 2]].T)
    photo = wall.photo(facade, wall.camera(1200, 900), (-5.0, -7.0, 0.0))
    image_of = images(facade, picture, [photo], depth)
    ortho = make_ortho(facade, cloud.take(np.flatnonzero(seen)), [photo], image_of, options=PLANE)
    inside = (slice(235, 365), slice(352, 448))
    shift = wall.displacement(ortho.pixels[inside], picture[inside], 48)
    assert np.median(np.linalg.norm(shift, axis=1)) < 1.0, "a plane through the wall would be off by 14 px"
    assert np.isnan(ortho.depth[290:310, 390:410]).all(), "it was not measured, and says so"


def test_pixel_and_world_round_trip_on_relief_and_plane(scene):
    facade, _, _ = scene
    depth = lambda x, z: np.where(np.abs(x) < 1.0, 0.25, 0.0)  # noqa: E731
    cloud = wall.wall_cloud(facade, depth=depth, holes=[(-1.0, 1.0, 1.0, 2.5)])
    ortho = make_ortho(facade, cloud, options=PLANE)
    pixels = np.random.default_rng(0).uniform([0, 0], [800, 600], (2000, 2))
    for relief in (True, False):
        world, used = ortho.pixel_to_world(pixels, relief)
        back, y = ortho.world_to_pixel(world)
        assert np.abs(back - pixels).max() < 1e-6
        assert np.allclose(y[~used], 0.0, atol=1e-6)
        assert used.any() == relief
    _, used = ortho.pixel_to_world(np.array([[400.0, 125.0], [400.0, 400.0]]))
    assert used.tolist() == [False, True], "the hole has no relief, the recess has"
    corner, _ = ortho.pixel_to_world(np.array([[0.0, 0.0]]), relief=False)
    expected = facade.world.to_world(facade.frame.apply(np.array([[-4.0, 0.0, 3.0]])))
    assert np.abs(corner - expected).max() < 1e-6


@pytest.mark.parametrize("relief", [True, False])
@pytest.mark.parametrize("shift", [0.0, 0.012, -0.02])
def test_the_picture_follows_the_photos_where_they_disagree_with_the_scan(scene, shift, relief):
    facade, picture, _ = scene
    depth = lambda x, z: np.where((np.abs(x) < 1.0) & (np.abs(z) < 1.0), 0.15, 0.0)  # noqa: E731
    camera = wall.camera(1200, 900)
    eyes = {"a": (-4.0, -7.0, -2.0), "b": (0.0, -8.0, -2.0), "c": (4.0, -7.0, -2.0)}
    photos = [wall.photo(facade, camera, eye, name=name) for name, eye in eyes.items()]
    image_of = images(facade, picture, photos, depth)
    # a scan whose whole cloud, and so its plane, stands off by `shift`
    pose = facade.local_from_facade.value
    moved = Rigid3("local", "facade", pose.R, pose.t - shift * pose.R[:, 1])
    scanned = replace(facade, local_from_facade=replace(facade.local_from_facade, value=moved))
    cloud = wall.wall_cloud(scanned, depth=depth)
    options = OrthoOptions(margin=0.0, relief=relief)
    ortho = make_ortho(scanned, cloud, photos, image_of, options=options)
    found = ortho.photo_offset
    assert found.patches >= 8 and 0.0 < found.sigma < 0.001
    assert abs(found.value - shift) < 4 * found.sigma
    assert found.applied == (shift != 0.0)
    wall_only = (slice(420, 600), slice(0, 800))
    off = np.linalg.norm(wall.displacement(ortho.pixels[wall_only], picture[wall_only], 64), axis=1)
    assert np.median(off) < 0.25
    if relief:
        assert np.nanmedian(ortho.depth) == pytest.approx(0.0, abs=0.002), "depth.tif is the scan's"


def test_one_photo_or_no_texture_gives_no_offset(scene):
    facade, _, cloud = scene
    camera = wall.camera(800, 600, distorted=False)
    photos = [wall.photo(facade, camera, (x, -8.0, 0.0), name=str(x)) for x in (-2.0, 2.0)]
    grey = np.full((600, 800, 3), 120, np.uint8)
    for some in (photos[:1], photos):
        ortho = make_ortho(facade, cloud, some, lambda _: grey, options=PLANE)
        assert ortho.photo_offset is None


def with_board(facade, cloud: Scan, x: tuple[float, float], y: float) -> Scan:
    """The cloud and a board in front of the wall."""
    g = np.stack(np.meshgrid(np.arange(*x, 0.02), [y], np.arange(-3.0, 3.0, 0.02)), axis=-1).reshape(-1, 3)
    return Scan("board", np.vstack([cloud.xyz, facade.frame.apply(g)]), cloud.world)


def test_parts_hidden_in_one_photo_come_from_the_next_best(scene):
    facade, _, wall_only = scene
    cloud = with_board(facade, wall_only, (-0.3, 0.3), -3.0)
    camera = wall.camera(800, 600, distorted=False)
    photos = [
        wall.photo(facade, camera, (0.0, -8.0, 0.0), name="front"),
        wall.photo(facade, camera, (5, -9.0, 0), name="right"),
    ]
    flat = {"front": np.full((600, 800, 3), 60, np.uint8), "right": np.full((600, 800, 3), 180, np.uint8)}
    alone = make_ortho(facade, cloud, photos[:1], flat.__getitem__, options=PLANE)
    as_shot = PLANE.model_copy(update={"radiometry": "as shot"})
    both = make_ortho(facade, cloud, photos, flat.__getitem__, options=as_shot)
    behind = (slice(250, 350), slice(390, 410))
    assert (alone.pixels[behind][..., 3] == 0).all(), "hidden and seen by no other photo: nodata"
    assert (alone.source[behind] == NOT_SEEN).all()
    names = np.array(["", *both.sources])[both.source[behind]]
    assert (names == "right").all()
    assert (both.pixels[behind][..., 0] == 180).all()


@pytest.mark.parametrize(("echoes", "hides"), [(4, False), (40, True)])
def test_stray_echoes_before_a_facade_hide_nothing(scene, echoes, hides):
    """A few points in a cube of air are no part of the facade; forty of them are a small board."""
    facade, _, wall_only = scene
    rng = np.random.default_rng(1)
    place = rng.uniform([0.05, -0.92, 0.05], [0.21, -0.90, 0.21], (echoes, 3))
    xyz = np.concatenate([wall_only.xyz, facade.frame.apply(place)])
    cloud = Scan("wall", xyz, wall_only.world)
    photo = wall.photo(facade, wall.camera(800, 600, distorted=False), (0.0, -8.0, 0.0))
    ortho = make_ortho(facade, cloud, [photo], lambda _: np.full((600, 800, 3), 60, np.uint8), options=PLANE)
    assert (~seen(ortho)[250:350, 350:450]).any() == hides


def test_the_picture_consists_of_few_patches(scene):
    facade, _, cloud = scene
    camera = wall.camera(800, 600, distorted=False)
    photos = [wall.photo(facade, camera, (x, -8.0, 0.0), (x, 0, 0), name=str(x)) for x in (-3.0, 0.0, 3.0)]
    ortho = make_ortho(facade, cloud, photos, lambda _: np.full((600, 800, 3), 9, np.uint8), options=PLANE)
    for source in range(1, len(ortho.sources) + 1):
        assert cv2.connectedComponents((ortho.source == source).astype(np.uint8))[0] - 1 <= 1


def test_nothing_is_smeared_outside_the_photo(scene):
    facade, _, cloud = scene
    photo = wall.photo(
        facade, wall.camera(600, 450, distorted=False, focal=1.5), (-2.5, -5.0, 1.0), (-2.5, 0, 1.0)
    )
    ortho = make_ortho(facade, cloud, [photo], lambda _: np.full((450, 600, 3), 99, np.uint8), options=PLANE)
    at = photo.project(
        ortho.local_from_pixel(np.array([[c, r] for c in range(1, 800, 7) for r in range(1, 600, 7)]))[0]
    )
    inside = ((at > 0) & (at < [600, 450])).all(1)
    shown = ortho.source[1::7, 1::7].T.ravel() == 1
    assert not (shown & ~inside).any()
    assert (shown & inside).sum() > 0.9 * inside.sum()


def test_the_scan_fills_large_parts_that_no_photo_shows(scene):
    facade, _, cloud = scene
    part = wall.photo(
        facade, wall.camera(600, 450, distorted=False, focal=1.5), (-2.5, -5.0, 0), (-2.5, 0, 0)
    )
    whole = wall.photo(
        facade, wall.camera(800, 600, distorted=False, focal=0.55), (-2.8, -7.0, 0), (-2.8, 0, 0)
    )
    for photo, filled in ((part, True), (whole, False)):
        ortho = make_ortho(
            facade, cloud, [photo], lambda _: np.full((600, 800, 3), 99, np.uint8), options=PLANE
        )
        assert (ortho.sources == (photo.id, "wall (colour)")) == filled
        assert (seen(ortho).mean() > 0.98) == filled
        assert 0.1 < (ortho.source == 1).mean() < 0.98
        assert (ortho.pixels[..., 3] > 0).tolist() == seen(ortho).tolist()
        if filled:
            assert ortho.pixels[300, 700, :3].tolist() == [40, 80, 200], "the scan's own colour"


@pytest.mark.parametrize("photos", [False, True])
def test_nothing_is_painted_outside_the_outline(scene, photos):
    full, _, cloud = scene
    gable = np.array([[-4.0, -3.0], [4.0, -3.0], [4.0, 1.0], [0.0, 3.0], [-4.0, 1.0]])
    facade = replace(full, outline=gable)
    photo = wall.photo(facade, wall.camera(800, 600, distorted=False, focal=0.5), (0.0, -8.0, 0.0))
    ortho = make_ortho(
        facade,
        cloud,
        [photo] if photos else [],
        lambda _: np.full((600, 800, 3), 99, np.uint8),
        options=OrthoOptions(margin=0.1),
    )
    alpha = ortho.pixels[..., 3] > 0
    corner, near_the_roof, inside = alpha[15:60, 15:250], alpha[110, 365:455], alpha[330:600, 15:-15]
    assert not corner.any() and not (ortho.source[15:60, 15:250] > 0).any()
    assert near_the_roof.any() and inside.mean() > 0.99
    assert np.isnan(ortho.depth[15:60, 15:250]).all()


@pytest.mark.parametrize("above", [230, 60])
def test_no_sky_shows_between_a_verge_and_a_straight_outline(scene, above):
    """The wall sags by 12 cm below the outline; what is darker than the sky there is a cornice."""
    full, _, cloud = scene
    xyz = full.frame.inverse.apply(cloud.xyz)
    top = 2.0 - 0.12 * np.sin(np.pi * (xyz[:, 0] + 4.0) / 8.0)
    ring = np.array([[-4.0, -3.0], [4.0, -3.0], [4.0, 2.0], [-4.0, 2.0]])
    facade = replace(full, outline=ring)
    picture = wall.texture(8.0, 6.0) // 3 + 60
    end = 12.0 * np.sin(np.pi * (np.arange(800) + 0.5) / 800.0)  # px below the outline
    picture[np.arange(600)[:, None] < 100 + end] = above
    photo = wall.photo(facade, wall.camera(1200, 900, distorted=False, focal=0.6), (0.0, -7.0, 0.0))
    shot = wall.render(photo, facade, picture)
    ortho = make_ortho(
        facade,
        cloud.take(np.flatnonzero(xyz[:, 2] < top)),
        [photo],
        lambda _: shot,
        options=OrthoOptions(margin=0.0),
    )
    alpha = ortho.pixels[:, 10:-10, 3] > 0
    first = np.argmax(alpha, axis=0)
    assert np.abs(first - (end[10:-10] if above > 200 else 0)).max() <= 6.0
    assert alpha[20:].mean() > 0.999


@pytest.mark.parametrize("sky", [True, False])
def test_the_sky_between_two_gables_is_empty_and_a_gap_of_the_scan_is_not(scene, sky):
    """The outline bridges 4 m between two gables, and no point lies in the upper metre there."""
    full, _, cloud = scene
    xyz = full.frame.inverse.apply(cloud.xyz)
    between = (np.abs(xyz[:, 0]) < 2.0) & (xyz[:, 2] > 1.0)
    facade = replace(full, outline=np.array([[-4.0, -3.0], [4.0, -3.0], [4.0, 2.0], [-4.0, 2.0]]))
    picture = wall.texture(8.0, 6.0) // 2 + 100
    if sky:
        picture[:200, 200:600] = np.clip([[[150, 190, 235]]] + np.arange(200)[:, None, None] // 10, 0, 255)
    photo = wall.photo(facade, wall.camera(1200, 900, distorted=False, focal=0.6), (0.0, -7.0, 0.0))
    shot = wall.render(photo, facade, picture)
    scan = cloud.take(np.flatnonzero(~between & (xyz[:, 2] < 2.0)))
    ortho = make_ortho(facade, scan, [photo], lambda _: shot, options=OrthoOptions(margin=0.0))
    alpha = ortho.pixels[..., 3] > 0
    top = round((ortho.corner[1] - 2.0) / 0.01)
    assert alpha[top + 10 : top + 85, 210:590].mean() == pytest.approx(0.0 if sky else 1.0, abs=0.02)
    assert alpha[top + 115 : -10, 10:-10].mean() > 0.999


@pytest.mark.parametrize("sparser", [2.0, 3.5, 5.0])
def test_a_scan_sparser_than_pixels_fills_the_wall_and_not_the_window(sparser):
    spacing = sparser * 0.01
    facade = wall.facade(6.0, 5.0, spacing=spacing)
    rng = np.random.default_rng(round(10 * sparser))
    x, z = rng.uniform([-3.0, -2.5], [3.0, 2.5], (round(30 / spacing**2), 2)).T
    wall_only = ~((np.abs(x) < 0.5) & (np.abs(z) < 0.5))
    xyz = np.column_stack([x, rng.normal(0, 0.003, len(x)), z])[wall_only]
    scan = Scan("s", facade.frame.apply(xyz), wall.WORLD, rgb=np.full((len(xyz), 3), 120, np.uint8))
    ortho = make_ortho(facade, scan, options=PLANE)
    alpha = ortho.pixels[..., 3] > 0
    window = np.zeros_like(alpha)
    window[200:300, 250:350] = True
    edge = cv2.dilate(window.astype(np.uint8), np.ones((3, 3)), iterations=round(sparser)) > 0
    border = round(3 * sparser)  # no point lies beyond the wall to close its outermost gaps
    inner = np.zeros_like(alpha)
    inner[border:-border, border:-border] = True
    assert alpha[inner & ~edge].mean() >= 0.995
    assert (~alpha[window]).mean() >= 0.95
    assert np.nanmedian(ortho.gsd_effective) == pytest.approx(spacing, rel=0.2)


def test_a_far_end_that_is_sparser_than_the_near_one_is_filled_too():
    rng = np.random.default_rng(4)
    facade = wall.facade(16.0, 4.0, spacing=0.015)
    x = rng.uniform(-8.0, 8.0, 400_000)
    share = 10 ** (-(x + 8.0) / 8.0)  # the density falls by 100, the spacing grows tenfold
    x = x[rng.random(len(x)) < share]
    z = rng.uniform(-2.0, 2.0, len(x))
    hole = (np.abs(np.abs(x) - 4.0) < 0.6) & (np.abs(z) < 0.8)
    xyz = np.column_stack([x, rng.normal(0, 0.003, len(x)), z])[~hole]
    scan = Scan("s", facade.frame.apply(xyz), wall.WORLD, intensity=np.full(len(xyz), 0.5, np.float32))
    alpha = make_ortho(facade, scan, options=PLANE).pixels[..., 3] > 0
    for c in (400, 1200):
        assert (~alpha[120:280, c - 60 : c + 60]).mean() > 0.9, "a window is not smeared over"
    wall_only = np.ones_like(alpha)
    wall_only[100:300, 320:480] = wall_only[100:300, 1120:1280] = False
    wall_only[:30] = wall_only[-30:] = wall_only[:, :10] = wall_only[:, -40:] = False
    assert alpha[wall_only].mean() > 0.99


def test_photos_behind_or_without_a_pose_are_not_used(scene):
    facade, _, cloud = scene
    behind = wall.photo(facade, wall.camera(), (0.0, 8.0, 0.0))
    ortho = make_ortho(
        facade, cloud, [behind, Photo("loose", wall.camera())], lambda _: np.zeros((9, 9, 3), np.uint8)
    )
    assert ortho.sources == ("wall (colour)",)


def test_the_scan_fills_what_no_photo_shows_and_windows_stay_empty(scene):
    facade, _, _ = scene
    hole = (-2.6, -0.5, -1.4, 1.0)
    cloud = wall.wall_cloud(facade, spacing=0.03, holes=[hole])
    sparse = wall.facade(8.0, 6.0, spacing=0.03)
    ortho = make_ortho(sparse, cloud, options=PLANE)
    alpha = ortho.pixels[..., 3] > 0
    window = np.zeros_like(alpha)
    window[200:350, 140:260] = True
    assert alpha[10:-10, 10:-10][
        ~cv2.dilate(window.astype(np.uint8), np.ones((9, 9))).astype(bool)[10:-10, 10:-10]
    ].all()
    assert not alpha[210:340, 150:250].any(), "smeared across the window"
    left, right = ortho.pixels[300, 60, :3], ortho.pixels[300, 700, :3]
    assert left.tolist() == [200, 60, 40] and right.tolist() == [40, 80, 200]
    assert ortho.intensity[100, 400] == pytest.approx(0.8) and ortho.intensity[500, 400] == pytest.approx(0.2)


def test_rooms_behind_glass_are_left_out(scene):
    facade, _, _ = scene
    hole = (-0.6, -0.9, 0.6, 0.9)
    shell = wall.wall_cloud(facade, holes=[hole])
    room = np.random.default_rng(5).uniform([-0.6, 0.5, -0.9], [0.6, 1.4, 0.9], (1500, 3))
    cloud = Scan("wall", np.vstack([shell.xyz, facade.frame.apply(room)]), shell.world,
                 rgb=np.vstack([shell.rgb, np.zeros((1500, 3), np.uint8)]))  # fmt: skip
    ortho = make_ortho(facade, cloud, options=PLANE)
    inside = (slice(220, 380), slice(350, 450))
    assert (ortho.pixels[inside][..., 3] > 0).mean() < 0.02
    assert np.isnan(ortho.depth[inside]).mean() > 0.98


@pytest.mark.parametrize("kind", ["colour", "intensity", "depth"])
def test_the_source_names_what_the_scan_showed(scene, kind):
    facade, _, full = scene
    cloud = Scan("s", full.xyz, full.world, rgb=full.rgb if kind == "colour" else None,
                 intensity=None if kind == "depth" else full.intensity)  # fmt: skip
    ortho = make_ortho(facade, cloud, options=PLANE)
    assert ortho.sources == (f"s ({kind})",)
    assert (ortho.source == 1).mean() > 0.98
    assert (ortho.intensity is None) == (kind == "depth")


def test_a_facade_without_points_and_photos_fails_with_a_reason(scene):
    facade, _, _ = scene
    far = Scan("far", np.full((10, 3), 500.0), wall.WORLD)
    failed = make_ortho(facade, far)
    assert isinstance(failed, Failed) and not failed
    assert "B01/F1" in failed.message


def test_the_same_input_gives_the_same_bytes(scene):
    facade, picture, cloud = scene
    photo = wall.photo(facade, wall.camera(800, 600), (1.0, -8.0, 0.0))
    image_of = images(facade, picture, [photo])
    first, second = (make_ortho(facade, cloud, [photo], image_of) for _ in range(2))
    assert first.pixels.tobytes() == second.pixels.tobytes()
    assert first.depth.tobytes() == second.depth.tobytes()


def test_options_out_of_range_are_refused(scene):
    facade, _, cloud = scene
    with pytest.raises(ValidationError, match="greater than 0"):
        OrthoOptions(gsd=-0.01)
    with pytest.raises(OptionError, match="larger gsd"):
        make_ortho(facade, cloud, options=OrthoOptions(gsd=1e-6))


def owner(array: object) -> object:
    """What owns an array's memory in the end."""
    while isinstance(array, np.ndarray) and array.base is not None:
        array = array.base
    return array


def test_images_may_be_wider_than_opencv_allows_and_larger_than_memory(monkeypatch, tmp_path):
    from frontage.io.rasters.ortho import read_ortho, write_ortho
    from frontage.raster import tiles

    monkeypatch.setattr(tiles, "IN_MEMORY", 1 << 20)
    facade = wall.facade(340.0, 0.4, spacing=0.05)
    cloud = wall.wall_cloud(facade, spacing=0.05)
    photo = wall.photo(facade, wall.camera(600, 450, distorted=False), (165.0, -6.0, 0.0), (165.0, 0.0, 0.0))
    for photos in ([], [photo]):
        ortho = make_ortho(
            facade, cloud, photos, lambda _: np.full((450, 600, 3), 77, np.uint8), options=PLANE
        )
        assert ortho.size == (34000, 40)
        assert "mmap" in str(type(owner(ortho.pixels))), "the band was copied into memory"
        known = ortho.source == 1
        assert known[8:32, 33600:33900].mean() > 0.95
        assert (known[8:32].mean() > 0.95) == (not photos)
        assert seen(ortho)[8:32].mean() > 0.95, "the scan shows what the photo does not"
        write_ortho(tmp_path, ortho)
        assert np.array_equal(read_ortho(tmp_path).pixels, ortho.pixels)
