"""The gaps of a balustrade on a wall are no openings; windows with bars of masonry below a wall are."""

from types import SimpleNamespace

import numpy as np

from frontage.openings import FoundOpenings, find_openings
from frontage.openings.balustrades import _is_row_of_posts
from openings.boxes import box, scanned
from openings.joinery import framed, holed

PANE = (3.4, 1.0, 4.6, 2.6)


def openings_of(solids):
    """Returns the boxes x0, z0, x1, z1 m of the openings of a wall 8 m x 9 m, scanned without positions."""
    found = find_openings(*scanned(wall=solids, rays=False))
    assert isinstance(found, FoundOpenings)
    return [np.concatenate([o.ring.min(0), o.ring.max(0)]) for o in found.openings]


def posts(low, high):
    """Returns balusters between three piers, 35 cm apart."""
    between = [x + k * 0.35 for x in (0.4, 4.2) for k in range(1, 10)]
    shafts = [box(x - 0.05, x + 0.05, 0.08, 0.18, low, high) for x in between]
    return [*shafts, *(box(x, x + 0.4, 0.0, 0.3, low, high) for x in (0.0, 3.8, 7.6))]


def test_the_gaps_of_a_balustrade_on_a_wall_are_no_openings():
    wall = holed(0, 8, 0, 7.4, 0.0, 0.3, [PANE])
    (found,) = openings_of([*wall, *framed(PANE, 0.1), *posts(7.4, 8.6), box(0, 8, 0.0, 0.3, 8.6, 9.0)])
    assert np.abs(found - PANE).max() < 0.05


def test_what_stands_below_a_high_wall_is_no_balustrade():
    wall = holed(0, 8, 0, 5.4, 0.0, 0.3, [PANE])
    found = openings_of([*wall, *framed(PANE, 0.1), *posts(5.4, 6.6), box(0, 8, 0.0, 0.3, 6.6, 9.0)])
    assert any(box[1] > 5.0 for box in found)


def test_a_railing_before_a_window_below_the_eaves_is_no_balustrade():
    high = (2.5, 6.1, 5.5, 8.3)
    wall = holed(0, 8, 0, 9.0, 0.0, 0.3, [high])
    bars = [box(x - 0.02, x + 0.02, 0.05, 0.09, 6.1, 7.0) for x in np.arange(2.6, 5.45, 0.12)]
    (found,) = openings_of([*wall, *framed(high, 0.2), *bars])
    assert np.abs(found - high).max() < 0.1


def test_a_row_of_posts_may_be_too_low_for_the_cells_of_a_coarse_scan():
    x, z = np.meshgrid(np.repeat([0.3, 0.7, 1.1, 1.5, 1.9], 6), np.linspace(0.02, 0.38, 4))
    points = np.column_stack([x.ravel(), np.zeros(x.size), z.ravel()])
    beams = SimpleNamespace(points=points, depth_at=lambda x, z: np.zeros(len(x)))
    coarse = SimpleNamespace(beams=beams, facade=SimpleNamespace(spacing=0.105))
    assert _is_row_of_posts(coarse, (0.0, 0.0, 2.2, 0.4))
