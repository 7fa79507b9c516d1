"""Openings do not overlap: as laid out, as measured, on fronts before one another, behind balconies."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

from frontage.model.estimate import Estimate, Provenance
from frontage.model.opening import Protrusion
from frontage.openings import FoundOpenings, find_openings
from frontage.openings.borders.locate import Border
from frontage.openings.fronts import FrontSearch, openings_on_fronts
from frontage.openings.layout.overlaps import best_without_overlaps, without_overlaps
from frontage.openings.layout.selection import CellBox, best_layout
from frontage.openings.wall.beams import sort_beams
from frontage.openings.wall.evidence import weigh
from fronts import WINDOW, box_of, scan_wall
from opening_fakes import opening
from openings.fronts import outline

LOW, HIGH = (1.0, 2.0, 2.2, 2.7), (1.0, 2.85, 2.2, 3.6)  # of WINDOW


def jumble(seed):
    """A wall with holes over one another (steps, crosses, tees) and places that nothing came back from."""
    rng = np.random.default_rng(seed)
    x, z = rng.uniform([[0.5, 0.5]] * 5, [5.5, 3.8]).T
    w, h = rng.uniform(0.4, 1.4, (2, 5))
    holes = np.column_stack([x, z, np.minimum(x + w, 6.6), np.minimum(z + h, 4.6)])
    spacing, returned = (0.03, 0.05, 0.07)[seed % 3], (1.0, 0.5, 0.0)[seed // 2 % 3]
    facade, scan = scan_wall(holes, spacing=spacing, rays=bool(seed % 2), returned=returned, seed=seed)
    kept = np.ones(len(scan.xyz), np.bool_)
    for x, z, w, h in rng.uniform([0.0, 0.0, 0.1, 0.1], [6.0, 4.0, 1.2, 1.2], (3, 4)):
        kept &= (np.abs(scan.xyz[:, [0, 2]] - (x, z)) > (w / 2, h / 2)).any(1)
    index = np.arange(kept.sum())
    return replace(facade, support=index, inliers=index), scan.take(np.flatnonzero(kept))


def overlaps(openings):
    rings = [shapely.Polygon(o.ring) for o in openings]
    return sum(a.intersection(b).area > 1e-9 for k, a in enumerate(rings) for b in rings[:k])


@pytest.mark.parametrize("seed", range(12, 30))
def test_openings_of_a_facade_never_overlap(seed):
    found = find_openings(*jumble(seed))
    assert isinstance(found, FoundOpenings)
    assert overlaps(found.openings) == 0


def test_layouts_that_overlap_are_laid_out_together():
    large, beside = CellBox(0, 0, 20, 10, 90.0), CellBox(0, 14, 20, 20, 40.0)
    over, less = CellBox(18, 2, 30, 8, 60.0), CellBox(21, 2, 30, 8, 50.0)
    assert best_layout([[large, beside], [over, less]], pier=2) == [large, beside, less]
    assert best_layout([[large], [over]]) == [large]
    assert (
        best_layout([[large], [CellBox(0, 10, 20, 14, 5.0)], [beside]], pier=2)[1].worth == 5.0
    )  # no group's


def measured(place, **more):
    told = (Border(0.0, 0.01, 20.0, None, np.zeros(0)),) * 4
    return replace(outline(place, 0.01), borders=told, **more)


def evidence_of(holes):
    facade, scan = scan_wall(holes)
    return weigh(facade, sort_beams(facade, scan))


def test_parts_of_one_opening_are_one_where_an_outline_covers_both():
    whole = measured(WINDOW)
    assert without_overlaps([whole, measured(HIGH)], [LOW, HIGH], evidence_of([WINDOW])) == [whole, None]


def test_borders_that_run_over_a_neighbour_go_back_to_the_layout():
    evidence, place = evidence_of([LOW, HIGH]), (*LOW[:3], 3.0)
    found, other = without_overlaps([measured(place), measured(HIGH)], [LOW, HIGH], evidence)
    assert found.place == LOW and other.place == HIGH
    assert np.sqrt(found.covariance[3, 3]) > 0.15  # at either of the two
    arched = measured(place, shape="segmental", rise=0.1)
    found, _ = without_overlaps([arched, measured(HIGH)], [LOW, HIGH], evidence)
    assert (found.shape, found.place) == ("rectangle", LOW)


def test_of_openings_over_one_another_the_most_evidence_is_left():
    door, slab = opening("a", (0, 0, 1, 2)), replace(opening("b", (-0.5, 0, 1.5, 0.3)), evidence=20.0)
    beside = replace(opening("c", (1.0, 0, 2, 2)), evidence=-3.0)  # it was inferred, and touches the door
    assert [o.id for o in best_without_overlaps([slab, door, beside])] == ["a", "c"]


def front(name, box, y):
    ring = opening(box=box).ring
    depth = Estimate(y, np.eye(1) * 1e-6, 10.0)
    return Protrusion(name, "oriel", ring, 0.01, depth, Provenance.MEASURED, 1.0)


def test_the_foremost_front_hides_what_is_behind_it_and_each_is_searched_once():
    searched = []

    def find(facade, scan):
        searched.append(facade.id)
        box = (2.2, 2.0, 2.8, 3.0) if facade.id == "bay" else (1.1, 1.0, 3.9, 3.0)
        return (opening(box=box),)

    fronts = FrontSearch(*scan_wall([WINDOW], spacing=0.1), find)
    walls = [front("bay", (2.0, 1.5, 3.0, 3.5), -0.9), front("wide", (1.0, 0.0, 4.0, 4.0), -0.3)]
    beside, over = (5.0, 1.0, 6.0, 2.0), (2.4, 2.2, 6.9, 2.8)
    fronts.openings(walls[0])
    found = openings_on_fronts([opening(box=beside), opening(box=over)], walls, fronts)
    assert searched == ["bay", "wide"] and overlaps(found) == 0
    assert [(o.on, *box_of(o)) for o in found] == [("", *beside), ("bay", 2.2, 2.0, 2.8, 3.0)]


@pytest.mark.parametrize(("filled", "left"), [(False, 1.2), (True, 1.2), (False, 2.2)])
def test_a_front_hides_what_it_fills_and_what_is_seen_through_it_but_not_what_reaches_beyond_it(filled, left):
    facade, scan = scan_wall([], spacing=0.05)
    if filled:
        scan = replace(scan, xyz=scan.xyz - [0.0, 0.3, 0.0])
    door, pedestal = opening(box=(left, 0.0, 3.6, 2.5)), front("pedestal", (2.0, 0.0, 5.0, 4.0), -0.3)
    found = openings_on_fronts([door], [pedestal], FrontSearch(facade, scan, lambda *_: ()))
    assert len(found) == (left < 2.0 and not filled)
