"""Windows at the end of a facade, where there is no wall on one side."""

from itertools import pairwise

import numpy as np
import pytest

from frontage.openings import FoundOpenings, OpeningOptions, find_openings
from openings.boxes import SIZE, box, scanned
from openings.joinery import framed, wall


@pytest.mark.parametrize("above", [True, False])
def test_a_window_may_go_round_the_corner_of_a_house_below_wall(above):
    hole = (0.0, 3.0, 3.0, 4.4 if above else SIZE[1])
    found = find_openings(*scanned(wall=[*wall([hole]), *framed((0.0, 3.0, 3.0, 4.4), 0.15)]))
    assert isinstance(found, FoundOpenings)
    places = [[*o.ring.min(0), *o.ring.max(0)] for o in found.openings]
    assert len(places) == above  # without wall above it, it may be the end of a lower house
    assert np.abs(np.array(places) - [hole] * above).max(initial=0.0) < 0.05


def test_gaps_between_pinnacles_on_a_wall_are_no_openings():
    top = 8.4
    teeth = [box(x, x + 0.3, 0.0, 0.3, top, SIZE[1]) for x in np.arange(0.0, SIZE[0], 1.1)]
    roof = [box(0.0, SIZE[0], 0.6, 0.9, top, SIZE[1])]
    facade, scan = scanned(wall=[box(0.0, SIZE[0], 0.0, 0.3, 0.0, top), *teeth, *roof], rays=False)
    found = find_openings(facade, scan, OpeningOptions(ground_z=0.0))
    assert isinstance(found, FoundOpenings) and not found.openings


@pytest.mark.parametrize("beside", [0.0, 0.02])
def test_windows_up_to_an_inner_corner_are_found_without_lines_of_sight(beside):
    windows = [(x0, z0, x0 + 1.2, z0 + 2.2) for x0 in (2.0, SIZE[0] - 1.2 - beside) for z0 in (2.0, 5.2)]
    x = sorted({0.0, SIZE[0], *(v for w in windows for v in (w[0], w[2]))})
    z = sorted({0.0, SIZE[1], *(v for w in windows for v in (w[1], w[3]))})
    cells = [(a, b, c, d) for a, b in pairwise(x) for c, d in pairwise(z)]
    faces = [box(a, b, 0.0, 0.3, c, d) for a, b, c, d in cells if (a, c, b, d) not in windows]
    frames = [box(x0, x1, 0.1, 0.3, z1 - 0.1, z1) for x0, _, x1, z1 in windows]
    corner = box(SIZE[0] - 0.005, SIZE[0] + 0.3, -6.0, 0.3, 0.0, SIZE[1])
    facade, scan = scanned(wall=[*faces, *frames, corner], rays=False, spacing=0.02, eyes=((2.0, -4.0, 4.0),))
    found = find_openings(facade, scan, OpeningOptions(ground_z=0.0))
    assert isinstance(found, FoundOpenings)
    places = sorted((*o.ring.min(0).round(1), *o.ring.max(0).round(1)) for o in found.openings)
    assert np.allclose(places, sorted(windows), atol=0.05)


def test_what_stands_on_a_roof_between_posts_is_no_opening():
    top = 6.0
    posts = [box(x, x + 0.3, 0.0, 0.3, top, 7.2) for x in (0.5, 2.9)]
    tower = box(3.5, SIZE[0], 0.0, 0.3, top, SIZE[1])  # the facade goes on above the roof
    behind = box(0.8, 2.9, 0.5, 0.6, top, 7.0)
    faces = [box(0.0, SIZE[0], 0.0, 0.3, 0.0, top), *posts, tower, behind]
    found = find_openings(*scanned(wall=faces, rays=False), OpeningOptions(ground_z=0.0))
    assert isinstance(found, FoundOpenings) and not found.openings
