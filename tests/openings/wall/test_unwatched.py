"""Empty areas that are larger than an opening: what hides the wall, and the gates whose feet it hides."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.openings import OpeningOptions, find_openings
from fronts import box_of, scan_wall

GATE = (6.0, 0.0, 9.0, 4.5)
HEAD = 0.6  # m, the height of the part of the gate that returns beams


@pytest.mark.parametrize("rays", [True, False])
@pytest.mark.parametrize("high", [1.0, 2.0])
def test_a_gate_is_as_high_as_its_jambs_show(rays, high):
    """Cars that are missing from the scan hide the foot of the wall; only the head of the gate shows."""
    cars = (1.0, 0.0, 14.0, high)
    facade, scan = scan_wall([GATE, cars], spacing=0.03, rays=rays, returned=0.5, size=(16.0, 7.0))
    kept = np.flatnonzero((scan.xyz[:, 1] < 0.02) | (scan.xyz[:, 2] > GATE[3] - HEAD))
    facade = replace(facade, support=np.arange(len(kept)), inliers=np.arange(len(kept)))
    (gate,) = find_openings(facade, scan.take(kept), OpeningOptions(ground_z=-0.2)).openings
    x0, z0, x1, z1 = box_of(gate)
    np.testing.assert_allclose((x0, x1, z1), (GATE[0], GATE[2], GATE[3]), atol=0.03)
    assert z0 < high + 0.1


def test_a_tall_window_is_open_on_both_sides_of_its_mullion():
    """Panes return nothing, and neither does a part of the mullion: the empty areas beside it are one."""
    hole = (2.0, 1.0, 3.5, 7.8)
    facade, scan = scan_wall([hole], depth=0.3, rays=False, size=(6.0, 9.0))
    x, y, z = scan.xyz.T
    mullion = (np.abs(x - 2.75) < 0.06) & ((z < 3.0) | (z > 3.8))
    kept = np.flatnonzero((y < 0.02) | mullion)
    facade = replace(facade, support=np.arange(len(kept)), inliers=np.arange(len(kept)))
    (window,) = find_openings(facade, scan.take(kept), OpeningOptions(ground_z=-0.2)).openings
    np.testing.assert_allclose(box_of(window), hole, atol=0.03)
