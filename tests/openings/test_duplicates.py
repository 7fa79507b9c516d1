"""Openings that several facades of a building show."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3
from frontage.model.estimate import Estimate, Provenance
from frontage.model.opening import Elements, OpeningKind, Protrusion
from frontage.openings.duplicates import without_duplicates
from fronts import scan_wall
from opening_fakes import opening

LEFT, RIGHT = (1.0, 2.0, 2.2, 3.6), (4.8, 2.0, 6.0, 3.6)
STEP = 0.3  # m that the right half of the wall is set back


@pytest.fixture
def stepped():
    """A wall that steps back at x = 3.5 m, as two facades whose outlines both hold all of it."""
    facade, scan = scan_wall([LEFT, RIGHT], returned=0.0)
    scan = replace(scan, xyz=scan.xyz + np.outer(scan.xyz[:, 0] > 3.5, [0.0, STEP, 0.0]))
    return facade, turned(facade, 0.0), scan


def turned(facade, angle):
    """The facade moved to the set-back part, turned about its left end (degrees)."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    frame = Rigid3("local", "facade", np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]), np.array([0, STEP, 0]))
    return replace(facade, id="B01/F2", local_from_facade=Estimate(frame, np.eye(6) * 1e-8, 100.0))


def held(facade, *boxes):
    return facade, Elements(facade.id, tuple(opening(box=box) for box in boxes))


def boxes_of(judged):
    return [[(*o.ring.min(0), *o.ring.max(0)) for o in e.openings] for _, e in judged]


def test_an_opening_belongs_to_the_wall_around_it(stepped):
    front, back, scan = stepped
    found = without_duplicates([held(back, LEFT, RIGHT), held(front, LEFT, RIGHT)], scan)
    assert boxes_of(found) == [[RIGHT], [LEFT]]


def test_what_lies_within_an_opening_of_the_wall_before_it_is_none(stepped):
    front, back, scan = stepped
    gap = (1.3, 2.2, 1.9, 3.0)
    assert boxes_of(without_duplicates([held(front, LEFT), held(back, gap, RIGHT)], scan)) == [
        [LEFT],
        [RIGHT],
    ]


def test_a_window_behind_a_passage_is_another_opening(stepped):
    front, back, scan = stepped
    hall = Rigid3("local", "facade", np.eye(3), np.array([0, 1.3, 0]))
    back = replace(back, local_from_facade=Estimate(hall, np.eye(6) * 1e-8, 100.0))
    window = (1.3, 2.2, 1.9, 3.0)
    for kind, left in ((OpeningKind.PASSAGE, [window]), (OpeningKind.DOOR, [])):
        first, elements = held(front, LEFT)
        gate = replace(elements, openings=tuple(replace(o, kind=kind) for o in elements.openings))
        assert boxes_of(without_duplicates([(first, gate), held(back, window)], scan)) == [[LEFT], left]
        assert boxes_of(without_duplicates([held(back, window), (first, gate)], scan)) == [left, [LEFT]]


def test_what_a_wall_shows_within_a_step_that_is_a_facade_itself_is_dropped(stepped):
    front, back, scan = stepped
    step = replace(back, outline=np.array([[3.6, 0.0], [7.0, 0.0], [7.0, 5.0], [3.6, 5.0]]))
    seen_across = (4.0, 4.0, 6.5, 4.6)
    found = without_duplicates([held(front, LEFT, seen_across), held(step, RIGHT)], scan)
    assert boxes_of(found) == [[LEFT], [RIGHT]]


def test_a_plane_with_less_wall_than_the_one_around_it_takes_no_opening_from_it(stepped):
    front, back, scan = stepped
    curtains = replace(front, id="B01/F3", outline=np.array([[3.6, 0.0], [7.0, 0.0], [7.0, 5.0], [3.6, 5.0]]))
    assert boxes_of(without_duplicates([held(back, RIGHT), held(curtains)], scan)) == [[RIGHT], []]


def test_walls_at_an_angle_keep_their_openings(stepped):
    front, back, scan = stepped
    judged = [held(front, LEFT), held(turned(back, 40.0), LEFT)]
    assert boxes_of(without_duplicates(judged, scan)) == [[LEFT], [LEFT]]


def test_walls_without_a_room_between_look_the_same_way_whatever_was_told(stepped):
    front, back, scan = stepped
    opposite = [(-x1, z0, -x0, z1) for x0, z0, x1, z1 in (LEFT, RIGHT)]
    judged = [held(front, LEFT, RIGHT), held(turned(back, 180.0), *opposite)]
    assert boxes_of(without_duplicates(judged, scan)) == [[LEFT], [opposite[1]]]


def fronted(facade, kind, y, *boxes):
    """A facade with a front at y m that has openings of its own."""
    ring, depth = opening(box=(3.5, 0.0, 7.0, 5.0)).ring, Estimate(y, np.eye(1) * 1e-6, 10.0)
    part = Protrusion(f"{facade.id}/P1", kind, ring, 0.01, depth, Provenance.MEASURED, 1.0)
    shown = tuple(replace(opening(box=box), on=part.id) for box in boxes)
    return facade, Elements(facade.id, shown, (part,))


def test_a_step_back_from_one_wall_and_out_from_the_other_is_told_once(stepped):
    front, back, scan = stepped
    judged = [fronted(front, "setback", 0.15, RIGHT), fronted(back, "risalit", 0.15 - STEP, RIGHT)]
    found = without_duplicates(judged, scan)
    assert boxes_of(found) == [[RIGHT], []]
    assert [[p.kind for p in e.protrusions] for _, e in found] == [["setback"], []]
    other = [judged[0], fronted(back, "oriel", -0.9)]  # it stands before both
    assert [len(e.protrusions) for _, e in without_duplicates(other, scan)] == [1, 1]


def test_a_front_that_is_the_wall_of_another_facade_is_dropped_unless_openings_belong_to_it(stepped):
    front, back, scan = stepped
    beside = held(back, RIGHT)
    bare, carrying = fronted(front, "setback", STEP), fronted(front, "setback", STEP, (4.0, 4.0, 4.4, 4.5))
    for judged, left in ((bare, 0), (carrying, 1)):
        found = without_duplicates([judged, beside], scan)
        assert [len(e.protrusions) for _, e in found] == [left, 0]
    elsewhere = fronted(front, "setback", 3 * STEP)
    assert [len(e.protrusions) for _, e in without_duplicates([elsewhere, beside], scan)] == [1, 0]
