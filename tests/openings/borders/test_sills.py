"""Weathered sills: masonry that rises from the face of the wall to the pane belongs to the wall."""

import numpy as np
import pytest

from frontage.openings import find_openings
from openings.faces import face, scanned_faces

WIDTH, HEIGHT = 6.0, 6.0
LEFT, RIGHT, FOOT, HEAD = 2.0, 4.0, 1.2, 4.8
PANE = 0.3  # m behind the wall


def _window(end):
    """A wall with a window whose sill rises from the foot to the pane up to the height `end` m."""
    slope = ((LEFT, 0.0, FOOT), (RIGHT - LEFT, 0.0, 0.0), (0.0, PANE, end - FOOT))
    reveals = [face((x, 0.0), (x, PANE), FOOT, HEAD) for x in (LEFT, RIGHT)]
    head = ((LEFT, 0.0, HEAD), (RIGHT - LEFT, 0.0, 0.0), (0.0, PANE, 0.0))
    wall = face((0.0, 0.0), (WIDTH, 0.0), 0.0, HEIGHT, holes=[(LEFT, FOOT, RIGHT, HEAD)])
    return [*wall, *reveals[0], *reveals[1], head, slope, *face((LEFT, PANE), (RIGHT, PANE), end, HEAD)]


@pytest.mark.parametrize(("end", "foot"), [(2.2, 2.2), (FOOT + 0.02, FOOT)], ids=["weathered sill", "slab"])
def test_an_opening_begins_where_its_sill_ends(end, foot):
    facade, scan = scanned_faces(_window(end), (WIDTH, HEIGHT))
    (window,) = find_openings(facade, scan).openings
    low, high = window.ring.min(0), window.ring.max(0)
    np.testing.assert_allclose([*low, *high], [LEFT, foot, RIGHT, HEAD], atol=0.03)
