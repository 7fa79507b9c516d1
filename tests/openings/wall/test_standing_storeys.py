"""A storey that stands out, whose window bars happen to lie in the plane of the facade, keeps its windows."""

import numpy as np

from frontage.openings import FoundOpenings, find_openings
from openings.boxes import SIZE, box, scanned
from openings.joinery import framed, holed

UPPER = (3.2, 6.0, 4.8, 8.0)
LOWER = (2.2, 0.8, 5.8, 3.9)


def storeys(bars):
    """Returns an upper wall at y = 0, a lower one 36 cm before it, and bars of its window in that plane."""
    upper = holed(0, SIZE[0], 5.2, SIZE[1], 0.0, 0.3, [UPPER])
    lower = holed(0, SIZE[0], 0, 5.2, -0.36, 0.0, [LOWER])
    mullions = [box(x - 0.06, x + 0.06, 0.0, 0.05, LOWER[1], LOWER[3]) for x in bars]
    rails = [box(LOWER[0], LOWER[2], 0.0, 0.05, z - 0.05, z + 0.05) for z in (0.85, 2.6, 3.85)]
    return [*upper, *framed(UPPER, 0.2), *lower, *mullions, *rails]


def test_a_window_whose_bars_lie_in_the_plane_of_the_storey_above_is_found():
    found = find_openings(*scanned(wall=storeys(np.arange(2.26, 5.8, 0.58)), rays=False, spacing=0.025))
    assert isinstance(found, FoundOpenings)
    rings = [np.concatenate([o.ring.min(0), o.ring.max(0)]) for o in found.openings]
    for true in (UPPER, LOWER):
        assert min(np.abs(ring - true).max() for ring in rings) < 0.12
    assert len(rings) == 2
