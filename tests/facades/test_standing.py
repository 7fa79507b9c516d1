"""A storey or an annex that stands out from the rest of a front is a facade of its own."""

import numpy as np
import pytest

from facades.test_parts import HIGH, WORLD, surface
from frontage.facades import find_facades
from frontage.model import Building, Facade, Scan

WIDE, STEP, SEAM = 12.0, 0.4, 4.5
WINDOWS = [(1.0, 3.4), (4.8, 7.2), (8.6, 11.0)]


def _facades(parts, axis=2):
    """Returns the facades of surfaces on the ground: low and high along an axis, and depth, in m."""
    rng = np.random.default_rng(0)
    sheets = [surface(rng, *part) for part in parts]
    scan = Scan("front", np.vstack([*sheets, surface(rng, (-3, WIDE + 3), (-6, -0.5), 0.0)]), WORLD)
    facades = find_facades(scan, Building("B01", np.arange(len(scan.xyz)), 0.0))
    assert all(isinstance(f, Facade) for f in facades)
    spans = [f.frame.apply(np.insert(f.outline, 1, 0.0, axis=1)) for f in facades]
    return sorted((p[:, axis].min(), p[:, axis].max(), p[:, 1].mean()) for p in spans)


def _basement(low=0.6, head=4.2):
    """Returns a wall with windows, `STEP` m before the plane of their bars."""
    sides = [0.0, *np.ravel(WINDOWS), WIDE]
    piers = [((a, b), -STEP, (low, head)) for a, b in zip(sides[::2], sides[1::2], strict=True)]
    bars = [((x, x + 0.08), 0.0, (low, head)) for a, b in WINDOWS for x in np.arange(a + 0.5, b, 0.5)]
    around = [((0.0, WIDE), -STEP, span) for span in ((0.0, low), (head, SEAM))]
    jambs = [(x, (-STEP, 0.0), (low, head)) for x in np.ravel(WINDOWS)]
    return [*piers, *bars, *jambs, *around]


def test_a_basement_with_bars_in_the_plane_of_the_wall_above_it_is_a_facade():
    found = _facades([*_basement(), ((0.0, WIDE), (-STEP, 0.0), SEAM), ((0.0, WIDE), 0.0, (SEAM, HIGH))])
    np.testing.assert_allclose(found, [(0.0, SEAM, -STEP), (SEAM, HIGH, 0.0)], atol=0.12)


def test_an_upper_storey_that_juts_out_is_a_facade():
    floor = ((0.0, WIDE), (-STEP, 0.0), 6.0)
    found = _facades([((0.0, WIDE), 0.0, (0.0, 6.0)), floor, ((0.0, WIDE), -STEP, (6.0, HIGH))])
    np.testing.assert_allclose(found, [(0.0, 6.0, 0.0), (6.0, HIGH, -STEP)], atol=0.12)


@pytest.mark.parametrize(
    "before",
    [
        [((0.0, WIDE), -STEP, (3.0, 4.0)), ((0.0, WIDE), -STEP, (6.0, 7.0))],  # parapets
        [((x, x + 0.9), -STEP, (0.0, HIGH)) for x in (1.0, 4.0, 7.0, 10.0)],  # pilasters
        [((4.0, 8.0), -STEP, (0.0, 3.5))],  # a porch
    ],
)
def test_what_stands_before_a_wall_and_is_no_storey_is_none(before):
    found = _facades([((0.0, WIDE), 0.0, (0.0, HIGH)), *before])
    np.testing.assert_allclose(found, [(0.0, HIGH, 0.0)], atol=0.12)


def test_an_annex_whose_door_shows_in_the_plane_of_the_tower_behind_it_is_a_facade():
    piers = [((0.0, 1.0), -STEP, (0.0, 3.0)), ((3.0, 4.0), -STEP, (0.0, 3.0))]
    stiles = [((x, x + 0.08), 0.0, (0.0, 3.0)) for x in (1.2, 1.6, 2.0, 2.4, 2.8)]
    jambs = [(x, (-STEP, 0.0), (0.0, 3.0)) for x in (1.0, 3.0)]
    annex = [*piers, *stiles, *jambs, ((0.0, 4.0), -STEP, (3.0, 5.0)), (4.0, (-STEP, 0.0), (0.0, 5.0))]
    found = _facades([*annex, ((4.0, WIDE), 0.0, (0.0, HIGH))], axis=0)
    np.testing.assert_allclose(found, [(0.0, 4.0, -STEP), (4.0, WIDE, 0.0)], atol=0.15)
