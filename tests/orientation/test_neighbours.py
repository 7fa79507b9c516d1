"""Photos that are in no block find their place by what they share with placed ones."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.geometry.rigid import rotation_angle
from frontage.model import Estimate, Exposure, MountedCamera, Photo, Rig
from frontage.orientation.neighbours import placed_again, placed_by_neighbours
from frontage.orientation.result import Unoriented
from frontage.orientation.ties.reasons import copy_of
from frontage.orientation.views import Views
from orientation.sharedviews import common, painted_street, placed, scene_of


@pytest.fixture(scope="module")
def street():
    return painted_street()


def unposed(photos):
    return [Photo(p.id, p.camera) for p in photos]


def test_a_photo_is_resected_from_what_its_neighbour_sees_of_the_scan(street):
    surface, photos, xyz = street
    pairs = [common(photos, xyz, 0, 1)[0], common(photos, xyz, 1, 2)[0]]
    scene = scene_of(surface, unposed(photos), pairs)
    left = [
        Unoriented("1.jpg", "O101", "it matches no other photo"),
        Unoriented("2.jpg", "O103", "two places"),
    ]
    parts, rest = placed_by_neighbours(scene, [placed(photos, 0)], left)
    assert not rest and [int(p.numbers[0]) for p in parts] == [0, 1, 2]  # the last one through the second
    for part, true in zip(parts, photos, strict=True):
        (found,) = part.photos
        assert np.linalg.norm(found.pose.t - true.pose.t) < 0.03
        assert rotation_angle(found.pose.R @ true.pose.R.T) < np.radians(0.2)


def test_a_refused_photo_is_looked_for_again_unless_it_is_on_a_rig(street):
    surface, photos, xyz = street
    pair, _ = common(photos, xyz, 0, 1)
    refused = [Unoriented("1.jpg", "O104", "the scan is found elsewhere")]
    scene = scene_of(surface, unposed(photos), [pair])
    found, rest = placed_again(scene, placed(photos, 0), refused, Views(scene, [placed(photos, 0)]))
    assert not rest and found.numbers.tolist() == [0, 1]
    assert np.linalg.norm(found.photos[1].pose.t - photos[1].pose.t) < 0.03
    cameras = (MountedCamera("left"), MountedCamera("right"))
    rig = Rig("car", cameras, (Exposure("1", ("0.jpg", "1.jpg"), (0, 1)),))
    carried = replace(scene, rigs=(rig,))
    found, rest = placed_again(carried, placed(photos, 0), refused, Views(carried, [placed(photos, 0)]))
    assert found.numbers.tolist() == [0] and rest == refused


def test_what_is_not_supported_stays_without_a_place(street):
    surface, photos, xyz = street
    few, mostly_false = common(photos, xyz[::150], 0, 1)[0], common(photos, xyz, 0, 2, wrong=0.95)[0]
    copy = Unoriented("1.jpg", "O101", copy_of("0.jpg"))
    for pair, one in ((few, "1.jpg"), (mostly_false, "2.jpg")):
        left = [Unoriented(one, "O101", "why")]
        scene = scene_of(surface, unposed(photos), [pair])
        assert placed_by_neighbours(scene, [placed(photos, 0)], left)[1] == left
    scene = scene_of(surface, unposed(photos), [common(photos, xyz, 0, 1)[0]])
    assert placed_by_neighbours(scene, [placed(photos, 0)], [copy])[1] == [copy]


def test_a_place_that_contradicts_the_approximate_pose_is_refused(street):
    surface, photos, xyz = street
    far = replace(photos[1].pose, t=photos[1].pose.t + np.array([10.0, 0.0, 0.0]))
    prior = Estimate(far, np.diag([1.0] * 3 + [0.1] * 3) ** 2, 0.0)
    given = [photos[0], replace(photos[1], local_from_camera=prior), photos[2]]
    left = [Unoriented("1.jpg", "O101", "why")]
    scene = scene_of(surface, given, [common(photos, xyz, 0, 1)[0]])
    assert placed_by_neighbours(scene, [placed(photos, 0)], left)[1] == left


def test_a_neighbour_with_false_matches_only_has_no_say(street):
    surface, photos, xyz = street
    true, false = common(photos, xyz[::4], 0, 1)[0], common(photos, xyz, 1, 2, wrong=1.0)[0]
    assert 0.7 * len(true.pixels) < 0.3 * (len(true.pixels) + len(false.pixels))
    scene = scene_of(surface, unposed(photos), [true, false])
    left = [Unoriented("1.jpg", "O102", "why")]
    parts, rest = placed_by_neighbours(scene, [placed(photos, 0, 2)], left)
    assert not rest and np.linalg.norm(parts[-1].photos[0].pose.t - photos[1].pose.t) < 0.03
