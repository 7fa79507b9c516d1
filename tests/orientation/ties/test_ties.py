"""Key points, pairs and blocks, on rendered photos whose truth is known."""

import sys

import cv2
import numpy as np
import pytest
from scipy.spatial import KDTree

from frontage.errors import MissingExtra
from frontage.geometry.rigid import Rigid3, rotation_angle
from frontage.model import Camera, Estimate, Photo
from frontage.orientation.nouns import Block, KeyPoints, PairMatches
from frontage.orientation.ties import (
    TieOptions,
    build_blocks,
    candidate_pairs,
    key_points,
    mapping,
    match_pair,
)
from frontage.orientation.ties.consistency import consistent
from frontage.orientation.ties.mapper import run_mapper
from frontage.orientation.ties.poses import contradicts, settles
from frontage.orientation.ties.repetition import strongest_shift
from frontage.orientation.ties.verify import doubts
from orientation.ties.pictures import Board, camera, noise, pose, relief, render, windows

pytest.importorskip("pycolmap")

FEW = TieOptions(most=2000)


def matched(points, cameras):
    pairs = []
    for i in range(len(points)):
        for j in range(i + 1, len(points)):
            pair = match_pair(points[i], points[j], cameras[i], cameras[j], first=i, second=j, options=FEW)
            if pair is not None:
                pairs.append(pair)
    return pairs


class Scene:
    """Photos of one scene with their key points and pairs."""

    def __init__(self, boards, views, cameras):
        self.views, self.cameras = views, cameras
        self.pictures = [
            render(boards, v, c, seed=k) for k, (v, c) in enumerate(zip(views, cameras, strict=True))
        ]
        self.photos = [Photo(f"{k}.jpg", c) for k, c in enumerate(cameras)]
        self.points = [key_points(p, FEW) for p in self.pictures]
        self.pairs = matched(self.points, cameras)

    def errors(self, block):
        """Largest error of the positions (share of their extent) and of the rotations (degrees)."""
        given = np.array([self.views[n].t for n in block.numbers])
        own = np.array([p.pose.t for p in block.photos])
        turn = sum(self.views[n].R @ p.pose.R.T for n, p in zip(block.numbers, block.photos, strict=True))
        u, _, vt = np.linalg.svd(turn)
        R = u @ vt
        a, b = (own - own.mean(0)) @ R.T, given - given.mean(0)
        scale = (a * b).sum() / (a * a).sum()
        angles = [
            rotation_angle(self.views[n].R.T @ R @ p.pose.R)
            for n, p in zip(block.numbers, block.photos, strict=True)
        ]
        return np.linalg.norm(scale * a - b, axis=1).max() / np.ptp(given, axis=0).max(), np.degrees(
            max(angles)
        )


@pytest.fixture(scope="module")
def street():
    """Four photos along a wall with relief; the last one is upright and has a camera of its own."""
    cameras = [camera()] * 3 + [camera(480, 640, 560.0)]
    views = [pose(-1.5, turn=4), pose(-0.5, y=0.2), pose(0.6, z=0.3, turn=-3), pose(1.5, y=-0.2, turn=-5)]
    return Scene(relief(), views, cameras)


@pytest.fixture(scope="module")
def built(street):
    return build_blocks(street.photos, street.points, street.pairs)


@pytest.mark.parametrize("size", [(640, 800), (1000, 1700)])
def test_pixels_count_from_the_corner_of_the_first_pixel(size):
    h, w = size
    rng = np.random.default_rng(3)
    centres = np.array([(cx, cy) for cx in range(60, w - 50, 90) for cy in range(60, h - 50, 90)], float)
    centres += rng.uniform(-0.5, 0.5, centres.shape)
    picture = np.full(size, 60.0)
    for cx, cy in centres:
        i, j = int(cx) - 30, int(cy) - 30
        x, y = np.meshgrid(np.arange(i, i + 61) + 0.5, np.arange(j, j + 61) + 0.5)
        picture[j : j + 61, i : i + 61] += 120 * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / (2 * 6.0**2))
    found = key_points(np.round(picture).astype(np.uint8), TieOptions(side=800))
    nearest = found.pixels[np.argmin(np.linalg.norm(found.pixels[None] - centres[:, None], axis=2), axis=1)]
    error = (nearest - centres)[np.linalg.norm(nearest - centres, axis=1) < 5]
    assert len(error) > 0.9 * len(centres)
    assert np.abs(error).max() < 0.1
    assert np.abs(error.mean(0)).max() < 0.03


def test_key_points_are_distinct_sorted_and_limited(street):
    points = key_points(street.pictures[0], TieOptions(most=600))
    assert len(points) == 600
    assert (np.diff(points.scale) <= 0).all()
    assert len(np.unique(np.round(points.pixels, 2), axis=0)) == 600
    assert points.descriptors.dtype == np.uint8
    quadrant = np.histogram2d(*points.pixels.T, bins=4)[0]
    assert quadrant.min() >= 5  # no corner of the picture is left out


def test_a_picture_without_any_detail_has_no_key_points():
    points = key_points(np.full((300, 400, 3), 128, np.uint8))
    assert len(points) == 0
    lens = camera(400, 300)
    assert match_pair(points, points, lens, lens) is None


def test_edges_of_blurred_and_of_moved_pictures_are_wide(street):
    sharp = street.pictures[0]
    step = np.where((np.add.outer(np.arange(600), np.arange(800)) // 60) % 2 == 0, 60, 200).astype(np.uint8)
    widths = [key_points(cv2.GaussianBlur(step, (0, 0), s)).sharpness for s in (0.7, 2.0, 4.0)]
    assert widths[0] < widths[1] < widths[2]
    assert 1.6 < widths[1] < 2.5 and 3.2 < widths[2] < 5.0
    moved = cv2.blur(sharp, (21, 1))
    assert key_points(moved).sharpness > 3 * max(key_points(sharp).sharpness, 0.5)


def test_a_pair_has_its_true_orientation(street):
    pair = next(p for p in street.pairs if (p.first, p.second) == (0, 2))
    a, b = street.views[0], street.views[2]
    true = b.inverse.after(a)
    assert np.degrees(rotation_angle(pair.rotation @ true.R.T)) < 0.1
    assert np.degrees(np.arccos(pair.direction @ true.t / np.linalg.norm(true.t))) < 1.0
    assert np.degrees(pair.angle) == pytest.approx(12, abs=2)
    assert len(pair.rows) > 300
    assert pair.rival < 0.3


def test_a_block_of_mixed_cameras_is_oriented(street, built):
    assert built.unoriented == ()
    (block,) = built.blocks
    assert [p.camera.width for p in block.photos] == [640, 640, 640, 480]
    position, angle = street.errors(block)
    assert position < 2e-3
    assert angle < 0.05
    residuals = [
        np.linalg.norm(
            p.project(block.points[block.point[block.photo == k]]) - block.pixels[block.photo == k]
        )
        / np.sqrt((block.photo == k).sum())
        for k, p in enumerate(block.photos)
    ]
    assert max(residuals) < 0.7
    assert np.bincount(block.point).min() >= 2


def test_two_runs_give_the_same_bytes_and_nothing_on_the_terminal(street, built, capfd):
    one, two = built.blocks[0], build_blocks(street.photos, street.points, street.pairs).blocks[0]
    pair = match_pair(street.points[0], street.points[1], street.cameras[0], street.cameras[1], options=FEW)
    assert pair.rows.tobytes() == street.pairs[0].rows.tobytes()
    assert pair.rotation.tobytes() == street.pairs[0].rotation.tobytes()
    assert capfd.readouterr() == ("", "")
    for name in ("points", "pixels", "photo", "point", "numbers"):
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes()
    for a, b in zip(one.photos, two.photos, strict=True):
        assert a.pose.matrix.tobytes() == b.pose.matrix.tobytes()


def test_a_start_that_leaves_nothing_is_followed_by_another(street, built, monkeypatch):
    """Two photos from far aside may have false matches only: what is built on them is confirmed by none."""
    asked = []

    def starts(*how):
        for models in run_mapper(*how):
            for model in models if not asked else ():
                for point in sorted(model.point3D_ids()):
                    model.delete_point3D(point)
            asked.append(len(models))
            yield models

    monkeypatch.setattr(mapping, "run_mapper", starts)
    result = build_blocks(street.photos, street.points, street.pairs)
    assert len(asked) == 2 and asked[0] > 0
    assert [b.numbers.tolist() for b in result.blocks] == [b.numbers.tolist() for b in built.blocks]
    assert result.unoriented == built.unoriented


def test_two_photos_make_a_block(street):
    pairs = [p for p in street.pairs if (p.first, p.second) == (0, 1)]
    result = build_blocks(street.photos[:2], street.points[:2], pairs)
    assert [len(b.photos) for b in result.blocks] == [2]
    block = result.blocks[0]
    assert len(block.points) > 150
    pose_b = block.photos[1].pose.inverse.after(block.photos[0].pose)
    true = street.views[1].inverse.after(street.views[0])
    assert np.degrees(rotation_angle(pose_b.R @ true.R.T)) < 0.15


@pytest.mark.parametrize("depth", ["flat", "relief"])
def test_two_photos_of_a_wall_are_oriented_and_two_from_one_place_are_not(depth):
    boards = [Board(noise(16, 9, 3), -8, -4.5, 10.0)] if depth == "flat" else relief()
    views = [pose(-1, turn=8), pose(1, y=0.3, turn=-8), pose(-1, turn=2)]
    scene = Scene(boards, views, [camera()] * 3)
    (block,) = build_blocks(scene.photos[:2], scene.points[:2], scene.pairs[:1]).blocks
    found = block.photos[1].pose.inverse.after(block.photos[0].pose)
    assert np.degrees(rotation_angle(found.R @ views[1].inverse.after(views[0]).R.T)) < 0.1
    still = match_pair(scene.points[0], scene.points[2], camera(), camera(), options=FEW)
    assert np.degrees(still.angle) < 0.05
    result = build_blocks([scene.photos[0], scene.photos[2]], [scene.points[0], scene.points[2]], [still])
    assert result.blocks == ()
    assert [why.split(" as ")[0] for _, why in result.unoriented] == ["it was taken from the same place"] * 2


def test_foreign_blurred_and_double_photos_are_named(street):
    lens = street.cameras[0]
    foreign = key_points(render([Board(noise(14, 9, 77), -7, -4.5, 10.0)], pose(0.0), lens), FEW)
    blurred = key_points(cv2.GaussianBlur(street.pictures[0], (0, 0), 14.0), FEW)
    copy = key_points(cv2.imdecode(cv2.imencode(".jpg", street.pictures[1])[1], cv2.IMREAD_COLOR), FEW)
    points = [*street.points[:3], foreign, blurred, copy]
    photos = [*street.photos[:3], *(Photo(n, lens) for n in ("cat.jpg", "blurred.jpg", "copy.jpg"))]
    result = build_blocks(photos, points, matched(points, [lens] * 6))
    assert [p.id for p in result.blocks[0].photos] == ["0.jpg", "1.jpg", "2.jpg"]
    reasons = dict(result.unoriented)
    assert reasons["cat.jpg"] == "it matches no other photo"
    assert "1.jpg" in reasons["copy.jpg"]
    assert "blurred" in reasons["blurred.jpg"]


def test_separate_scenes_make_separate_blocks(street):
    other = Scene(relief(5), [pose(-1.0), pose(0.0, y=0.2), pose(1.0)], [camera()] * 3)
    points, cameras = street.points + other.points, street.cameras + other.cameras
    photos = street.photos + [Photo(f"other {k}", c) for k, c in enumerate(other.cameras)]
    result = build_blocks(photos, points, matched(points, cameras))
    assert [sorted(b.numbers.tolist()) for b in result.blocks] == [[0, 1, 2, 3], [4, 5, 6]]
    assert result.unoriented == ()


def facade(plaster):
    texture = windows(16, 8, 2.0, plaster=noise(16, 8, 3) if plaster else None)
    return [Board(texture, -8.0, -4.0, 9.0)]


VIEWS = [pose(-1.1, turn=2), pose(0.0, y=0.15), pose(1.0, turn=-2)]


def test_identical_windows_on_an_even_wall_are_ambiguous():
    scene = Scene(facade(plaster=False), VIEWS, [camera()] * 3)
    assert scene.pairs == [] or min(p.rival for p in scene.pairs) > 0.6
    result = build_blocks(scene.photos, scene.points, scene.pairs)
    assert result.blocks == ()
    assert all("windows repeat" in why or "matches" in why for _, why in result.unoriented)
    assert len(result.unoriented) == 3


def test_identical_windows_on_a_wall_with_texture_are_told_apart():
    scene = Scene(facade(plaster=True), VIEWS, [camera()] * 3)
    assert max(p.rival for p in scene.pairs) < 0.6
    (block,) = build_blocks(scene.photos, scene.points, scene.pairs).blocks
    position, angle = scene.errors(block)
    assert position < 5e-3
    assert angle < 0.1
    assert doubts(block, scene.points, TieOptions()) == []


def test_the_strongest_shift_is_found():
    rng = np.random.default_rng(0)
    zero, pitch = rng.normal(0, 0.01, (100, 2)), np.array([3.1, 0.0]) + rng.normal(0, 0.01, (70, 2))
    chance = rng.uniform(-8, 8, (400, 2))
    shifts = np.concatenate([zero, pitch, chance])
    rival = strongest_shift(shifts, np.arange(len(shifts)), 0.06, 4.0)
    assert rival.share == pytest.approx(0.7, abs=0.05)
    assert rival.shift == pytest.approx([3.1, 0.0], abs=0.06)
    assert rival.same_shift(shifts).sum() == pytest.approx(70, abs=3)


def fake_pair(first, second, rotation, rows=40, rival=0.0):
    return PairMatches(first, second, np.zeros((rows, 2), int), rotation, np.array([1.0, 0, 0]), 0.1, rival)


def test_a_pair_that_closes_no_triangle_is_left_out():
    def turn(degrees):
        return pose(0, turn=degrees).R

    pairs = [fake_pair(i, j, turn(0)) for i in range(4) for j in range(i + 1, 4)]
    pairs[1] = fake_pair(0, 2, turn(20))
    photos = [Photo(str(k), camera()) for k in range(4)]
    kept = consistent(pairs, photos, TieOptions())
    assert [(p.first, p.second) for p in kept] == [(0, 1), (0, 3), (1, 2), (1, 3), (2, 3)]


def approximate(x, turn, sigma_m=1.0, sigma_deg=3.0):
    covariance = np.diag([sigma_m**2] * 3 + [np.radians(sigma_deg) ** 2] * 3)
    return Estimate(pose(x, turn=turn), covariance, 0.0)


def test_a_weak_pair_must_agree_with_the_approximate_poses():
    photos = [Photo("a", camera(), approximate(0, 0)), Photo("b", camera(), approximate(1, 0))]
    assert consistent([fake_pair(0, 1, pose(0, turn=10).R)], photos, TieOptions())
    assert not consistent([fake_pair(0, 1, pose(0, turn=60).R)], photos, TieOptions())
    assert consistent([fake_pair(0, 1, pose(0, turn=60).R, rows=500)], photos, TieOptions())


def test_pairs_whose_views_cannot_overlap_are_not_tried():
    empty = KeyPoints(np.zeros((0, 2)), np.zeros(0), np.zeros((0, 128), np.uint8))
    photos = [
        Photo("a", camera(), approximate(0, 0)),
        Photo("b", camera(), approximate(2, 5)),
        Photo("back", camera(), approximate(0, 180)),
        Photo("unknown", camera()),
    ]
    assert candidate_pairs(photos, [empty] * 4) == [(0, 1), (0, 3), (1, 3), (2, 3)]


def test_of_many_photos_only_promising_pairs_are_tried(street):
    foreign = [
        KeyPoints(p.pixels, p.scale, np.random.default_rng(k).integers(0, 255, (len(p), 128)))
        for k, p in enumerate([street.points[0]] * 9)
    ]
    points = street.points + foreign
    photos = street.photos + [Photo(f"f{k}", camera()) for k in range(9)]
    pairs = candidate_pairs(photos, points)
    assert {(i, j) for i in range(4) for j in range(i + 1, 4)} <= set(pairs)
    assert len(pairs) < 13 * 12 / 2


def test_a_distorted_camera_keeps_its_model():
    params = np.array([540.0, 540.0, 323.0, 238.0, -0.08, 0.03, 0.0004, -0.0003])
    lens, plain = Camera("OPENCV", 640, 480, params), Camera("PINHOLE", 640, 480, params[:4])
    x, y = np.meshgrid(np.arange(640) + 0.5, np.arange(480) + 0.5)
    source = plain.project(lens.ray(np.column_stack([x.ravel(), y.ravel()]))).reshape(480, 640, 2) - 0.5
    source = source.astype(np.float32)
    views = [pose(-1.0), pose(0.0, y=0.2), pose(1.0, turn=-4)]
    pictures = [cv2.remap(render(relief(), v, plain), source, None, cv2.INTER_CUBIC) for v in views]
    points = [key_points(p, FEW) for p in pictures]
    scene = Scene.__new__(Scene)
    scene.views = views
    result = build_blocks([Photo(str(k), lens) for k in range(3)], points, matched(points, [lens] * 3))
    (block,) = result.blocks
    assert all(p.camera.model == "OPENCV" and p.camera.params == pytest.approx(params) for p in block.photos)
    position, angle = scene.errors(block)
    assert position < 4e-3
    assert angle < 0.08


def test_without_pycolmap_one_sentence_names_the_extra(street, monkeypatch):
    monkeypatch.setitem(sys.modules, "pycolmap", None)
    with pytest.raises(MissingExtra, match=r"frontage\[photos\]"):
        build_blocks(street.photos, street.points, street.pairs)


def test_no_photos_give_no_blocks():
    result = build_blocks([], [], [])
    assert result.blocks == ()
    assert result.unoriented == ()


def test_poses_are_local_from_camera(built):
    poses = [p.pose for p in built.blocks[0].photos]
    assert {(p.to, p.frm) for p in poses} == {("local", "camera")}


PITCH = 2.0


def block_at(scene, views):
    """The block that results when photos of a flat facade at z = 9 m are believed to stand at `views`."""
    places = []
    for view, lens, points in zip(views, scene.cameras, scene.points, strict=True):
        rays = view.rotate(lens.ray(points.pixels))
        places.append((view.t + rays * ((9.0 - view.t[2]) / rays[:, 2])[:, None])[:, :2])
    rows = [(0, i, i) for i in range(len(places[0]))]
    tree = KDTree(places[0])
    for k in (1, 2):
        distance, point = tree.query(places[k])
        _, first = np.unique(point[distance < 0.02], return_index=True)
        near = np.flatnonzero(distance < 0.02)[first]
        rows += [(k, int(point[i]), int(i)) for i in near]
    photo, point, row = np.array(rows).T
    unknown = np.full((6, 6), np.nan)
    photos = [
        Photo(str(k), c, Estimate(v, unknown, 0))
        for k, (c, v) in enumerate(zip(scene.cameras, views, strict=True))
    ]
    xyz = np.column_stack([places[0], np.full(len(places[0]), 9.0)])
    pixels = np.array([scene.points[k].pixels[i] for k, i in zip(photo, row, strict=True)])
    return Block(np.arange(3), tuple(photos), xyz, photo, point, pixels)


def test_a_photo_that_is_one_window_off_is_found():
    scene = Scene(facade(plaster=True), VIEWS, [camera()] * 3)
    assert doubts(block_at(scene, VIEWS), scene.points, FEW) == []
    wrong = [*VIEWS[:2], Rigid3("local", "camera", VIEWS[2].R, VIEWS[2].t + np.array([PITCH, 0, 0]))]
    block = block_at(scene, wrong)
    found = [d for d in doubts(block, scene.points, FEW) if d.photo == 2]
    assert len(found) == 1
    assert found[0].share > 1
    assert np.linalg.norm(found[0].shift) == pytest.approx(PITCH, abs=0.1)


@pytest.mark.parametrize(("sigma", "settled"), [(0.3, True), (2.0, False)])
def test_an_approximate_pose_settles_a_doubt_when_it_is_good_enough(sigma, settled):
    scene = Scene(facade(plaster=False), VIEWS, [camera()] * 3)
    block = block_at(scene, VIEWS)
    given = [
        Photo(p.id, p.camera, Estimate(p.pose, np.diag([sigma**2] * 3 + [0.001] * 3), 0.0))
        for p in block.photos
    ]
    found = doubts(block, scene.points, FEW)
    assert [d.photo for d in found] == [0, 1, 2]
    assert [settles(d, block, given) for d in found] == [settled] * 3
    assert not contradicts(0, block, given)
    moved = Rigid3("local", "camera", given[0].pose.R, given[0].pose.t + np.array([9.0 * sigma, 0, 0]))
    given[0] = Photo("0", given[0].camera, Estimate(moved, given[0].local_from_camera.covariance, 0.0))
    assert contradicts(0, block, given)
