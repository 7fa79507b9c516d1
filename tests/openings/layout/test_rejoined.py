"""A handrail before a tall window parts no opening, and half a brick of wall does."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.openings.layout.candidates import find_boxes
from frontage.openings.layout.framing import Framing
from frontage.openings.options import OpeningOptions
from frontage.openings.wall.beams import sort_beams
from frontage.openings.wall.evidence import Evidence, weigh
from openings.boxes import scanned
from openings.joinery import framed, wall

WINDOW = (2.0, 2.0, 4.9, 4.1)
RAIL = 3.0  # m, height of its lower side


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    facade, scan = scanned(wall=[*wall([WINDOW]), *framed(WINDOW, 0.2)], spacing=0.015)
    return weigh(facade, sort_beams(facade, scan))


def _with_rail(evidence: Evidence, rows: int) -> Evidence:
    """The evidence with `rows` of cells of a rail across the window, whose shadow tells little beside it."""
    llr, low = evidence.llr.copy(), round((RAIL - evidence.raster.corner[1]) / evidence.raster.cell)
    left, right = (round((x - evidence.raster.corner[0]) / evidence.raster.cell) for x in WINDOW[::2])
    llr[low - 2 : low + rows + 2, left:right] = 0.3
    llr[low : low + rows, left:right] = -6.0
    return replace(evidence, llr=llr)


@pytest.mark.parametrize("thick", [0.06, 0.12])
def test_only_a_band_as_thick_as_half_a_brick_parts_an_opening(evidence, thick):
    seen = _with_rail(evidence, round(thick / evidence.raster.cell))
    found = find_boxes(seen, OpeningOptions(), Framing(seen, 0.0))
    places = np.array([evidence.raster.box(b.r0, b.c0, b.r1, b.c1) for b in found])
    assert len(places) == (1 if thick < 0.1 else 2)
    whole = [*places.min(0)[:2], *places.max(0)[2:]]
    np.testing.assert_allclose(whole, WINDOW, atol=0.08)
