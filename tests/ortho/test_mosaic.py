"""One picture from many photos: one light, no walkers, whole patches, everything in its place."""

import cv2
import numpy as np
import pytest

import ortho_wall as wall
from frontage.ortho import OrthoOptions, make_ortho
from frontage.raster.light import brightened, linear_light

OPTIONS = OrthoOptions(margin=0.0)
GAINS = np.array([[0.4, 0.4, 0.5], [1.0, 1.0, 0.9], [0.7, 0.75, 0.7], [1.3, 1.25, 1.3]])
WALKER = (slice(330, 560), slice(360, 440))  # rows and columns of the facade, shown by one photo each


@pytest.fixture(scope="module")
def street():
    facade = wall.facade(8.0, 6.0)
    picture = (wall.texture(8.0, 6.0) * 0.7).astype(np.uint8)
    camera = wall.camera(1000, 800)
    eyes = [(-3.0, -8.0, -1.5), (-1.0, -8.0, -1.5), (1.0, -8.0, -1.5), (3.0, -8.0, -1.5)]
    photos = [wall.photo(facade, camera, eye, (0.4 * eye[0], 0, 0), f"{n}.jpg") for n, eye in enumerate(eyes)]
    shots = {}
    for n, photo in enumerate(photos):
        seen = picture.copy()
        if n in (1, 2):  # another walker before the same wall
            seen[WALKER] = (20, 30, 90) if n == 1 else (120, 30, 20)
        image = wall.render(photo, facade, seen)
        shots[photo.id] = brightened(image, falloff(image.shape) + np.log(GAINS[n]))
    return facade, picture, wall.wall_cloud(facade), photos, shots


def falloff(shape):
    """The logarithm (h, w, 1) of the light that a lens loses towards its corners."""
    h, w = shape[:2]
    v, u = np.mgrid[:h, :w] + 0.5
    r2 = ((u - w / 2) ** 2 + (v - h / 2) ** 2) / (0.25 * (w * w + h * h))
    return (-0.4 * r2)[..., None]


@pytest.fixture(scope="module")
def mosaic(street):
    facade, _, cloud, photos, shots = street
    return make_ortho(facade, cloud, photos, shots.__getitem__, options=OPTIONS)


def log_ratio(pixels, picture):
    """The logarithm (h, w, 3) of the light of a picture over that of the truth, without fine detail."""
    light = [cv2.GaussianBlur(linear_light(p[..., :3]), (0, 0), 6.0) for p in (pixels, picture)]
    return np.log(light[0]) - np.log(light[1])


def test_photos_of_unlike_light_become_one_picture(street, mosaic):
    _, picture, _, _, _ = street
    assert len(np.unique(mosaic.source)) > 1, "several photos paint"
    ratio = log_ratio(mosaic.pixels, picture)
    rest = np.abs(ratio - np.median(ratio, axis=(0, 1)))
    assert np.quantile(rest, 0.99) < 0.1, (
        "the photos differ by a factor of three and by a third in the corners"
    )
    assert 0.0 < np.median(rest) < 0.03


def test_as_shot_keeps_the_light_of_every_photo(street):
    facade, picture, cloud, photos, shots = street
    options = OPTIONS.model_copy(update={"radiometry": "as shot"})
    ortho = make_ortho(facade, cloud, photos, shots.__getitem__, options=options)
    ratio = log_ratio(ortho.pixels, picture)[..., 1]
    for number, name in enumerate(ortho.sources, 1):
        mine = cv2.erode((ortho.source == number).astype(np.uint8), np.ones((31, 31))) > 0
        if mine.sum() > 1000:
            gain = np.log(GAINS[int(name[0]), 1])
            assert gain - 0.4 < np.median(ratio[mine]) < gain + 0.02


def test_walkers_that_one_photo_shows_are_not_painted(street, mosaic):
    _, picture, _, _, _ = street
    inside = (slice(WALKER[0].start + 8, WALKER[0].stop - 8), slice(WALKER[1].start + 8, WALKER[1].stop - 8))
    names = np.array(["", *mosaic.sources])[mosaic.source[inside]]
    assert not np.isin(names, ["1.jpg", "2.jpg", ""]).any()
    ratio = log_ratio(mosaic.pixels, picture)
    around = np.median(ratio, axis=(0, 1))
    assert np.abs(np.median(ratio[inside], axis=(0, 1)) - around).max() < 0.05


def test_the_picture_has_no_specks_and_stays_in_its_place(street, mosaic):
    _, picture, _, _, _ = street
    for number in np.unique(mosaic.source):
        mask = (mosaic.source == number).astype(np.uint8)
        areas = cv2.connectedComponentsWithStats(mask, connectivity=4)[2][1:, cv2.CC_STAT_AREA]
        assert areas.min() > 0.02 / mosaic.gsd**2, "patches are larger than two square decimetres"
    shifts = np.linalg.norm(wall.displacement(mosaic.pixels, picture), axis=1)
    assert 0.0 < np.median(shifts) <= 0.3


def test_the_same_photos_give_the_same_bytes(street, mosaic):
    facade, _, cloud, photos, shots = street
    again = make_ortho(facade, cloud, photos, shots.__getitem__, options=OPTIONS)
    assert (again.pixels == mosaic.pixels).all()
    assert (again.source == mosaic.source).all()


def test_another_facade_takes_over_the_light_of_its_photos(street, mosaic):
    facade, picture, cloud, photos, shots = street
    first = make_ortho(facade, cloud, photos[:2], shots.__getitem__, options=OPTIONS)
    then = make_ortho(facade, cloud, photos[1:], shots.__getitem__, options=OPTIONS, light=first.light)
    alone = make_ortho(facade, cloud, photos[1:], shots.__getitem__, options=OPTIONS)
    right, left = (slice(100, 500), slice(500, 700)), (slice(100, 500), slice(100, 300))
    level = [
        np.median(log_ratio(o.pixels, picture)[s]) for o, s in ((first, left), (then, right), (alone, right))
    ]
    assert 0.0 <= abs(level[1] - level[0]) < 0.06, "one look"
    assert abs(level[2] - level[0]) > 0.12, "alone, the second picture has the mean light of its photos"
