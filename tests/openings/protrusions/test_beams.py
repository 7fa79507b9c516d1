"""Beams before a wall are found by their place, steep ones included."""

import numpy as np
import pytest

from frontage.openings.protrusions.beams import FacadeBeams


@pytest.mark.parametrize("box", [(4.0, 2.0, 6.0, 3.0), (-5.0, 4.0, 15.0, 4.1), (4.0, -5.0, 4.1, 15.0)])
@pytest.mark.parametrize("depth", [-1.2, 0.0, 0.7])
def test_the_beams_through_a_box_are_those_that_cross_its_plane_there(box, depth):
    rng = np.random.default_rng(5)
    q = rng.uniform((-1.0, -2.0, -1.0), (11.0, 1.0, 9.0), (4000, 3)).T
    slope = rng.standard_cauchy((2, 4000))
    slope[:, :500] = 0.0
    places, depths = FacadeBeams(q, slope).at(depth, box, 0.2)
    x, z = q[::2] + slope * (depth - q[1])
    on = (x >= box[0] - 0.2) & (x <= box[2] + 0.2) & (z >= box[1] - 0.2) & (z <= box[3] + 0.2)
    assert 20 < on.sum() < 1000
    np.testing.assert_array_equal(places, np.column_stack([x[on], z[on]]))
    np.testing.assert_array_equal(depths, q[1, on])
