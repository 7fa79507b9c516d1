"""An opening that is badly seen needs another one that is like it."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.openings import OpeningOptions
from frontage.openings.borders.measure import measure
from frontage.openings.borders.outline import Outline
from frontage.openings.layout.support import are_openings, have_jambs, odd_heads, without_unsupported
from frontage.openings.observe import observe_wall
from frontage.openings.wall.crossings import crossing_beams
from fronts import WINDOW, scan_wall

LOW = WINDOW[1] - 2.0  # m, ground far below the window


def measured(rays):
    facade, scan = scan_wall([WINDOW], rays=rays)
    wall = observe_wall(facade, scan, OpeningOptions())
    (outline,) = measure(crossing_beams(facade, scan, wall.beams), [WINDOW], 0.04, 0.02)
    return outline


def moved(outline, dx, dz, *, taller=0.0):
    x0, z0, x1, z1 = outline.place
    return replace(outline, place=(x0 + dx, z0 + dz, x1 + dx, z1 + dz + taller))


def vague(outline, borders=2):
    """Returns the outline with borders, from the left on, that are known to half a metre only."""
    unknown = np.diag([0.25] * borders + [0.0] * (5 - borders))
    return replace(outline, covariance=outline.covariance + unknown)


@pytest.fixture(scope="module")
def window():
    return measured(rays=False)


def test_what_three_borders_tell_stays_by_itself(window):
    assert without_unsupported([window], LOW)[0] is window
    assert without_unsupported([vague(window, 1)], LOW)[0] is not None


def test_what_two_borders_tell_is_left_out_by_itself(window):
    assert without_unsupported([vague(window), None], LOW) == [None, None]


@pytest.mark.parametrize("aside", [(2.0, 0.1), (0.1, 3.0)])
def test_what_two_borders_tell_stays_beside_or_above_one_like_it(window, aside):
    badly_seen = vague(moved(window, *aside))
    assert without_unsupported([window, badly_seen], LOW)[1] is badly_seen


def test_another_size_another_place_or_one_as_vague_is_no_support(window):
    larger, elsewhere = moved(window, 2.0, -1.6, taller=3.2), moved(window, 2.0, 1.5)
    for outline in (larger, elsewhere):
        assert without_unsupported([window, vague(outline)], LOW)[1] is None
    assert without_unsupported([vague(window), vague(moved(window, 2.0, 0.0))], LOW) == [None, None]


def test_lines_of_sight_through_the_wall_prove_an_opening():
    seen = vague(measured(rays=True), 3)
    assert without_unsupported([seen], LOW)[0] is seen
    assert without_unsupported([vague(seen, 4)], LOW) == [None]  # no border tells where it ends


def test_the_foot_of_a_door_is_known_by_the_ground(window):
    """Left and foot are hidden; but for the ground, two borders would tell nothing."""
    left = np.diag([0.25, 0.0, 0.25, 0.0, 0.0])
    door = replace(window, covariance=window.covariance + left)
    assert without_unsupported([door], LOW) == [None]
    assert without_unsupported([door], door.place[1] - 0.1) == [door]


def small(outline, depth, dx=0.0):
    """Returns an outline 0.5 m wide, moved by dx m, with a frame `depth` m deep and nothing behind it."""
    x0, z0, _, z1 = outline.place
    place = (x0 + dx, z0, x0 + dx + 0.5, z1)
    return replace(outline, place=place, depth=replace(outline.depth, value=depth), sunken=0.0)


def test_a_small_window_no_deeper_than_a_panel_is_one_if_another_one_surely_is(window):
    deep, shallow = small(window, 0.12), small(window, 0.06, dx=1.5)
    assert are_openings([deep, shallow]) == [True, True]
    assert are_openings([shallow]) == [False]
    assert are_openings([small(window, 0.06), shallow]) == [False, False]  # panels do not prove one another


def test_what_shows_neither_its_frame_nor_most_of_its_borders_is_no_opening_however_like_one(window):
    deep, shallow = small(window, 0.12), small(window, 0.06, dx=1.5)
    unseen = tuple(replace(b, gain=0.0) for b in shallow.borders[:2])
    badly_seen = replace(shallow, borders=(*unseen, *shallow.borders[2:]))
    assert are_openings([deep, badly_seen, replace(shallow, depth=None)]) == [True, False, False]


def empty(outline, dx, dz, *, taller=0.0):
    """Returns the outline, moved, as that of a place behind which nothing shows."""
    return replace(moved(outline, dx, dz, taller=taller), depth=None, behind=0.0)


def test_a_place_that_returned_nothing_is_an_opening_only_if_one_that_shows_its_frame_is_like_it(window):
    beside, above = empty(window, 2.0, 0.0), empty(window, 0.0, 3.0)
    assert are_openings([window, beside, above]) == [True, True, True]
    patch = empty(window, 2.0, -1.6, taller=3.2)  # of another size
    assert are_openings([window, patch]) == [True, False]
    assert are_openings([patch, window]) == [False, True]


def test_a_room_that_shows_without_a_frame_proves_the_opening(window):
    assert are_openings([replace(window, depth=None)]) == [True]


def test_what_is_like_an_empty_opening_is_one_too(window):
    first, second = empty(window, 2.0, 0.0), empty(window, 2.0, 3.0)
    assert are_openings([second, first, window]) == [True, True, True]


def test_where_nothing_shows_behind_any_place_two_alike_tell_each_other(window):
    one, other = empty(window, 0.0, 0.0), empty(window, 2.0, 0.0)
    assert are_openings([one]) == [False]
    assert are_openings([one, other]) == [True, True]
    assert are_openings([one, empty(window, 2.0, -1.6, taller=3.2)]) == [False, False]


def test_a_curved_head_among_more_flat_ones_is_odd(window):
    row = [moved(window, 2.0 * k, 0.0) for k in range(4)]
    round_one = replace(row[1], shape="round", rise=0.6)
    assert odd_heads([row[0], round_one, *row[2:]]) == [1]
    assert odd_heads([round_one]) == []
    unseen = replace(round_one, borders=tuple(replace(b, gain=0.0) for b in round_one.borders))
    assert odd_heads([row[0], unseen, *row[2:]]) == []  # its row completes it
    both = [replace(o, shape="round", rise=0.6) for o in row[:2]]
    assert odd_heads([*both, *row[2:]]) == []  # two of four are none the fewer
    assert odd_heads([round_one, moved(window, 2.0, -1.6, taller=3.2)]) == []  # another size


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ((1.7, 1.0, 2.1, 4.0), False),  # the receding side of a column that stands from 1.2 to 2 m
        ((1.4, 6.0, 1.7, 7.0), True),  # a slot in the wall above
        ((1.3, 1.0, 1.9, 4.0), True),  # as wide as a shop window at the end of a front
    ],
)
def test_slots_at_the_sides_of_columns_have_no_jambs(place, expected):
    ring = np.array([[0, 5], [1.2, 5], [1.2, 0], [2.0, 0], [2.0, 5], [8, 5], [8, 9], [0, 9]], float)
    facade = replace(scan_wall([WINDOW])[0], outline=ring)
    slot = Outline("rectangle", place, 0.0, np.zeros((5, 5)), (), None, 0.0)
    assert have_jambs([slot], facade) == [expected]
