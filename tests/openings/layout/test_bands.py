"""Bands of windows parted by joinery: several windows, and casements that meet in one."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from frontage.openings import FoundOpenings, find_openings
from frontage.openings.layout.joinery import beside, frame_above, joinery_planes, post_borders
from frontage.openings.layout.posts import Post, same_on_most
from frontage.openings.wall.beams import sort_beams
from frontage.openings.wall.evidence import weigh
from openings.boxes import box, scanned
from openings.joinery import glazed, wall

DEEP, FRAME = 0.15, 0.07
BAND = (0.6, 3.0, 7.4, 4.4)


def panes(hole, number, post, end):
    """Equal panes in a hole, `post` m between them, `end` m of joinery at either end."""
    x0, z0, x1, z1 = hole
    wide = (x1 - x0 - 2 * end - (number - 1) * post) / number
    left = [x0 + end + k * (wide + post) for k in range(number)]
    return [(x, z0 + FRAME, x + wide, z1 - FRAME) for x in left]


def bars(lights, deep):
    """A bar 8 cm wide in the middle of each pane: casements meet."""
    middles = [((a + c) / 2, b, d) for a, b, c, d in lights]
    return [box(x - 0.04, x + 0.04, deep + 0.003, deep + 0.06, z0, z1) for x, z0, z1 in middles]


def found_in(hole, lights, more=(), **how):
    found = find_openings(*scanned(wall=[*wall([hole]), *glazed(hole, DEEP, lights), *more], **how))
    assert isinstance(found, FoundOpenings)
    return [(np.concatenate([o.ring.min(0), o.ring.max(0)]), o) for o in found.openings]


@pytest.mark.parametrize(("post", "rays"), [(0.15, True), (0.2, True), (0.2, False)])
def test_posts_as_wide_as_two_frames_part_a_band(post, rays):
    lights = panes(BAND, 5, post, 0.1)
    found = found_in(BAND, lights, bars(lights, DEEP), spacing=0.02, rays=rays)
    assert len(found) == 5
    own = np.array([place for place, _ in found])
    assert np.abs(own[:, [1, 3]] - [BAND[1], BAND[3]]).max() < 0.02
    assert np.abs(own[[0, -1], [0, 2]] - [BAND[0], BAND[2]]).max() < 0.01  # the masonry at both ends
    left, right = own[1:, 0] - np.array(lights)[1:, 0], own[:-1, 2] - np.array(lights)[:-1, 2]
    assert np.all((-left > -0.02) & (-left < post / 2) & (right > -0.02) & (right < post / 2))


def test_posts_may_stand_on_the_lower_end_of_the_raster():
    band = (2.0, 0.0, 6.0, 2.4)
    lights = [(x0, 0.0, x1, z1) for x0, _, x1, z1 in panes(band, 3, 0.2, 0.1)]
    found = np.array([place for place, _ in found_in(band, lights, spacing=0.02)])
    assert len(found) == 3
    assert np.abs(found[:, [1, 3]] - [band[1], band[3]]).max() < 0.02


def test_where_windows_meet_in_a_post_is_not_seen_and_its_sigma_says_so():
    lights = panes(BAND, 5, 0.2, 0.1)
    (_, opening) = found_in(BAND, lights, spacing=0.02)[2]
    sigma = np.sqrt(np.diag(opening.ring_covariance))
    corners = opening.ring[:, 1].argmin(), opening.ring[:, 1].argmax()
    assert sigma[2 * corners[0]] > 0.02 > 0.005 > sigma[2 * corners[0] + 1]


def test_windows_end_a_quarter_inside_the_post_between_them():
    post = 0.2
    lights = panes(BAND, 5, post, 0.1)
    middles = np.array([(a[2] + b[0]) / 2 for a, b in itertools.pairwise(lights)])
    found = np.array([place for place, _ in found_in(BAND, lights, spacing=0.02)])
    assert np.abs(found[1:, 0] - middles - post / 4).max() < 0.01
    assert np.abs(middles - post / 4 - found[:-1, 2]).max() < 0.01


def test_what_stands_on_most_rasters_is_told_once():
    posts = [Post(x, 0.0, x + 0.2, 1.0, 0.1) for x in (1.0, 2.0, 3.0, 4.0)]
    moved = [replace(post, x0=post.x0 + 0.1, x1=post.x1 + 0.1) for post in posts]
    first, second, third = posts[:3], [moved[3], moved[0]], [posts[3], moved[1]]
    assert list(same_on_most([first, second, third])) == [
        [(0, 0), (1, 1)],
        [(0, 1), (2, 1)],
        [(1, 0), (2, 0)],
    ]
    assert list(same_on_most([first])) == [[(0, 0)], [(0, 1)], [(0, 2)]]


@pytest.mark.parametrize("post", [0.08, 0.1])
def test_casements_that_meet_are_one_window(post):
    (only,) = found_in(BAND, panes(BAND, 5, post, 0.1), spacing=0.02)
    assert np.abs(only[0] - BAND).max() < 0.01


def test_mullions_of_which_some_seem_as_wide_as_two_frames_part_leaves_only():
    hole, middles = (2.0, 3.0, 6.0, 5.0), np.arange(2.65, 5.6, 0.675)
    half = np.resize([0.055, 0.08], len(middles))
    left, right = [2.07, *middles + half], [*middles - half, 5.93]
    lights = [(a, hole[1] + FRAME, c, hole[3] - FRAME) for a, c in zip(left, right, strict=True)]
    (only,) = found_in(hole, lights, spacing=0.02, rays=False)
    assert np.abs(only[0] - hole).max() < 0.01


def test_leaves_of_a_window_are_narrower_than_windows():
    hole = (3.0, 3.0, 4.6, 4.4)
    (only,) = found_in(hole, panes(hole, 2, 0.16, 0.07), spacing=0.02)
    assert np.abs(only[0] - hole).max() < 0.01


def test_curtains_are_no_posts():
    hole = (2.0, 3.0, 6.0, 4.6)
    curtain = box(3.9, 4.1, 0.25, 0.27, 3.0, 4.6)
    (only,) = found_in(hole, panes(hole, 1, 0.0, 0.07), [curtain], spacing=0.02)
    assert np.abs(only[0] - hole).max() < 0.01


def test_windows_back_to_back_are_parted_by_the_blades_between_their_reveals():
    lights = panes(BAND, 4, 2 * FRAME, FRAME)
    middles = [(a[2] + b[0]) / 2 for a, b in itertools.pairwise(lights)]
    blades = [box(x - 0.005, x + 0.005, 0.0, DEEP, BAND[1], BAND[3]) for x in middles]
    shelf = box(0.0, 8.0, -0.4, 0.0, 2.4, 2.75)  # hides the sills from the street
    found = np.array([place for place, _ in found_in(BAND, lights, [*blades, shelf], spacing=0.02)])
    assert len(found) == 4
    assert np.abs(found[:, 3] - BAND[3]).max() < 0.02
    assert np.abs(found[1:, 0] - middles).max() < 0.1 and np.abs(found[:-1, 2] - middles).max() < 0.1


def test_windows_over_a_passage_stand_on_the_rail_of_their_frames():
    band, hole = (2.0, 3.1, 5.4, 4.4), (2.0, 0.0, 5.4, 4.4)
    behind = [
        box(2.0, 5.4, 2 * DEEP, 1.0, 3.0, 3.1),
        box(1.0, 6.5, 3.0, 3.1, 0.0, 4.4),
    ]  # its head and far end
    boxes = [*wall([hole]), *glazed(band, DEEP, panes(band, 2, 2 * FRAME, FRAME)), *behind]
    found = find_openings(*scanned(wall=boxes, spacing=0.02))
    assert isinstance(found, FoundOpenings)
    places = np.array([[*o.ring.min(0), *o.ring.max(0)] for o in found.openings])
    (below,), (left, right) = places[places[:, 1] < 2.0], sorted(places[places[:, 1] > 2.0].tolist())
    assert abs(below[3] - 3.0) < 0.12
    for window, x0, x1 in ((left, 2.0, 3.7), (right, 3.7, 5.4)):
        assert np.abs(np.array(window) - [x0, band[1], x1, band[3]]).max() < 0.1


@pytest.mark.parametrize("post", [0.11, 0.16])
def test_widths_of_posts_and_frames_are_those_of_the_joinery(post):
    facade, scan = scanned(
        wall=[*wall([BAND]), *glazed(BAND, DEEP, panes(BAND, 4, post, FRAME))], spacing=0.02
    )
    beams = sort_beams(facade, scan)
    evidence = weigh(facade, beams)
    plane = next(joinery_planes(beams, evidence))  # the fullest
    piece = (4.0 - post / 2, BAND[1], 4.0 + post / 2, BAND[3])
    borders = post_borders(plane, piece, evidence)
    assert borders is not None
    assert np.abs(np.array(borders) - piece[::2]).max() < 0.01
    frames = [frame_above(plane, side, piece, BAND[3], evidence) for side in beside(*borders)]
    assert np.abs(np.array(frames) - FRAME).max() < 0.012
