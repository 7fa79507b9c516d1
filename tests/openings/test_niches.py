"""Recesses of the wall: openings in their backs, and recesses that are openings themselves."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.geometry.ring import rectangle
from frontage.openings import FoundOpenings, find_openings
from frontage.openings.fronts import FrontSearch
from frontage.openings.niches import find_niches
from openings.boxes import box, scanned
from openings.joinery import framed, glazed, holed, niche, wall

ENTRANCE = (2.2, 0.0, 6.2, 3.0)
DOOR, PANE = (2.6, 0.0, 3.6, 2.3), (4.2, 0.8, 5.8, 2.4)
LEAF = box(2.6, 3.6, 1.1, 1.15, 0.0, 2.3)


def found_in(solids, **how):
    found = find_openings(*scanned(wall=solids, **how))
    assert isinstance(found, FoundOpenings)
    return found


def boxes_of(found):
    return [np.concatenate([o.ring.min(0), o.ring.max(0)]) for o in found.openings]


@pytest.mark.parametrize("rays", [True, False])
def test_door_and_pane_of_a_recessed_entrance(rays):
    found = found_in([*niche(ENTRANCE, 1.0, [DOOR, PANE]), LEAF, *framed(PANE, 1.1)], rays=rays)
    (recess,) = found.protrusions
    assert recess.kind == "niche" and recess.front.value == pytest.approx(1.0, abs=0.003)
    assert np.abs(np.concatenate([recess.ring.min(0), recess.ring.max(0)]) - ENTRANCE).max() < 0.01
    assert [o.kind for o in found.openings] == ["door", "window"]
    assert np.abs(np.array(boxes_of(found)) - [DOOR, PANE]).max() < 0.01
    assert all(o.on == recess.id and abs(o.depth.value - 0.1) < 0.01 for o in found.openings)


@pytest.mark.parametrize("deep", [0.6, 1.3])
def test_panes_of_a_recess_that_joinery_fills(deep):
    panes = [(2.3, 0.0, 3.4, 2.9), (3.6, 0.0, 4.6, 2.9), (4.8, 0.6, 6.1, 2.9)]
    found = found_in(niche(ENTRANCE, deep, panes), spacing=0.02)
    assert [(p.kind, round(p.front.value, 2)) for p in found.protrusions] == [("niche", deep)]
    assert np.abs(np.array(boxes_of(found)) - panes).max() < 0.01


@pytest.mark.parametrize("deep", [0.6, 1.2])
def test_a_door_that_is_the_back_of_its_recess_is_one_opening(deep):
    hole = (3.0, 0.0, 4.2, 2.5)
    found = found_in(niche(hole, deep))
    assert found.protrusions == () and [o.kind for o in found.openings] == ["door"]
    assert np.abs(boxes_of(found)[0] - hole).max() < 0.01


def test_a_door_with_wall_around_it_is_in_the_niche():
    found = found_in(
        [*niche((2.8, 0.0, 4.6, 2.7), 0.9, [(3.2, 0.0, 4.2, 2.2)]), box(3.2, 4.2, 1.0, 1.1, 0, 2.2)]
    )
    assert [p.kind for p in found.protrusions] == ["niche"]
    assert np.abs(boxes_of(found)[0] - (3.2, 0.0, 4.2, 2.2)).max() < 0.01


def test_a_room_behind_a_pane_is_no_niche():
    pane = (2.5, 0.8, 5.5, 2.8)
    room = holed(2.0, 6.0, 0.0, 3.0, 1.2, 1.3, [(3.0, 1.0, 4.0, 2.0)])
    frame = glazed(pane, 0.15, [(2.57, 0.87, 3.96, 2.73), (4.04, 0.87, 5.43, 2.73)])
    found = found_in([*wall([pane]), *frame, *room])
    assert found.protrusions == () and np.abs(boxes_of(found)[0] - pane).max() < 0.01


@pytest.mark.parametrize("hole", [(2.2, 0.0, 5.8, 4.0), (2.2, 2.0, 5.8, 6.2)])
def test_a_closed_gate_or_a_blind_is_no_wall_that_is_set_back(hole):
    x0, z0, x1, z1 = hole
    leaf = box(x0, x1, 0.2, 0.25, z0, z1)
    found = found_in([*wall([hole]), leaf], layers=(0.0, 0.2))
    assert found.protrusions == ()
    assert len(found.openings) == 1 and np.abs(boxes_of(found)[0] - hole).max() < 0.01


@pytest.mark.parametrize("is_wall", [True, False])
def test_a_lattice_that_shows_the_room_behind_it_is_no_back_of_a_niche(is_wall):
    hole, inner = (2.0, 2.0, 5.0, 6.0), [(2.5, 3.0, 3.1, 3.8), (3.6, 3.0, 4.2, 3.8)]
    x, z = (np.arange(a + 0.1, b - 0.2, 0.22) for a, b in ((2.0, 5.0), (2.0, 6.0)))
    lattice = [(a, c, a + 0.19, c + 0.19) for c in z for a in x]
    bars = [b for c in z for b in holed(2.0, 5.0, c, c + 0.22, 0.6, 0.64, [p for p in lattice if p[1] == c])]
    room = box(1.0, 6.0, 1.2, 1.3, 1.0, 7.0)
    solids = niche(hole, 0.6, inner) if is_wall else [*wall([hole]), *bars, room]
    facade, scan = scanned(wall=solids, spacing=0.02)
    found = find_openings(facade, scan)
    assert isinstance(found, FoundOpenings)
    like = found.openings[0]
    opening = replace(like, ring=rectangle(*hole), depth=None, on=None)
    told = tuple(replace(opening, ring=rectangle(*place)) for place in inner)
    assert len(find_niches([opening], [], FrontSearch(facade, scan, lambda *_: told))) == is_wall


def test_a_pipe_in_a_recess_is_no_frame():
    """A few points near the borders may lie no deeper than a frame; a frame holds many more."""
    recess, panes = (2.2, 3.0, 6.2, 5.6), [(2.6, 3.3, 3.6, 5.3), (4.2, 3.8, 5.8, 5.3)]
    pipe = box(2.23, 2.24, 0.05, 0.06, 3.0, 5.6)
    found = found_in([*niche(recess, 1.2, panes), *(f for p in panes for f in framed(p, 1.3)), pipe])
    assert [p.kind for p in found.protrusions] == ["niche"]
    assert np.abs(np.array(boxes_of(found)) - panes).max() < 0.02


def test_an_upper_loggia_whose_windows_are_hidden_is_like_the_others():
    lower, upper = (2.2, 1.0, 6.2, 3.6), (2.2, 5.4, 6.2, 8.0)
    panes = [(2.6, 1.3, 3.6, 3.3), (4.2, 1.8, 5.8, 3.3)]
    behind = [*holed(2.2, 6.2, 1.0, 3.6, 1.2, 1.5, panes), box(2.2, 6.2, 1.2, 1.5, 5.4, 8.0)]
    cheeks = [box(x, x + 0.05, 0.0, 1.2, 1.0, 8.0) for x in (2.15, 6.2)]
    wall_ = [
        b for z0, z1, h in ((0, 4.4, lower), (4.4, 9, upper)) for b in holed(0, 8, z0, z1, 0.0, 0.3, [h])
    ]
    found = found_in([*wall_, *cheeks, *behind, *(f for p in panes for f in framed(p, 1.3))])
    assert [p.kind for p in found.protrusions] == ["niche", "niche"]
    assert sorted(p.provenance for p in found.protrusions) == ["measured", "pooled"]
    assert np.abs(np.array(boxes_of(found)) - panes).max() < 0.02
