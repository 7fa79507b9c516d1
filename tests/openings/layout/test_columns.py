"""Openings of a sparse row are parted where other rows part them, unless the beams say that they are one."""

import numpy as np
import pytest

from frontage.openings.layout.columns import divided_by_columns
from frontage.openings.layout.densities import Place
from frontage.openings.wall.beams import sort_beams
from frontage.openings.wall.evidence import weigh
from openings.boxes import box, scanned
from openings.joinery import holed

FLOORS, HIGH, TOP = (0.8, 2.9, 5.0), 1.3, 7.1
COLUMNS = ((0.4, 1.6), (2.0, 3.2), (3.6, 4.8), (6.2, 7.4))


@pytest.fixture(scope="module", params=[(), ((2.0, 4.8),)], ids=["piers", "wide"])
def top(request):
    """The evidence of a wall whose top row has the columns of the others, or one wide opening (x0, x1)."""
    row = request.param or COLUMNS
    solids = []
    for z in (*FLOORS, TOP):
        holes = [(a, z, b, z + HIGH) for a, b in (row if z == TOP else COLUMNS)]
        solids += holed(0, 8, z, z + HIGH, 0.0, 0.3, holes)
    ends = [0.0, *(z + d for z in (*FLOORS, TOP) for d in (0.0, HIGH)), 9.0]
    solids += [box(0, 8, 0, 0.3, low, high) for low, high in zip(ends[::2], ends[1::2], strict=True)]
    facade, scan = scanned(wall=solids, eyes=((4.0, -10.0, 1.6),))
    return row, weigh(facade, sort_beams(facade, scan))


def places(evidence, floors=FLOORS, wide=(2.0, 4.8)):
    """The windows of the lower rows, and one opening across two columns in the top row."""
    found = [(a, z, b, z + HIGH) for z in floors for a, b in COLUMNS]
    return [Place(b, 1.0, evidence) for b in [*found, (wide[0], TOP, wide[1], TOP + HIGH)]]


def in_top_row(found):
    return [(p.box[0], p.box[2]) for p in found if p.box[1] == TOP]


def test_only_beams_that_pass_make_one_opening_of_two_columns(top):
    row, evidence = top
    told = COLUMNS[1:3] if row == COLUMNS else row
    assert in_top_row(divided_by_columns(places(evidence))) == [pytest.approx(x) for x in told]


@pytest.mark.parametrize(("floors", "wide"), [((), (2.0, 4.8)), (FLOORS, (2.6, 4.8)), (FLOORS, (2.0, 5.6))])
def test_openings_that_no_row_parts_at_their_borders_stay(top, floors, wide):
    before = places(top[1], floors, wide)
    assert in_top_row(divided_by_columns(before)) == [wide]


def test_no_places_have_no_columns():
    assert divided_by_columns([]) == []


def test_what_nothing_was_seen_of_follows_the_rows_that_agree(top):
    _, evidence = top
    unseen = type(evidence)(**{**evidence.__dict__, "llr": np.zeros_like(evidence.llr)})
    assert len(in_top_row(divided_by_columns(places(unseen)))) == 2
