"""Photos that nothing places in the scan are refused, also when tie points connect them with one another."""

from types import SimpleNamespace

import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3
from frontage.model import Camera, Estimate, Photo
from frontage.orientation.adjusted import AdjustedPhotos
from frontage.orientation.judging import in_one_word, judged
from frontage.orientation.network import CONTROL, TIES, TiePoints
from frontage.orientation.placed import Placed, contrary
from frontage.orientation.verify import Verdict

UNDECIDED = Verdict(0, 0, 1.0, 0.0, 0.0, 0.0)


CAMERA = Camera("PINHOLE", 400, 300, np.array([400.0, 400.0, 200.0, 150.0]))
REACH = 20.0
"""Pixels within which control points were looked for."""


def block(control, pairs, *, unique=True, ties=40, off=0.02):
    """Photos with a number of control points each, and tie points between pairs of them.

    Residuals are uniformly distributed up to a share `off` of the reach of the search.
    """
    photo, point, group = [], [], []
    for k, count in enumerate(control):
        photo += [k] * count
        group += [CONTROL] * count
    point += list(range(len(photo)))
    for a, b in pairs:
        numbers = list(range(len(point), len(point) + ties))
        photo += [a] * ties + [b] * ties
        point += numbers * 2
        group += [TIES] * 2 * ties
    photos = len(control)
    network = SimpleNamespace(
        images=SimpleNamespace(photo=np.array(photo), point=np.array(point), group=np.array(group)),
        photos=SimpleNamespace(body=np.arange(photos)),
        points=np.zeros((max(point) + 1, 3)),
    )
    return AdjustedPhotos(
        SimpleNamespace(photos=[SimpleNamespace(id=f"P{k}") for k in range(photos)]),
        tuple(SimpleNamespace(unique=np.full(count, unique), radius=REACH) for count in control),
        network,
        SimpleNamespace(
            used=np.ones(len(photo), bool),
            residuals=np.random.default_rng(1).uniform(-off * REACH, off * REACH, (len(photo), 2)),
        ),
    )


def test_one_photo_with_control_carries_those_that_are_tied_to_it():
    keep, refused = judged(block([20, 0, 0], [(0, 1), (1, 2)]), [UNDECIDED] * 3, [False] * 3, last=True)
    assert keep.tolist() == [0, 1, 2] and not refused


def test_photos_that_are_tied_to_each_other_alone_are_refused():
    keep, refused = judged(block([20, 3, 4], [(1, 2)]), [UNDECIDED] * 3, [False] * 3, last=True)
    assert keep.tolist() == [0]
    assert [(r.photo, r.code) for r in refused] == [("P1", "O105"), ("P2", "O105")]
    assert "only 7 control points support it together" in refused[0].reason


def test_control_that_may_lie_elsewhere_does_not_place_a_photo():
    keep, refused = judged(block([50, 50], [(0, 1)], unique=False), [UNDECIDED] * 2, [False] * 2, last=True)
    assert not len(keep) and len(refused) == 2


def test_control_that_is_found_anywhere_within_reach_supports_nothing():
    keep, refused = judged(block([500, 500], [], off=1.0), [UNDECIDED] * 2, [False] * 2, last=True)
    assert not len(keep) and all("only 0 control points" in r.reason for r in refused)


CONFIRMED = Verdict(20, 18, 1e-9, 0.0, 0.5, -5.0)
DOUBTED = Verdict(20, 3, 1.0, 300.0, 1.02, 0.4)
CONTRADICTED = Verdict(20, 3, 1.0, 300.0, 1.6, 5.0)
FAR_DOUBTED = Verdict(20, 18, 1e-9, 0.0, 0.5, -5.0, far=1.0, away=6.4)
FAR_CONTRADICTED = Verdict(20, 18, 1e-9, 0.0, 0.5, -5.0, far=4.0, away=6.4)


def test_what_may_be_chance_is_outweighed_by_ties_to_a_photo_without_doubt():
    state = block([60, 60, 60], [(0, 1), (1, 2)])
    keep, refused = judged(state, [CONFIRMED, DOUBTED, DOUBTED], [False] * 3, last=True)
    assert keep.tolist() == [0, 1]  # the last one is tied only to a photo that is doubtful itself
    assert [(r.photo, r.code) for r in refused] == [("P2", "O104")]


def test_photos_without_doubt_pass_on_what_holds_a_doubtful_one():
    state = block([60, 20, 20], [(0, 1), (1, 2)])
    assert judged(state, [CONFIRMED, UNDECIDED, DOUBTED], [False] * 3, last=True)[0].tolist() == [0, 1, 2]
    state = block([60, 20, 20], [(0, 1), (1, 2)], ties=10)
    assert judged(state, [CONFIRMED, UNDECIDED, DOUBTED], [False] * 3, last=True)[0].tolist() == [0, 1]


def test_what_is_not_chance_is_not_outweighed():
    keep, refused = judged(block([60, 60], [(0, 1)]), [CONFIRMED, CONTRADICTED], [False] * 2, last=False)
    assert keep.tolist() == [0] and refused[0].code == "O104"


def test_another_part_of_the_scan_that_agrees_better_refuses_a_photo():
    state = block([60, 60, 60], [(0, 1), (1, 2)])
    verdicts = [CONFIRMED, FAR_DOUBTED, FAR_CONTRADICTED]
    keep, refused = judged(state, verdicts, [False] * 3, last=True)
    assert keep.tolist() == [0, 1]  # what may be chance is outweighed by ties
    assert [in_one_word(state, k, verdict) for k, verdict in enumerate(verdicts[:2])] == ["confirmed", "tied"]
    assert refused[0].code == "O104" and "6.4 m from where its pose puts it" in refused[0].reason
    assert not judged(block([60], []), [FAR_DOUBTED], [False], last=True)[0].tolist()


def test_a_doubtful_photo_needs_many_ties():
    keep, refused = judged(block([60, 60], [(0, 1)], ties=10), [CONFIRMED, DOUBTED], [False] * 2, last=True)
    assert keep.tolist() == [0] and refused[0].code == "O104"


def test_a_pose_against_the_approximate_one_needs_much_control():
    state = block([22, 60, 22], [(1, 2)])
    keep, refused = judged(state, [CONFIRMED] * 3, [True] * 3, last=False)
    assert keep.tolist() == [1]
    assert [(r.photo, r.code) for r in refused] == [("P0", "O104"), ("P2", "O104")]
    assert "contradicts the approximate one" in refused[0].reason


@pytest.mark.parametrize(("photos", "common", "expected"), [(4, 20.0, [3]), (4, 0.0, [3]), (1, 0.0, [0])])
def test_what_is_common_to_all_approximate_positions_contradicts_no_pose(photos, common, expected):
    sigma = np.diag([3.0**2] * 3 + [np.radians(10.0) ** 2] * 3)
    given, placed = [], []
    for k in range(photos):
        at = np.array([5.0 * k, 0.0, 2.0])
        far = np.array([0.0, 15.0, 0.0]) if k == photos - 1 else np.zeros(3)
        known = Rigid3("local", "camera", np.eye(3), at + np.array([common, 0.0, 0.0]) + far)
        given.append(Photo(f"P{k}", CAMERA, Estimate(known, sigma, 0.0)))
        pose = Rigid3("local", "camera", np.eye(3), at)
        placed.append(Photo(f"P{k}", CAMERA, Estimate(pose, np.zeros((6, 6)), 0.0)))
    found = contrary(Placed(np.arange(photos), tuple(placed), TiePoints.none()), given)
    assert np.flatnonzero(found).tolist() == expected
