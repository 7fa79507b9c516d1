"""Recessed spandrels: walls behind the face of their wall, below windows that are set into them."""

import numpy as np
import pytest

from frontage.openings import find_openings
from frontage.openings.borders.spandrels import spandrel_top
from openings.faces import face, scanned_faces

WIDTH, HEIGHT = 6.0, 6.0
LEFT, RIGHT, FOOT, HEAD = 1.8, 4.2, 1.2, 4.0
BACK, PANE = 0.4, 0.12  # m behind the face of the wall, and behind the spandrel


def _bay(window):
    """A wall with a recess, at whose back a window x0, z0, x1, z1 has a frame, and glass without echo."""
    x0, z0, x1, z1 = window
    sides = [face((x, 0.0), (x, BACK), FOOT, HEAD) for x in (LEFT, RIGHT)]
    ledges = [((LEFT, 0.0, z), (RIGHT - LEFT, 0.0, 0.0), (0.0, BACK, 0.0)) for z in (FOOT, HEAD)]
    jambs = [face((x, BACK), (x, BACK + PANE), z0, z1) for x in (x0, x1)]
    sills = [((x0, BACK, z), (x1 - x0, 0.0, 0.0), (0.0, PANE, 0.0)) for z in (z0, z1)]
    glass = [(0.08, z0 + 0.08, x1 - x0 - 0.08, z1 - 0.08)]
    return [
        *face((0.0, 0.0), (WIDTH, 0.0), 0.0, HEIGHT, holes=[(LEFT, FOOT, RIGHT, HEAD)]),
        *face((LEFT, BACK), (RIGHT, BACK), FOOT, HEAD, holes=[(x0 - LEFT, z0, x1 - LEFT, z1)]),
        *face((x0, BACK + PANE), (x1, BACK + PANE), z0, z1, holes=glass),
        *sides[0], *sides[1], *ledges, *jambs[0], *jambs[1], *sills,
    ]  # fmt: skip


@pytest.mark.parametrize(
    "window",
    [(LEFT + 0.15, 2.1, RIGHT - 0.15, 3.8), (LEFT, 2.1, RIGHT, HEAD)],
    ids=["window with wall around it", "window from side to side"],
)
def test_a_window_above_a_recessed_spandrel_begins_where_the_spandrel_ends(window):
    facade, scan = scanned_faces(_bay(window), (WIDTH, HEIGHT))
    (found,) = find_openings(facade, scan).openings
    np.testing.assert_allclose([*found.ring.min(0), *found.ring.max(0)], window, atol=0.04)


def test_a_panel_in_the_plane_of_the_frame_belongs_to_its_opening():
    # the lower part of a shop front: frame and panel lie in one plane
    pane = (0.1, 2.1, RIGHT - LEFT - 0.1, HEAD - 0.1)
    wall = face((0.0, 0.0), (WIDTH, 0.0), 0.0, HEIGHT, holes=[(LEFT, FOOT, RIGHT, HEAD)])
    front = face((LEFT, 0.2), (RIGHT, 0.2), FOOT, HEAD, holes=[pane])
    facade, scan = scanned_faces([*wall, *front], (WIDTH, HEIGHT))
    (found,) = find_openings(facade, scan).openings
    np.testing.assert_allclose([*found.ring.min(0), *found.ring.max(0)], [LEFT, FOOT, RIGHT, HEAD], atol=0.04)


@pytest.mark.parametrize(("height", "due"), [(0.05, 10.0), (2.0, 0.0), (2.0, 1.0)])
def test_without_rows_or_beams_nothing_is_told(height, due):
    z = np.linspace(0.0, 0.7, 6) * min(height, 1.0)
    assert spandrel_top(z, np.full(6, 0.3), height, 0.003, due) is None
