"""A car hides the lower part of a ground floor: doors behind it stay doors, windows stay windows."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from frontage.openings import FoundOpenings, find_openings
from frontage.openings.hidden import is_foot_unknown, judge_foot, lowest_foot
from frontage.openings.wall.raster import WallRaster
from openings.faces import face, scanned_faces
from openings.fronts import outline

SIZE, DEPTH, SILL, TOP = (12.0, 6.0), 0.12, 0.95, 2.3
AXES = (1.5, 4.0, 6.5, 9.0)  # m, left borders
WINDOW, DOOR = 1.2, 1.0  # m wide
CAR = (6.0, 10.0, 1.45)  # x0, x1, height m: before the third and the fourth opening
EYE = ((7.5, -9.0, 1.9),)


def window(x, sill=SILL):
    """Frame, cross and room of a window whose panes let beams through; its hole."""
    x1 = x + WINDOW
    strips = [(x, x + 0.07, sill, TOP), (x1 - 0.07, x1, sill, TOP), (x + 0.57, x + 0.63, sill, TOP)]
    strips += [(x, x1, sill, sill + 0.07), (x, x1, TOP - 0.07, TOP)]
    parts = [p for a, b, c, d in strips for p in face((a, DEPTH), (b, DEPTH), c, d)]
    return [*parts, *face((x, 3.0), (x1, 3.0), 0.0, 3.0)], (x, sill, x1, TOP)


def door(x):
    """The leaf of a door, and its hole."""
    return face((x, DEPTH + 0.06), (x + DOOR, DEPTH + 0.06), 0.0, 2.2), (x, 0.03, x + DOOR, 2.2)


def street(*openings, car=True, sight=True):
    """The openings from left to right of a wall with a car before it, with or without lines of sight."""
    parts, holes = zip(*openings, strict=True)
    faces = [*face((0, 0), (SIZE[0], 0), 0.0, SIZE[1], holes), *(f for own in parts for f in own)]
    if car:
        faces += face((CAR[0], -2.6), (CAR[1], -2.6), 0.0, CAR[2])
    facade, scan = scanned_faces(faces, SIZE, spacing=0.03, eyes=EYE)
    if not sight:
        scan = replace(scan, origins=np.empty((0, 3)), origin_index=np.full(len(scan), -1, np.int32))
    found = find_openings(facade, scan)
    assert isinstance(found, FoundOpenings)
    return sorted(found.openings, key=lambda o: o.ring[:, 0].min())


def foot(opening):
    """The lower border of an opening, and its standard error, m."""
    lowest = int(np.argmin(opening.ring[:, 1]))
    return float(opening.ring[lowest, 1]), float(
        np.sqrt(opening.ring_covariance[2 * lowest + 1, 2 * lowest + 1])
    )


def test_a_door_behind_a_car_is_a_door_down_to_the_ground():
    found = street(window(AXES[0]), window(AXES[1]), window(AXES[2]), door(AXES[3]))
    assert [o.kind for o in found] == ["window", "window", "window", "door"]
    at, sigma = foot(found[3])
    assert 0.02 < sigma < 0.4 and abs(at - 0.03) < 3 * sigma
    assert found[3].ring[:, 1].max() == pytest.approx(2.2, abs=0.03)


def test_windows_behind_a_car_have_the_sills_of_their_row():
    found = street(*(window(x) for x in AXES))
    assert [o.kind for o in found] == ["window"] * 4
    for hidden in found[2:]:
        at, sigma = foot(hidden)
        assert 0.005 < sigma < 0.4 and abs(at - SILL) < 3 * sigma


def test_what_nothing_hides_is_measured_and_not_judged():
    found = street(window(AXES[0]), window(AXES[1], 0.6), window(AXES[2]), door(AXES[3]), car=False)
    assert [o.kind for o in found] == ["window", "window", "window", "door"]
    assert [foot(o)[0] for o in found[:3]] == pytest.approx([SILL, 0.6, SILL], abs=0.02)


def test_feet_behind_a_car_are_judged_without_lines_of_sight():
    found = street(window(AXES[0]), window(AXES[1]), window(AXES[2]), door(AXES[3]), sight=False)
    assert [o.kind for o in found] == ["window", "window", "window", "door"]
    at, sigma = foot(found[2])
    assert abs(at - SILL) < 3 * sigma < 1.0
    at, sigma = foot(found[3])
    assert abs(at - 0.03) < 3 * sigma < 1.0


def dark(wall=0.0, posts=True):
    """Evidence without lines of sight on a wall 5 m wide: nothing came back from 9 to 10 m above `wall` m.

    Two posts stand there, up to 1.2 m, and the opening is seen above that.
    """
    raster = WallRaster((8.0, -0.5), 0.05, (80, 60))
    x, z = (v.reshape(raster.shape) for v in raster.middles(np.ones(raster.shape, np.bool_)).T)
    seen = (x < 9.0) | (x > 10.0) | (z < wall) | (z > 2.2)
    post = ~seen & posts & (z < 1.2) & ((np.abs(x - 9.3) < 0.06) | (np.abs(x - 9.7) < 0.06))
    llr = np.where(seen | post, -4.0, 0.5)
    return SimpleNamespace(raster=raster, llr=llr, seen=seen | post, rays=False)


def test_posts_before_the_hidden_foot_of_a_door_are_no_wall():
    row = [outline((4.0, SILL, 5.2, TOP), 0.005), outline((6.5, SILL, 7.7, TOP), 0.005)]
    judged = judge_foot(outline((9.0, 1.2, 10.0, 2.2), 0.3), row, None, dark(), 0.0, 0.0)
    assert (judged.kind, judged.at) == ("door", pytest.approx(0.1, abs=0.1))


@pytest.mark.parametrize(
    ("wall", "sigma", "unknown"), [(-1.0, 0.15, True), (0.4, 0.15, False), (-1.0, 0.05, False)]
)
def test_a_foot_without_wall_below_it_is_unknown_unless_its_row_tells_it_well(wall, sigma, unknown):
    borders = tuple(SimpleNamespace(is_seen=seen) for seen in (True, True, False, True))
    opening = replace(outline((9.0, 0.5, 10.0, 2.2), (0.01, 0.01, sigma, 0.01)), borders=borders)
    assert is_foot_unknown(opening, [], dark(wall, posts=False), 0.0) == unknown


def test_no_foot_lies_below_the_top_of_the_opening_under_it():
    upper, lower = outline((0.0, 2.0, 1.0, 4.0), 0.01), outline((0.2, -1.0, 0.8, 0.5), 0.01)
    beside = outline((1.5, 0.0, 2.5, 1.5), 0.01)
    assert lowest_foot(upper, [lower, beside], -2.0) == 0.5
    assert lowest_foot(upper, [beside], -2.0) == -2.0
    assert lowest_foot(lower, [upper], -2.0) == -2.0
