"""Gaps between dormers are open to the sky; openings have something above them."""

from dataclasses import replace

import numpy as np

from frontage.openings import FoundOpenings, find_openings
from openings.boxes import box, scanned
from openings.joinery import framed, holed


def openings_of(solids):
    found = find_openings(*scanned(wall=solids))
    assert isinstance(found, FoundOpenings)
    return [np.concatenate([o.ring.min(0), o.ring.max(0)]) for o in found.openings]


def test_the_gap_between_two_dormers_is_no_opening():
    wall = [box(0, 8, 0.0, 0.3, 0, 6.5), box(0, 3, 0.0, 0.3, 6.5, 9), box(5, 8, 0.0, 0.3, 6.5, 9)]
    attic = box(0, 8, 1.6, 1.9, 6.5, 9.2)
    assert openings_of([*wall, attic]) == []


def test_a_pane_that_reaches_up_to_the_ceiling_of_an_arcade_is_one():
    """The facade ends at the ceiling, as the wall of an arcade does."""
    pane = (3.0, 6.5, 5.0, 9.0)
    wall = holed(0, 8, 0, 9, 0.0, 0.3, [pane])
    ceiling = box(0, 8, -1.5, 0.3, 9.0, 9.3)
    (found,) = openings_of([*wall, *framed(pane, 0.1), ceiling])
    assert np.abs(found - pane).max() < 0.05


def test_a_window_above_which_the_scan_ends_has_the_lintel_of_its_row():
    left, right = (1.5, 6.4, 2.7, 8.3), (5.3, 6.4, 6.5, 8.3)
    solids = [*holed(0, 8, 0, 9, 0.0, 0.3, [left, right]), *framed(left, 0.15), *framed(right, 0.15)]
    facade, scan = scanned(wall=solids)
    seen = np.flatnonzero((scan.xyz[:, 0] < 4.0) | (scan.xyz[:, 2] < 8.2))
    outline = np.array([(0, 0), (8, 0), (8, 8.2), (4, 8.2), (4, 9), (0, 9)])
    cut = replace(facade, outline=outline, support=np.arange(len(seen)), inliers=np.arange(len(seen)))
    found = find_openings(cut, scan.take(seen))
    assert isinstance(found, FoundOpenings)
    places = [np.concatenate([o.ring.min(0), o.ring.max(0)]) for o in found.openings]
    assert len(places) == 2
    assert np.abs(np.subtract(places, [left, right]))[:, :3].max() < 0.05
