"""Photos that contradict the scan or each other do not paint; good photos always do."""

from dataclasses import replace
from functools import partial

import cv2
import numpy as np
import pytest

import ortho_wall as wall
from frontage.geometry.rigid import Rigid3
from frontage.io.photos.imagefile import upright
from frontage.model import Failed, Photo
from frontage.ortho import OrthoOptions, make_ortho
from frontage.ortho.checks.patches import Patches, agreement
from frontage.pipeline.stages.ortho import ortho_warnings

OPTIONS = OrthoOptions(margin=0.0, gsd=0.02)
EYES = {"a": (-5.0, -9.0, -2.0), "b": (0.0, -10.0, -2.0), "c": (5.0, -9.0, -2.0)}
WIDTH, HEIGHT = 12.0, 9.0


@pytest.fixture(scope="module")
def scene():
    facade = wall.facade(WIDTH, HEIGHT)
    picture = wall.texture(WIDTH, HEIGHT)
    photos = [
        wall.photo(facade, wall.camera(1200, 900), eye, (0.3 * eye[0], 0, 0), name)
        for name, eye in EYES.items()
    ]
    images = {p.id: wall.render(p, facade, picture) for p in photos}
    return facade, picture, wall.wall_cloud(facade, spacing=0.04), photos, images


def coloured(cloud, facade, picture):
    """The cloud with the colours of the wall."""
    x, _, z = facade.frame.inverse.apply(cloud.xyz).T
    row = np.clip((HEIGHT / 2 - z) / wall.GSD, 0, picture.shape[0] - 1).astype(int)
    column = np.clip((x + WIDTH / 2) / wall.GSD, 0, picture.shape[1] - 1).astype(int)
    return replace(cloud, rgb=picture[row, column])


def off(photo: Photo, turn_degrees: float, shift=(0.0, 0.0, 0.0)) -> Photo:
    """The photo with a wrong pose."""
    pose, angle = photo.local_from_camera, np.radians(turn_degrees)
    R = cv2.Rodrigues(np.array([0.0, angle, 0.0]))[0]
    wrong = Rigid3("local", "camera", pose.value.R @ R, pose.value.t + np.array(shift))
    return replace(photo, local_from_camera=replace(pose, value=wrong))


def codes(ortho):
    return [w.code for w in ortho_warnings("B01/F1", ortho)]


@pytest.mark.parametrize("colour", [False, True])
@pytest.mark.parametrize("change", [{"turn_degrees": 12.0}, {"turn_degrees": 0.0, "shift": (1.5, 0.7, 1.0)}])
def test_a_photo_with_a_wrong_pose_is_left_out(scene, change, colour):
    facade, picture, cloud, photos, images = scene
    cloud = coloured(cloud, facade, picture) if colour else cloud
    given = [photos[0], off(photos[1], **change), photos[2]]
    ortho = make_ortho(facade, cloud, given, images.__getitem__, options=OPTIONS)
    good = make_ortho(facade, cloud, [photos[0], photos[2]], images.__getitem__, options=OPTIONS)
    assert codes(ortho) == ["F305"]
    assert "photo b" in ortho.remarks[0].message and " of " in ortho.remarks[0].message
    assert np.array_equal(ortho.pixels, good.pixels)
    assert "b" not in ortho.sources


def test_a_single_photo_is_compared_with_the_colours_of_the_scan(scene):
    facade, picture, cloud, photos, images = scene
    cloud = coloured(cloud, facade, picture)
    ortho = make_ortho(facade, cloud, [photos[1]], images.__getitem__, options=OPTIONS)
    assert codes(ortho) == [] and "b" in ortho.sources
    ortho = make_ortho(facade, cloud, [off(photos[1], 12.0)], images.__getitem__, options=OPTIONS)
    assert codes(ortho) == ["F305", "F304"]
    assert "1 left out for another reason" in ortho.remarks[1].message
    assert ortho.photos == 0 and "b" not in ortho.sources


def test_good_photos_are_never_left_out(scene):
    """Other light, other contrast, noise, a pose that is off by some pixels, a tree in front of a half."""
    facade, picture, cloud, photos, images = scene
    random = np.random.default_rng(5)
    shade = np.linspace(0.3, 1.0, 1200)[None, :, None]
    noisy = np.clip(images["a"] * shade * 0.6 + random.normal(0, 12, images["a"].shape), 0, 255)
    tree = images["b"].copy()
    tree[:, :500] = random.integers(0, 90, (900, 500, 3))
    changed = {"a": noisy.astype(np.uint8), "b": tree, "c": 255 - (255 - images["c"]) // 3}
    given = [photos[0], off(photos[1], 0.2), photos[2]]
    for scan in (cloud, coloured(cloud, facade, picture)):
        ortho = make_ortho(facade, scan, given, changed.__getitem__, options=OPTIONS)
        assert not {"F304", "F305"} & set(codes(ortho))
        assert ortho.photos == 3


def test_what_cannot_be_compared_is_not_judged(scene):
    facade, _, cloud, photos, images = scene
    grey = replace(cloud, rgb=None)
    wrong = off(photos[1], 12.0)
    assert codes(make_ortho(facade, grey, [wrong], images.__getitem__, options=OPTIONS)) == []
    two = make_ortho(facade, grey, [photos[0], wrong], images.__getitem__, options=OPTIONS)
    assert codes(two) == [], "nothing tells which of the two is wrong"


@pytest.mark.parametrize("meant", ["stored", "upright"])
@pytest.mark.parametrize(
    ("reference", "orientation"),
    [("scan", 3), ("another photo", 2), ("another photo", 3), ("another photo", 4), ("each other", 3)],
)
def test_the_orientation_that_agrees_is_taken(scene, orientation, meant, reference):
    """The files store turned pixels; the cameras mean either these, or those that are turned back (2, 3 and 4
    are their own inverses)."""
    facade, picture, cloud, photos, images = scene
    scan = coloured(cloud, facade, picture) if reference == "scan" else replace(cloud, rgb=None)
    doubtful = {"scan": ["b"], "another photo": ["b"], "each other": ["a", "b", "c"]}[reference]
    given = photos[1:2] if reference == "scan" else photos
    turns = {name: partial(upright, orientation=orientation) for name in doubtful}
    stored = dict(images)
    if meant == "upright":
        stored |= {name: upright(images[name], orientation) for name in doubtful}
    ortho = make_ortho(facade, scan, given, stored.__getitem__, options=OPTIONS, turns=turns)
    good = make_ortho(facade, scan, given, images.__getitem__, options=OPTIONS)
    assert codes(good) == []
    assert codes(ortho) == ([] if meant == "stored" else ["F307"])
    assert np.array_equal(ortho.pixels, good.pixels)


def test_an_orientation_that_nothing_tells_is_refused(scene):
    facade, _, cloud, photos, images = scene
    turns = {"b": partial(upright, orientation=3)}
    grey = replace(cloud, rgb=None)
    ortho = make_ortho(facade, grey, [photos[1]], images.__getitem__, options=OPTIONS, turns=turns)
    assert codes(ortho) == ["F306", "F304"]
    assert ortho.photos == 0


def test_an_image_without_photos_says_why(scene):
    facade, _, cloud, photos, images = scene
    behind = wall.photo(facade, wall.camera(1200, 900), (0.0, 9.0, 0.0), name="behind")
    away = wall.photo(facade, wall.camera(1200, 900), (0.0, -9.0, 0.0), (0.0, -50.0, 0.0), name="away")
    blind = Photo("blind", wall.camera(1200, 900))
    images = dict.fromkeys(("behind", "away", "blind"), images["a"])
    ortho = make_ortho(facade, cloud, [behind, away, away, blind], images.__getitem__, options=OPTIONS)
    assert codes(ortho) == ["F304"]
    assert ortho.photos == 0
    for reason in ("none of 4 photos", "1 behind it", "2 looking elsewhere", "1 without a pose"):
        assert reason in ortho.remarks[0].message
    hidden = make_ortho(
        facade, cloud, photos[:1], images.__getitem__, surroundings=_curtain(facade), options=OPTIONS
    )
    assert not isinstance(hidden, Failed)
    assert "1 where something hides it" in hidden.remarks[0].message
    assert codes(make_ortho(facade, cloud, options=OPTIONS)) == [], "none were given"


def _curtain(facade):
    """A dense cloud that hides the whole facade."""
    return wall.wall_cloud(facade, spacing=0.04, depth=lambda x, z: np.full_like(x, -4.0))


@pytest.mark.parametrize("order", [1, -1])
def test_a_photo_that_shows_three_patches_is_compared_with_one_that_shows_many(order):
    rng = np.random.default_rng(0)
    grey = {n: cv2.GaussianBlur(rng.normal(0, 20, (48, 48)).astype(np.float32), (0, 0), 1) for n in range(12)}
    few, many = Patches({n: grey[n] for n in (2, 5, 7)}), Patches(grey)
    found = agreement(*(few, many)[::order])
    assert (found.agreeing, found.count) == (3, 3)
    assert found.chance == pytest.approx(0.001)
    swapped = Patches({2: grey[5], 5: grey[7], 7: grey[2]})
    assert agreement(*(swapped, many)[::order]).agreeing == 0


def test_a_few_places_in_a_row_are_enough_to_relate_two_pictures():
    rng = np.random.default_rng(0)
    grey = {n: cv2.GaussianBlur(rng.normal(0, 20, (48, 48)).astype(np.float32), (0, 0), 1) for n in range(12)}
    found = agreement(Patches(grey), Patches(grey), enough=0.02)
    assert (found.agreeing, found.count) == (2, 2)
    assert agreement(Patches(grey), Patches(grey)).count == 12
