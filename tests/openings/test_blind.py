"""Niches closed by what the wall consists of are no openings; closed shutters are, and so are windows."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.openings import FoundOpenings, find_openings
from openings.boxes import box, scanned
from openings.joinery import framed, holed

PLACE = (2.5, 3.0, 3.7, 5.0)
BRICK, GREY, GREEN = (170, 120, 100), (150, 150, 150), (90, 140, 100)


def found_in(solids, wall, leaf, *, strength=None):
    """The openings (k, 4) m of a wall where what lies 5 to 20 cm behind it has the colour of the leaf.

    `strength` is the intensity of the leaf, where that of the wall is 0.5.
    """
    facade, scan = scanned(wall=solids)
    rng, behind = np.random.default_rng(3), (scan.xyz[:, 1] > 0.05) & (scan.xyz[:, 1] < 0.2)
    colour = np.where(behind[:, None], leaf, wall) + rng.normal(0, 6, (len(behind), 3))
    scan = replace(scan, rgb=np.clip(colour, 0, 255).astype(np.uint8))
    if strength is not None:
        told = np.where(behind, strength, 0.5) * rng.lognormal(0, 0.05, len(behind))
        scan = replace(scan, intensity=told.astype(np.float32))
    found = find_openings(facade, scan)
    assert isinstance(found, FoundOpenings)
    return [np.concatenate([o.ring.min(0), o.ring.max(0)]) for o in found.openings]


def niche(depth=0.12):
    x0, z0, x1, z1 = PLACE
    return [*holed(0, 8.0, 0, 9.0, 0.0, 0.3, [PLACE]), box(x0, x1, depth, depth + 0.1, z0, z1)]


@pytest.mark.parametrize("depth", [0.08, 0.12, 0.18])
def test_a_bricked_up_window_is_none(depth):
    assert not found_in(niche(depth), BRICK, BRICK)


def test_a_closed_shutter_is_a_window():
    (place,) = found_in(niche(), BRICK, GREEN)
    assert np.abs(place - PLACE).max() < 0.02


@pytest.mark.parametrize(("strength", "number"), [(None, 1), (0.3, 1), (0.5, 0)])
def test_on_a_grey_wall_intensity_must_tell_as_well(strength, number):
    assert len(found_in(niche(), GREY, GREY, strength=strength)) == number


def test_a_window_above_a_sunk_panel_ends_at_its_sill():
    x0, _, x1, z1 = PLACE
    window, both = (x0, 4.0, x1, z1), (x0, 3.0, x1, z1)
    panel, sill = box(x0, x1, 0.09, 0.3, 3.0, 3.96), box(x0, x1, -0.04, 0.3, 3.96, 4.0)
    solids = [*holed(0, 8.0, 0, 9.0, 0.0, 0.3, [both]), *framed(window, 0.25), panel, sill]
    (place,) = found_in(solids, BRICK, BRICK)
    assert np.abs(place - window).max() < 0.05


def test_a_door_of_the_colour_of_the_wall_is_a_door():
    x0, x1 = PLACE[0], PLACE[2]
    solids = [*holed(0, 8.0, 0, 9.0, 0.0, 0.3, [(x0, 0.0, x1, 2.2)]), box(x0, x1, 0.12, 0.2, 0.0, 2.2)]
    (place,) = found_in(solids, BRICK, BRICK)
    assert np.abs(place - (x0, 0.0, x1, 2.2)).max() < 0.06
