"""Slats level with the wall part a louvre, which is one opening; nothing else is taken for slats."""

import numpy as np
import pytest

from frontage.openings import FoundOpenings, find_openings
from frontage.openings.wall.slats import _continued, _Slat
from openings.boxes import box, scanned

LEFT, RIGHT, SILL, HEAD = 3.2, 4.8, 3.0, 5.9
BACK = 0.9  # m behind the wall


def with_slats(slats):
    """Returns a wall at y = 0 with an opening, and in it `slats` (z0, z1) m at the wall's own depth."""
    around = [box(0.0, LEFT, 0.0, 0.4, 0.0, 9.0), box(RIGHT, 8.0, 0.0, 0.4, 0.0, 9.0)]
    around += [box(LEFT, RIGHT, 0.0, 0.4, 0.0, SILL), box(LEFT, RIGHT, 0.0, 0.4, HEAD, 9.0)]
    return [*around, *(box(LEFT, RIGHT, 0.0, 0.1, *s) for s in slats), box(0.0, 8.0, BACK, 1.0, 0.0, 9.0)]


@pytest.mark.parametrize("rays", [True, False])
def test_a_louvre_is_one_opening(rays):
    starts = SILL + 0.25 + 0.38 * np.arange(7)
    facade, scan = scanned(wall=with_slats([(z, z + 0.14) for z in starts]), rays=rays, spacing=0.02)
    found = find_openings(facade, scan)
    assert isinstance(found, FoundOpenings)
    (louvre,) = found.openings
    assert (
        np.abs([*louvre.ring.min(0), *louvre.ring.max(0)] - np.array([LEFT, SILL, RIGHT, HEAD])).max() < 0.03
    )


@pytest.mark.parametrize("rays", [True, False])
def test_what_sits_on_the_slats_leaves_one_opening(rays):
    starts = SILL + 0.25 + 0.38 * np.arange(7)
    wall = with_slats([(z, z + 0.14) for z in starts])
    chips = zip(3.3 + 0.2 * np.arange(7), starts, strict=True)
    wall += [box(3.6, 4.1, 0.0, 0.1, starts[5] + 0.13, starts[5] + 0.37)]
    wall += [box(x, x + 0.12, 0.0, 0.1, z + 0.13, z + 0.18) for x, z in chips]
    facade, scan = scanned(wall=wall, rays=rays, spacing=0.02)
    found = find_openings(facade, scan)
    assert isinstance(found, FoundOpenings)
    (louvre,) = found.openings
    assert (
        np.abs([*louvre.ring.min(0), *louvre.ring.max(0)] - np.array([LEFT, SILL, RIGHT, HEAD])).max() < 0.03
    )


@pytest.mark.parametrize("rays", [True, False])
def test_masonry_between_windows_is_no_slat(rays):
    bands = [(SILL + 0.7, SILL + 1.1), (SILL + 1.8, SILL + 2.2)]
    facade, scan = scanned(wall=with_slats(bands), rays=rays, spacing=0.02)
    found = find_openings(facade, scan)
    assert isinstance(found, FoundOpenings)
    assert len(found.openings) == 3


def test_slats_as_thick_as_their_pitch_continue_no_stack():
    stack = [_Slat(r0, r0 + 2, 0, 9) for r0 in (4, 9, 14)] + [_Slat(19, 26, 0, 9)]
    assert _continued(stack, np.zeros((40, 9), np.bool_)) == stack
