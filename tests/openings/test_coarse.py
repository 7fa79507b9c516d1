"""Openings in coarse clouds, and in clouds that do not know where they were measured from."""

import numpy as np
import pytest

from frontage.model.opening import Elements
from frontage.openings.find import find_openings
from fronts import box_of, scan_wall


def boxes_in(facade, scan):
    found = find_openings(facade, scan)
    assert isinstance(found, Elements)
    return np.array(
        sorted((box_of(o).tolist() for o in found.openings), key=lambda b: (round(b[0]), b[1]))
    ).reshape(-1, 4)


@pytest.mark.parametrize("rays", [True, False])
def test_windows_of_few_cells_are_found_whole(rays):
    holes = np.array([(x, z, x + 1.1, z + 1.4) for x in (1.0, 3.1, 5.2, 7.3) for z in (1.0, 3.9, 6.8)])
    found = boxes_in(*scan_wall(holes, spacing=0.08, returned=0.1, rays=rays, size=(9.5, 9.0)))
    assert found.shape == holes.shape
    assert np.abs(found - holes).max() < 0.12
