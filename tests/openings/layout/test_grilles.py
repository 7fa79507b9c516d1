"""Windows behind grilles: beams so dense that they follow the bars, sensors unknown."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.openings import find_openings
from fronts import EYE, box_of, scan_wall

SIZE = (6.0, 4.0)
WINDOWS = [(x, 0.8, x + 1.0, 2.2) for x in (0.8, 2.5, 4.2)]


def behind_bars(scan, box, gap):
    """The scan with upright bars of 2 cm level with the wall before a pane."""
    x, z = scan.xyz[:, 0] - box[0], scan.xyz[:, 2] - box[1]
    inside = (x > 0) & (x < box[2] - box[0]) & (z > 0) & (z < box[3] - box[1])
    bars = inside & (np.mod(x + 0.5 * gap, gap) < 0.02)
    xyz = scan.xyz.copy()
    xyz[bars] -= (xyz[bars] - EYE) * (xyz[bars, 1] / (xyz[bars, 1] - EYE[1]))[:, None]
    return replace(scan, xyz=xyz)


@pytest.mark.parametrize("gap", [0.1, 0.13])
def test_a_window_behind_bars_is_one_opening(gap):
    facade, scan = scan_wall(WINDOWS, spacing=0.01, size=SIZE, depth=0.12, rays=False)
    for box in WINDOWS:
        scan = behind_bars(scan, box, gap)
    found = np.array([box_of(o) for o in find_openings(facade, scan).openings])
    assert len(found) == len(WINDOWS)
    for box in WINDOWS:
        assert np.abs(found - box).max(1).min() < 0.08  # a bar beside a jamb looks like one


@pytest.mark.parametrize("gap", [0.1, 0.13])
def test_a_window_with_a_railing_before_its_lower_part_is_one_opening(gap):
    facade, scan = scan_wall(WINDOWS, spacing=0.01, size=SIZE, depth=0.12, rays=False)
    for x0, z0, x1, _ in WINDOWS:
        scan = behind_bars(scan, (x0, z0, x1, z0 + 0.55), gap)
        scan = behind_bars(scan, (x0, z0 + 0.5, x1, z0 + 0.55), 0.02)  # the handrail
    found = np.array([box_of(o) for o in find_openings(facade, scan).openings])
    assert len(found) == len(WINDOWS)
    for box in WINDOWS:
        assert np.abs(found - box).max(1).min() < 0.08
