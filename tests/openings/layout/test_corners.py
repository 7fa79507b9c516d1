"""Windows at the end of a facade, where there is no wall on one side."""

import numpy as np
import pytest

from frontage.openings import FoundOpenings, find_openings
from openings.boxes import SIZE, scanned
from openings.joinery import framed, wall


@pytest.mark.parametrize("above", [True, False])
def test_a_window_may_go_round_the_corner_of_a_house_below_wall(above):
    hole = (0.0, 3.0, 3.0, 4.4 if above else SIZE[1])
    found = find_openings(*scanned(wall=[*wall([hole]), *framed((0.0, 3.0, 3.0, 4.4), 0.15)]))
    assert isinstance(found, FoundOpenings)
    places = [[*o.ring.min(0), *o.ring.max(0)] for o in found.openings]
    assert len(places) == above  # without wall above it, it may be the end of a lower house
    assert np.abs(np.array(places) - [hole] * above).max(initial=0.0) < 0.05
