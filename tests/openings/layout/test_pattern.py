"""Rows, columns and forms: what they say of openings that the scan shows badly, and where beams win."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.openings.borders.edges import Edge
from frontage.openings.borders.locate import Border
from frontage.openings.layout.forms import Forms, is_known
from frontage.openings.layout.groups import levels_of, rows_of, values_of
from frontage.openings.layout.inferred import near_ones
from frontage.openings.layout.likeness import Likeness
from frontage.openings.layout.pattern import revise, settled
from frontage.openings.layout.pooling import pool
from openings.fronts import SIZE, front, outline
from openings.layout.test_inferred import evidence

KNOWN = 0.004
HALF = (0.0, 0.0, -SIZE[0] / 2, 0.0)  # m, what a branch takes off an opening on the right
SHADOW = (0.0, 0.0, 0.0, 0.9)  # m, what the shadow of a ledge adds above it


def seen_badly(truth, change, vague):
    """An outline that is off by `change`, with a standard error of half a metre on the `vague` sides."""
    sigma = np.full(4, KNOWN)
    sigma[list(vague)] = 0.5
    return outline(tuple(np.add(truth, change)), sigma)


def revised(number, instead, told, **changed):
    """What is made of a regular front with another outline, or none, in the place of one of its openings."""
    found, truth = front(1, sigma=KNOWN)
    outlines = pool([o for k, o in enumerate(found) if k != number])
    outlines += [] if instead is None else [instead(truth[number])]
    known = replace(told(truth), **changed)
    return revise(outlines, known, [False] * len(outlines)), truth[number], len(outlines) - 1


def test_a_window_half_hidden_becomes_whole():
    def told(truth):
        hidden = (truth[7][0] + SIZE[0] / 2, truth[7][1] - 0.5, truth[7][2] + 0.5, truth[7][3] + 0.5)
        return evidence(truth, [hidden])

    (one,), place, last = revised(7, lambda t: seen_badly(t, HALF, [1]), told)
    assert one.instead == (last,) and one.chance > 0.9
    assert one.proposal.place == pytest.approx(place, abs=0.02)


def test_a_window_that_was_not_found_is_found_in_its_row_and_column():
    (one,), place, _ = revised(12, None, evidence)
    assert one.instead == () and one.chance > 0.9 and one.evidence > 0
    assert one.proposal.place == pytest.approx(place, abs=0.02)


@pytest.mark.parametrize(("share", "found"), [(0.3, 1), (0.7, 0)])
def test_a_window_whose_foot_a_hedge_hides_is_found_above_it(share, found):
    """The outline of the facade ends where the hedge begins."""

    def told(truth):
        known = evidence(truth)
        _, z0, _, z1 = truth[2]
        low = int((z0 + share * (z1 - z0) - known.raster.corner[1]) / known.raster.cell)
        inside = known.inside.copy()
        inside[:low] = False
        return replace(known, inside=inside)

    revisions, place, _ = revised(2, None, told)
    assert len(revisions) == found
    assert all(one.proposal.place == pytest.approx(place, abs=0.02) for one in revisions)


def test_a_single_window_of_another_height_tells_the_column_of_a_window_in_a_row():
    found, truth = front(1, rows=2, sigma=KNOWN)
    upper = truth[9] + [0.0, 0.0, 0.0, 0.3]  # the only one of the upper row in this column is higher
    outlines = pool([o for k, o in enumerate(found) if k not in (4, 9)] + [outline(tuple(upper), KNOWN)])
    (one,) = revise(outlines, evidence([*truth[:9], upper]), [False] * len(outlines))
    assert one.instead == ()
    assert one.proposal.place == pytest.approx(truth[4], abs=0.02)


def test_a_shadow_below_a_window_does_not_speak_for_the_wall_beside_it():
    wrong = (-0.5, -0.6, 0.0, 0.0)  # taken half a metre too far to the left, and down into the shadow

    def told(truth):
        below = (truth[7][0] - 0.5, truth[7][1] - 0.6, truth[7][2], truth[7][1])
        return evidence([*truth, below])

    (one,), place, last = revised(7, lambda t: seen_badly(t, wrong, [2]), told, rays=False)
    assert one.instead == (last,) and one.chance > 0.9
    assert one.proposal.place == pytest.approx(place, abs=0.02)


def test_none_where_the_wall_was_seen():
    found, _, _ = revised(12, None, lambda truth: evidence(np.delete(truth, 12, axis=0)))
    assert found == []


def test_an_opening_that_is_well_known_stays_as_it_is():
    found, _, _ = revised(7, lambda t: seen_badly(t, (0.0, -0.8, 0.5, 0.0), []), evidence)
    assert found == []


def test_a_foot_that_may_be_a_doors_is_left_alone():
    found, truth = front(1, sigma=KNOWN)
    outlines = [*(o for k, o in enumerate(found) if k != 2), seen_badly(truth[2], (0.0, -0.9, 0.0, 0.0), [2])]
    below = (truth[2][0] - 0.5, truth[2][1] - 1.0, truth[2][2] + 0.5, truth[2][1])
    told = evidence(truth, [below])
    assert revise(outlines, told, [False] * 19 + [True]) == []
    assert len(revise(outlines, told, [False] * 20)) == 1


@pytest.mark.parametrize(("deep", "expected"), [(False, 1), (True, 0)])
def test_a_shadow_without_lines_of_sight_is_cut_off_unless_depth_shows_in_it(deep, expected):
    """Beams that come back from behind the wall show that it is open there; a mere gap may be a shadow."""
    found, truth = front(1, sigma=KNOWN)
    high = tuple(np.add(truth[7], SHADOW))
    boxes = [*np.delete(truth, 7, axis=0), high]
    told = replace(evidence(boxes), rays=False)
    behind = evidence(boxes if deep else truth)
    told = replace(told, deep=behind.open, open=behind.open)
    outlines = [*(o for k, o in enumerate(found) if k != 7), seen_badly(truth[7], SHADOW, [3])]
    assert len(revise(outlines, told, [False] * 20)) == expected


def test_with_lines_of_sight_open_cells_are_no_shadow():
    found, truth = front(1, sigma=KNOWN)
    boxes = [*np.delete(truth, 7, axis=0), tuple(np.add(truth[7], SHADOW))]
    outlines = [*(o for k, o in enumerate(found) if k != 7), seen_badly(truth[7], SHADOW, [3])]
    assert revise(outlines, evidence(boxes), [False] * 20) == []


def test_few_openings_tell_nothing():
    found, truth = front(1, rows=1, columns=1)
    assert revise(found, evidence(truth), [False]) == []
    assert revise([], evidence([]), []) == []


def test_borders_that_are_not_seen_are_those_of_the_prediction():
    (one,), place, _ = revised(12, None, evidence)
    told = settled(one, outline(tuple(np.add(place, 0.3)), 0.01))
    assert told.place == pytest.approx(one.proposal.place) and told.pooled
    assert np.diag(told.covariance)[:4] == pytest.approx(np.diag(one.proposal.covariance)[:4])


def test_predicted_borders_owe_nothing_to_the_footprint_of_the_beams():
    (one,), place, _ = revised(12, None, evidence)
    none, doubt = np.empty(0), 0.02
    edge = Edge((none, none), (none, none), none, None, None, 0.0, doubt, (0.0, 0.0, 0.0), True)
    unseen, seen = (Border(0.0, 0.5, gain, edge, none) for gain in (0.0, 100.0))
    measured = replace(outline(tuple(place), 0.02), borders=(unseen, unseen, unseen, seen))
    told = settled(one, measured)
    assert [b.edge.doubt for b in told.borders] == [0.0, 0.0, 0.0, doubt]
    _, (covariance,) = values_of([told])
    assert np.linalg.eigvalsh(covariance).min() > 0.0


def test_forms_are_of_one_size_within_the_tolerances_of_building():
    low = [outline((2.0 * k, 0.0, 2.0 * k + 1.0, 2.0), 0.002) for k in range(3)]
    built = [outline((2.0 * k, 5.0, 2.0 * k + 1.01, 7.02), 0.002) for k in range(2)]
    high = [outline((2.0 * k, 9.0, 2.0 * k + 1.0, 11.5), 0.002) for k in range(2)]
    assert [sorted(g) for g in Forms([*low, *built, *high]).groups] == [[0, 1, 2, 3, 4], [5, 6]]


def test_an_opening_known_in_part_gets_the_sill_of_the_row_beside_it():
    row = [outline((2.0 * k, 1.0, 2.0 * k + 1.0, 3.0), 0.002) for k in range(4)]
    part = outline((8.0, 1.9, 9.0, 3.0), (0.002, 0.002, 0.6, 0.002))
    assert is_known(part).tolist() == [True, True, False, True]
    (one,) = Forms([*row, part]).completed()
    assert one.number == 4 and one.place == pytest.approx((8.0, 1.0, 9.0, 3.0), abs=0.01)
    assert one.share == pytest.approx(4.5 / 5.0)


def test_a_place_is_compared_with_openings_and_with_wall():
    _, truth = front(1, sigma=KNOWN)
    boxes = [tuple(t) for t in truth]
    likeness = Likeness(evidence(boxes), boxes)
    wall = tuple(np.add(truth[7], (1.3, 0.0, 1.3, 0.0)))
    assert likeness.nats(boxes[7], boxes[:5]).sum() > 5.0
    assert likeness.nats(wall, boxes[:5]).sum() < -5.0


def test_boxes_are_near_within_a_decimetre():
    boxes = np.array([(1.05, 0.0, 2.0, 1.0), (1.2, 0.0, 2.0, 1.0), (0.2, 0.2, 0.4, 0.4)])
    assert near_ones((0.0, 0.0, 1.0, 1.0), boxes).tolist() == [True, False, True]


def test_a_narrow_window_is_found_in_a_row_of_wide_ones():
    """Bathrooms: its row has wide windows only, but as high as the narrow ones of its column."""
    corners = [(2.5 * c, 3.2 * r + 1.0, 0.6 if c == 1 else SIZE[0]) for r in range(4) for c in range(4)]
    truth = np.array([(x, z, x + w, z + SIZE[1]) for x, z, w in corners])
    gone = 9  # of the narrow ones
    outlines = pool([outline(tuple(t), KNOWN) for k, t in enumerate(truth) if k != gone])
    (one,) = revise(outlines, evidence(truth), [False] * len(outlines))
    assert one.instead == ()
    assert one.proposal.place == pytest.approx(truth[gone], abs=0.02)


def test_the_lintel_tells_the_row_of_an_opening_whose_sill_is_hidden():
    """Two houses, the floors of one 0.3 m higher: the row beside it is that of its lintel."""
    sigma = np.full(4, KNOWN)
    hidden = np.array([KNOWN, KNOWN, 0.5, KNOWN])
    low = [outline((2.0 * k, 1.0, 2.0 * k + 1.0, 3.0), sigma) for k in range(3)]
    high = [outline((2.0 * k, 1.3, 2.0 * k + 1.0, 3.3), sigma) for k in (4, 5)]
    badly = outline((12.0, 1.05, 13.0, 3.3), hidden)
    own, variance = values_of([*low, *high, badly])
    level, error = levels_of(own, variance, [tuple(range(6))])
    assert level[5] == pytest.approx(1.3, abs=0.02) and error[5] < 0.05
    assert [set(row) for row in rows_of(level, [tuple(range(6))])] == [{0, 1, 2}, {3, 4, 5}]
