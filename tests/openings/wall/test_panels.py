"""Shutters that are partly down belong to their window; panels between windows are wall."""

import numpy as np
import pytest

from frontage.openings import FoundOpenings, find_openings
from openings.boxes import box, scanned
from openings.joinery import framed, holed

WINDOW = (2.5, 2.0, 4.1, 3.8)
DEEP = 0.05


def found_in(solids, **how):
    found = find_openings(*scanned(wall=solids, **how))
    assert isinstance(found, FoundOpenings)
    return [np.concatenate([o.ring.min(0), o.ring.max(0)]) for o in found.openings]


def shuttered(share):
    """A window with a shutter over this share of its height."""
    x0, z0, x1, z1 = WINDOW
    shutter = box(x0, x1, DEEP, DEEP + 0.015, z1 - share * (z1 - z0), z1)
    return [*holed(0, 8.0, 0, 9.0, 0.0, 0.3, [WINDOW]), *framed(WINDOW, 0.15), shutter]


@pytest.mark.parametrize("share", [0.25, 0.5, 0.75])
@pytest.mark.parametrize("rays", [True, False])
def test_a_shutter_that_is_partly_down_belongs_to_its_window(share, rays):
    (place,) = found_in(shuttered(share), rays=rays)
    assert np.abs(place - WINDOW).max() < 0.01


def test_a_panel_between_two_windows_is_wall():
    low, high = (2.5, 1.0, 4.1, 2.4), (2.5, 3.4, 4.1, 4.8)
    strip = (2.5, 1.0, 4.1, 4.8)
    panel = box(2.5, 4.1, DEEP, 0.3, 2.4, 3.4)
    solids = [*holed(0, 8.0, 0, 9.0, 0.0, 0.3, [strip]), *framed(low, 0.15), *framed(high, 0.15), panel]
    places = found_in(solids)
    assert len(places) == 2 and np.abs(np.array(places) - [low, high]).max() < 0.03


def test_a_panel_wider_than_the_window_below_it_is_wall():
    recess, window = (2.0, 2.0, 4.6, 3.8), (2.5, 1.0, 4.1, 2.0)
    panel = box(2.0, 4.6, DEEP, 0.3, 2.0, 3.8)
    solids = [
        *holed(0, 8.0, 2.0, 9.0, 0.0, 0.3, [recess]),
        *holed(0, 8.0, 0.0, 2.0, 0.0, 0.3, [window]),
        *framed(window, 0.15),
        panel,
    ]
    (place,) = found_in(solids)
    assert np.abs(place - window).max() < 0.05
