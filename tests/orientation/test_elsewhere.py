"""A place that agrees in a part of the picture is refused where another part of the scan agrees better."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3
from frontage.model import Camera
from frontage.orientation.drawnwall import Similarity
from frontage.orientation.elsewhere import OtherPlace, OtherPlaces
from frontage.orientation.reflectance.surface import scanned_surface
from frontage.orientation.verify import Verdict, verify
from orientation.paintedwalls import PIXEL, Wall, looking, paint, photograph, posed, scan_of

OFF = 14.0  # m along the wall, after which its lower half is painted alike
HEIGHT, ALIKE = 7.0, 3.8  # m
WIDE = Camera("PINHOLE", 1000, 750, np.array([700.0, 700.0, 503.0, 372.0]))
NARROW = Camera("PINHOLE", 1000, 360, np.array([800.0, 800.0, 503.0, 20.0]))
TRUE = looking(7.0, -9.0, pitch=0.0)
LOW = Rigid3("local", "camera", TRUE.R, TRUE.t + np.array([0.5, 0.0, 1.9]))


def half_alike():
    """A wall of twice 14 m: what is below is painted twice."""
    tones = paint(2 * OFF, HEIGHT, seed=3)
    low, half = round((HEIGHT - ALIKE) / PIXEL), round(OFF / PIXEL)
    tones[low:, half:] = tones[low:, :half]
    return Wall((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), tones)


WALL = half_alike()
SURFACE = scanned_surface(scan_of([WALL], 0.06))
PLACES = {"whole": (TRUE, WIDE), "below": (LOW, NARROW)}
PICTURES = {name: photograph([WALL], posed(pose, camera)) for name, (pose, camera) in PLACES.items()}


def photo_of(name, move):
    """A photo at its place, or moved along the wall by metres."""
    pose, camera = PLACES[name]
    return posed(Rigid3("local", "camera", pose.R, pose.t + np.array([move, 0.0, 0.0])), camera, name=name)


def verdicts(names, move, blocks, sigma=0.0):
    """What is said of moved photos, by the surroundings of their poses, and by all of the scan.

    The standard error `sigma` m of the moved poses is stated, if there is one.
    """
    photos = [photo_of(name, move) for name in names]
    known = np.diag([sigma**2] * 3 + [(0.1 * sigma) ** 2] * 3)
    given = [replace(p, local_from_camera=replace(p.local_from_camera, covariance=known)) for p in photos]
    nearby = [verify(photo, SURFACE, PICTURES.__getitem__) for photo in photos]
    return nearby, OtherPlaces(SURFACE, PICTURES.__getitem__).judged(photos, given, nearby, np.array(blocks))


@pytest.mark.parametrize("name", PLACES)
def test_no_other_place_contradicts_the_right_one(name):
    _, (verdict,) = verdicts([name], 0.0, [0])
    assert not verdict.doubted
    assert verdict.confirmed or name == "below"


def test_a_wrong_place_that_agrees_in_half_of_the_picture_is_doubted():
    (nearby,), (verdict,) = verdicts(["whole"], OFF, [0])
    assert nearby.confirmed  # the surroundings of the pose do not tell
    assert verdict.doubted and not verdict.confirmed
    assert verdict.away == pytest.approx(OFF, abs=0.3) and verdict.distance == "14.0 m"


def test_a_place_that_contradicts_the_approximate_pose_does_not_count():
    assert not verdicts(["whole"], OFF, [0], sigma=3.0)[1][0].doubted
    assert verdicts(["whole"], OFF, [0], sigma=5.0)[1][0].doubted


def test_photos_of_a_block_are_doubted_together():
    apart = verdicts(["below", "whole"], OFF, [0, 1])[1]
    assert [verdict.doubted for verdict in apart] == [False, True]
    together = verdicts(["below", "whole"], OFF, [4, 4])[1]
    assert [verdict.doubted for verdict in together] == [True, True]


def test_what_hardly_agrees_at_all_is_contradicted():
    (nearby,), (verdict,) = verdicts(["whole"], 6.0, [0])
    assert not nearby.confirmed
    assert verdict.contradicted and verdict.away == pytest.approx(6.0, abs=0.3)


def test_a_photo_that_shows_no_wall_has_no_other_place():
    away = posed(looking(7.0, -9.0, heading=180.0), WIDE, name="whole")
    nearby = [verify(away, SURFACE, PICTURES.__getitem__)]
    others = OtherPlaces(SURFACE, PICTURES.__getitem__)
    assert others.judged([away], [away], nearby, np.zeros(1, int)) == nearby


def test_a_place_that_may_agree_by_chance_raises_no_doubt():
    photo = photo_of("whole", OFF)
    few = Verdict(templates=20, agreeing=1, chance=0.1, shift=0.0, rival=0.0, excess=0.0)
    others = OtherPlaces(SURFACE, PICTURES.__getitem__)
    chance = OtherPlace(Similarity(1.0, np.eye(3), np.zeros(3)), OFF, there=13.0, here=few.evidence)
    others._best = lambda *_: chance
    assert others.judged([photo], [photo], [few], np.zeros(1, int)) == [few]
    others._best = lambda *_: replace(chance, there=15.0)
    assert others.judged([photo], [photo], [few], np.zeros(1, int))[0].doubted
