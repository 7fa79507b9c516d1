"""Places that the photos do not agree on are shown whole by one photo, and walkers are no such places."""

from types import SimpleNamespace

import numpy as np
import pytest

import ortho_wall as wall
from frontage.ortho import OrthoOptions, make_ortho
from frontage.ortho.mosaic.places import averaged, whole_places

CELL = 0.04
REVEAL = 0.35  # m
WINDOW = (-0.9, -0.9, 0.9, 0.9)


def accepted(*torn, photos=4):
    """Which photos (k, 100, 120) are accepted: `torn` are windows, each with the photos that differ in it."""
    found = np.ones((photos, 100, 120), bool)
    for window, which in torn:
        found[np.ix_(which, *(np.arange(s.start, s.stop) for s in window))] = False
    return SimpleNamespace(accepted=found), np.ones_like(found)


def test_what_most_photos_disagree_on_is_one_place():
    rows, columns = slice(20, 50), slice(30, 60)
    place = whole_places(*accepted(((rows, columns), [0, 1, 3])), CELL)
    assert (place[22:48, 32:58] == 1).all()
    assert not place[:14].any() and not place[:, 66:].any()


def test_a_walker_in_one_of_five_photos_is_no_place_and_neither_is_a_whole_facade():
    walker = ((slice(30, 75), slice(30, 45)), [2])
    assert not whole_places(*accepted(walker, photos=5), CELL).any()
    everything = ((slice(0, 100), slice(0, 120)), [0, 1, 2])
    assert not whole_places(*accepted(everything), CELL).any(), "19 m2 are no window"


def test_two_photos_cannot_disagree_with_a_third():
    assert not whole_places(*accepted(((slice(20, 50), slice(30, 60)), [0]), photos=2), CELL).any()


def test_costs_are_averaged_over_a_place_where_the_photo_is_clear():
    place = np.zeros((4, 5), int)
    place[:, 1:3] = 7
    cost = np.arange(20.0).reshape(1, 4, 5)
    clear = np.ones((1, 4, 5), bool)
    clear[0, 0, 1] = False
    found = averaged(cost, place, clear)[0]
    assert found[0, 1] == cost[0, 0, 1] and (found[:, 3:] == cost[0, :, 3:]).all()
    assert np.allclose(found[1:, 1:3], (cost[0, :, 1:3].sum() - cost[0, 0, 1]) / 7)


@pytest.fixture(scope="module")
def bars():
    """A window with bars behind a wall of which the scan is too coarse for relief."""
    facade = wall.facade(6.0, 4.0, spacing=0.1)
    picture = np.repeat((wall.texture(6.0, 4.0)[..., :1] * 0.6).astype(np.uint8), 3, axis=2)
    pane = np.s_[200 - 90 : 200 + 90, 300 - 90 : 300 + 90]
    picture[pane] = 40
    for at in (110, 168, 226, 284):
        picture[at : at + 6, 210:390] = picture[110:290, at + 100 : at + 106] = 220

    def depth(x, z):
        return np.where((np.abs(x) < WINDOW[2]) & (np.abs(z) < WINDOW[3]), REVEAL, 0.0)

    photos = [
        wall.photo(facade, wall.camera(1000, 800), (x, -6.0, 0.3 * x), name=f"{x:g}.jpg")
        for x in (-2.2, -0.8, 0.6, 1.6, 2.6)
    ]
    shots = {p.id: wall.render(p, facade, picture, depth) for p in photos}
    cloud = wall.wall_cloud(facade, spacing=0.1)
    return make_ortho(facade, cloud, photos, shots.__getitem__, options=OrthoOptions(margin=0.0))


def test_one_photo_shows_a_window_whose_depth_nobody_knows(bars):
    assert np.isnan(bars.depth[200, 300]), "no relief"
    source = bars.source[130:270, 230:370]
    assert np.bincount(source.ravel()).max() > 0.95 * source.size
