"""A flat roof that was scanned from above tells nothing of the openings of the wall before it."""

from dataclasses import replace

import numpy as np

from frontage.model.scan import Scan
from frontage.openings import OpeningOptions, find_openings
from frontage.openings.wall.roofs import roof_level
from fronts import WINDOW, box_of, scan_wall

TOP, ROOF = 5.0, 4.1  # m, heights of the end of the wall and of the roof
PATCH = (4.4, 3.6, 5.6, 4.5)  # of the wall, returned nothing; the roof begins behind it


def roof(level=ROOF, length=7.0):
    """Returns points (n, 3) m of a roof and of the back of the parapet before it."""
    x, y = (m.ravel() for m in np.meshgrid(np.arange(0.0, length, 0.04), np.arange(0.33, 0.99, 0.04)))
    back = np.array(np.meshgrid(np.arange(0.0, length, 0.04), [0.33], np.arange(level, TOP, 0.04)))
    return np.vstack([np.column_stack([x, y, np.full(len(x), level)]), back.reshape(3, -1).T])


def test_the_level_of_a_roof_is_found():
    points = roof()
    assert abs(roof_level(points, points[:, 1], TOP) - ROOF) < 0.21
    assert roof_level(points, points[:, 1], TOP) < ROOF


def test_a_floor_far_below_the_top_and_a_short_surface_are_no_roof():
    floor, short = roof(3.2), roof(length=2.0)
    assert roof_level(floor, floor[:, 1], TOP) == np.inf
    assert roof_level(short, short[:, 1], TOP) < np.inf  # along all that shows
    room = np.vstack([short, [[6.9, 0.2, 3.0]]])
    assert roof_level(room, room[:, 1], TOP) == np.inf


def test_the_back_of_a_parapet_makes_no_window_of_a_patch_that_returned_nothing():
    facade, scan = scan_wall([WINDOW, PATCH], returned=0.0, rays=False)
    pane = (
        np.array(np.meshgrid(np.arange(1.0, 2.2, 0.05), [0.15], np.arange(2.0, 3.6, 0.05))).reshape(3, -1).T
    )
    xyz = np.vstack([scan.xyz, pane, roof()])
    some = np.arange(len(xyz))
    front = replace(facade, support=some, inliers=some)
    found = find_openings(front, Scan("wall", xyz, scan.world), OpeningOptions(ground_z=-5.0))
    (box,) = [box_of(o) for o in found.elements.openings]
    assert np.abs(box - WINDOW).max() < 0.04
