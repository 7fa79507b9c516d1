"""Layouts of several rasters: what most of them show counts, wherever the borders of their cells lie."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.openings import FoundOpenings, find_openings
from frontage.openings.layout.rasters import find_on_rasters
from frontage.openings.options import OpeningOptions
from frontage.openings.wall.beams import sort_beams
from frontage.openings.wall.evidence import Evidence, weigh
from openings.boxes import scanned
from openings.joinery import framed, wall

LEFT, RIGHT = (2.0, 2.0, 3.0, 3.6), (3.4, 2.0, 4.4, 3.6)  # with a narrow pier between them


@pytest.fixture(scope="module")
def evidences() -> list[Evidence]:
    boxes = [*wall([LEFT, RIGHT]), *framed(LEFT, 0.15), *framed(RIGHT, 0.15)]
    facade, scan = scanned(wall=boxes, spacing=0.03)
    beams = sort_beams(facade, scan)
    return [weigh(facade, beams, scale=scale) for scale in (1.0, 0.9, 1.1)]


def blind(evidence: Evidence) -> Evidence:
    """The same raster without what tells of the wall between the two windows."""
    z, x = np.indices(evidence.llr.shape)
    x = evidence.raster.corner[0] + (x + 0.5) * evidence.raster.cell
    z = evidence.raster.corner[1] + (z + 0.5) * evidence.raster.cell
    pier = (x > LEFT[2]) & (x < RIGHT[0]) & (z > LEFT[1]) & (z < LEFT[3])
    return replace(evidence, llr=np.where(pier, 6.0, evidence.llr), solid=np.where(pier, 0.0, evidence.solid))


def places(evidences):
    return np.array(sorted(box for box, _ in find_on_rasters(evidences, OpeningOptions(), 0.0)))


def test_rasters_are_of_different_cells(evidences):
    assert len({round(e.raster.cell, 6) for e in evidences}) == 3


def test_all_rasters_together_find_each_window_once(evidences):
    found = places(evidences)
    assert np.abs(found - [LEFT, RIGHT]).max() < 0.1


def test_a_raster_that_misses_the_pier_is_overruled(evidences):
    one = places([blind(evidences[0])])
    assert len(one) == 1 and one[0, 2] - one[0, 0] > 2.0  # by itself it takes both for one
    for k in range(3):
        seen = [blind(e) if j == k else e for j, e in enumerate(evidences)]
        assert np.abs(places(seen) - [LEFT, RIGHT]).max() < 0.1


def test_a_raster_that_sees_more_than_the_others_is_overruled(evidences):
    seen = [blind(evidences[0]), blind(evidences[1]), evidences[2]]
    assert len(places(seen)) == 1


def test_openings_do_not_depend_on_where_cells_lie():
    boxes = [*wall([LEFT, RIGHT]), *framed(LEFT, 0.15), *framed(RIGHT, 0.15)]
    facade, scan = scanned(wall=boxes, spacing=0.05)
    for spacing in (0.045, 0.0475, 0.05, 0.0525, 0.055):
        found = find_openings(replace(facade, spacing=spacing), scan)
        assert isinstance(found, FoundOpenings) and len(found.openings) == 2
