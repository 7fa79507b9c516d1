"""Windows below a band without returns, such as the gap that a sign board leaves when it is cut out."""

import numpy as np
import pytest

from frontage.openings import FoundOpenings, find_openings
from openings.boxes import box, scanned, with_points

COLUMNS = ((0.6, 2.8), (3.3, 4.8), (5.3, 7.4))  # x0, x1 m of panes that return every beam
BAND = (0.3, 7.7)  # x0, x1 m where the wall returns nothing
PANE = 0.13  # m behind the wall


def shops(foot, head, high):
    """A wall with panes between two heights m, its scan, and the points that a band above them keeps."""
    x = [0.0, *np.ravel(COLUMNS), 8.0]
    wall = [box(a, b, 0.0, 0.3, foot, head) for a, b in zip(x[::2], x[1::2], strict=True)]
    wall += [box(0.0, 8.0, 0.0, 0.3, 0.0, foot), box(0.0, 8.0, 0.0, 0.3, head, 9.0)]
    wall += [box(0.0, 8.0, PANE, 0.3, foot, head)]
    facade, scan = scanned(wall=wall, rays=False, spacing=0.05)
    x, _, z = scan.xyz.T
    return facade, scan, (x < BAND[0]) | (x > BAND[1]) | (z < head) | (z > head + high)


@pytest.mark.parametrize(("foot", "head"), [(4.0, 6.0), (1.0, 3.6)])
def test_windows_end_below_a_band_that_runs_on_beyond_their_jambs(foot, head):
    found = find_openings(*with_points(*shops(foot, head, high=1.2)))
    assert isinstance(found, FoundOpenings)
    boxes = sorted((*o.ring.min(0), *o.ring.max(0)) for o in found.openings)
    assert np.array(boxes) == pytest.approx(np.array([(a, foot, b, head) for a, b in COLUMNS]), abs=0.1)


def test_without_a_band_they_end_at_the_same_heights():
    facade, scan, _ = shops(4.0, 6.0, high=1.2)
    found = find_openings(facade, scan)
    assert isinstance(found, FoundOpenings)
    boxes = sorted((*o.ring.min(0), *o.ring.max(0)) for o in found.openings)
    assert np.array(boxes) == pytest.approx(np.array([(a, 4.0, b, 6.0) for a, b in COLUMNS]), abs=0.05)
