"""Where two photos disagree, the one that shows the colours of the wall is taken."""

import cv2
import numpy as np
import pytest

import ortho_wall as wall
from frontage.ortho import OrthoOptions, make_ortho
from frontage.ortho.mosaic.consensus import compare_photos
from frontage.ortho.mosaic.pairs import judge_pairs

WALL, DOOR, COAT = np.array([[0.62, 0.55, 0.45], [0.3, 0.1, 0.1], [0.2, 0.3, 0.6]])
NOISE = 0.012
WALKER = np.s_[30:60, 40:50]


def seen(shown: np.ndarray, clear: np.ndarray | None = None):
    """What is found in photos (k, 60, 90) that show wall (0), a door (1) or a walker (2)."""
    rng = np.random.default_rng(0)
    codes = np.array([WALL, DOOR, COAT])[shown] + rng.normal(0.0, NOISE, (*shown.shape, 3))
    codes = codes.astype(np.float32)
    clear = np.ones(shown.shape, bool) if clear is None else clear
    return judge_pairs(codes, compare_photos(codes, clear), clear, np.zeros(shown.shape[1:], bool))


def test_the_photo_with_the_walker_costs_and_the_other_does_not():
    shown = np.zeros((2, 60, 90), int)
    shown[1][WALKER] = 2
    found = seen(shown)
    assert found.cost[1][WALKER].mean() > 2.0 > 0.5 > found.cost[0][WALKER].mean()
    assert not found.accepted[1][WALKER].any() and found.accepted[0][WALKER].all()
    elsewhere = np.s_[:, :, 60:]
    assert found.cost[elsewhere].max() < 0.5 and found.accepted[elsewhere].all()


def test_what_both_photos_show_is_wall_whatever_its_colour():
    shown = np.zeros((2, 60, 90), int)
    shown[:, 20:60, 10:30] = 1
    found = seen(shown)
    assert np.median(found.cost[:, 25:55, 12:28]) < 0.5
    assert found.accepted[:, 25:55, 12:28].mean() > 0.99


def test_a_third_photo_or_none_leaves_the_costs_alone():
    shown = np.zeros((3, 60, 90), int)
    shown[1][WALKER] = 2
    three = seen(shown)
    assert np.median(three.cost[[0, 2]][:, 30:60, 40:50]) < 2.0 < three.cost[1][WALKER].min()
    clear = np.ones((3, 60, 90), bool)
    clear[1:] = False
    assert seen(shown, clear).cost.max() == 0.0


@pytest.mark.parametrize("walker_in", [0, 1])
def test_a_walker_in_one_of_two_photos_is_not_painted(walker_in):
    facade = wall.facade(8.0, 6.0)
    grey = np.repeat((wall.texture(8.0, 6.0)[..., :1] * 0.3 + 90).astype(np.uint8), 3, axis=2)
    picture = cv2.GaussianBlur(grey, (0, 0), 4.0)
    eyes = [(-1.5, -8.0, -1.5), (1.5, -8.0, -1.5)]
    photos = [
        wall.photo(facade, wall.camera(1000, 800), eye, (0.0, 0, 0), f"{n}.jpg") for n, eye in enumerate(eyes)
    ]
    shots = {}
    for n, photo in enumerate(photos):
        seen = picture.copy()
        if n == walker_in:
            seen[330:600, 360:440] = (20, 30, 90)
        shots[photo.id] = wall.render(photo, facade, seen)
    options = OrthoOptions(margin=0.0)
    ortho = make_ortho(facade, wall.wall_cloud(facade), photos, shots.__getitem__, options=options)
    blue = ortho.pixels[..., 2].astype(int) - ortho.pixels[..., 0] > 20
    assert blue.mean() < 0.0005
    assert (ortho.pixels[330:590, 360:440, 3] > 0).all(), "the other photo shows the wall behind him"


def test_photos_that_do_not_see_a_cell_have_no_say_in_it():
    shown = np.zeros((4, 60, 90), int)
    shown[1][WALKER] = 2
    shown[2:] = 1
    clear = np.ones((4, 60, 90), bool)
    clear[2:] = False
    found = seen(shown, clear)
    assert found.cost[1][WALKER].mean() > 2.0 > 0.5 > found.cost[0][WALKER].mean()
