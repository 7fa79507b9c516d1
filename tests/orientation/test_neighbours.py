"""Photos that are in no block find their place by what they share with placed ones, and are tied to them."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.geometry.rigid import rotation_angle
from frontage.model import Estimate, Exposure, MountedCamera, Photo, Rig
from frontage.orientation.neighbours import (
    placed_again,
    placed_by_neighbours,
    tied_to_neighbours,
    without_contradicted,
)
from frontage.orientation.network import TiePoints
from frontage.orientation.nouns import CommonPoints
from frontage.orientation.placed import Placed, Scene
from frontage.orientation.reflectance.surface import scanned_surface
from frontage.orientation.result import Unoriented
from frontage.orientation.ties.reasons import copy_of
from orientation.paintedwalls import LANDSCAPE, corner_of_two, looking, posed, scan_of

POSES = (looking(2.5, -7.5), looking(5.0, -8.0), looking(7.5, -6.5, heading=20.0))
WRONG = 0.3
"""Share of false matches."""


@pytest.fixture(scope="module")
def street():
    walls = corner_of_two()
    photos = [posed(pose, LANDSCAPE, f"{k}.jpg") for k, pose in enumerate(POSES)]
    xyz = np.concatenate([w.points(0.15, np.random.default_rng(2), 0.0)[0] for w in walls])
    return scanned_surface(scan_of(walls, 0.04)), photos, xyz


def common(photos, xyz, first, second, wrong=WRONG):
    """What two photos see of points, some of it in wrong places."""
    rng = np.random.default_rng([first, second])
    size = (LANDSCAPE.width, LANDSCAPE.height)
    pixels = np.stack([photos[k].project(xyz) for k in (first, second)], axis=1)
    pixels = pixels[((pixels > 0) & (pixels < size)).all((1, 2))]
    pixels += rng.normal(0, 0.2, pixels.shape)
    false = rng.random(len(pixels)) < wrong
    pixels[false, 1] = rng.uniform(0, size, (int(false.sum()), 2))
    return CommonPoints(first, second, pixels), false


def scene_of(surface, given, pairs):
    return Scene(given, surface, lambda _: pytest.fail("no picture is needed"), (), 0, print, (), pairs)


def placed(photos, *numbers):
    return Placed(np.array(numbers), tuple(photos[n] for n in numbers), TiePoints.none())


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
    found, rest = placed_again(scene, placed(photos, 0), refused)
    assert not rest and found.numbers.tolist() == [0, 1]
    assert np.linalg.norm(found.photos[1].pose.t - photos[1].pose.t) < 0.03
    cameras = (MountedCamera("left"), MountedCamera("right"))
    rig = Rig("car", cameras, (Exposure("1", ("0.jpg", "1.jpg"), (0, 1)),))
    carried = replace(scene, rigs=(rig,))
    found, rest = placed_again(carried, placed(photos, 0), refused)
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


def test_pairs_without_tie_points_are_tied_where_their_poses_agree(street):
    surface, photos, xyz = street
    (pair, false), (other, _) = common(photos, xyz, 0, 1), common(photos, xyz, 0, 2, wrong=1.0)
    scene = scene_of(surface, photos, [pair, other])
    tied = tied_to_neighbours(scene, placed(photos, 0, 1, 2))
    count = len(tied.ties.xyz)
    assert count == pytest.approx((~false).sum(), rel=0.05)  # not at the borders of what the scan shows
    near = np.linalg.norm(tied.ties.xyz[:, None] - xyz[None], axis=2).min(1)
    assert np.median(near) < 0.02 and set(tied.ties.photo.tolist()) == {0, 1}
    again = tied_to_neighbours(scene, tied)
    assert len(again.ties.xyz) == count


def test_rays_that_meet_behind_the_wall_tie_nothing(street):
    """As those of matches between different windows do, which differ by the same parallax."""
    surface, photos, xyz = street
    behind = photos[0].pose.t + 1.5 * (xyz - photos[0].pose.t)
    pair, _ = common(photos, behind, 0, 1, wrong=0.0)
    assert len(pair.pixels) > 100
    tied = tied_to_neighbours(scene_of(surface, photos, [pair]), placed(photos, 0, 1))
    assert not len(tied.ties.xyz)


def ties_of(photos, xyz, false, *numbers):
    """Tie points of some photos; those that are `false` lie far from the truth along the first one's ray."""
    origin = photos[numbers[0]].pose.t
    xyz = np.where(false[:, None], origin + 0.8 * (xyz - origin), xyz)
    pixels = np.stack([photos[k].project(xyz) for k in numbers])
    photo, point = (a.ravel() for a in np.indices(pixels.shape[:2]))
    pixels = pixels.reshape(-1, 2)
    inside = ((pixels > 0) & (pixels < (LANDSCAPE.width, LANDSCAPE.height))).all(1)
    inside &= np.bincount(point[inside], minlength=len(xyz))[point] == len(numbers)
    return TiePoints(xyz, photo[inside], point[inside], pixels[inside])


@pytest.mark.parametrize("views", [(0, 1), (0, 0, 1)])
def test_the_scan_contradicts_false_ties(street, views):
    """Their rays meet as well as those of right ones, before the wall; two of three stand in one place."""
    surface, photos, xyz = street
    chosen = [photos[k] for k in views]
    false = np.random.default_rng(5).random(len(xyz)) < 0.1
    ties = ties_of(chosen, xyz, false, *range(len(views)))
    before = replace(placed(chosen, *range(len(views))), ties=ties)
    after = without_contradicted(scene_of(surface, chosen, []), before).ties
    assert not false[after.point].any() and len(after.xyz) == len(xyz)
    assert len(after.point) == pytest.approx((~false[ties.point]).sum(), rel=0.03)


def test_ties_of_what_was_not_scanned_stay(street):
    _, photos, xyz = street
    low = scan_of(corner_of_two(), 0.04)
    low = low.take(low.xyz[:, 2] < np.median(xyz[:, 2]) - 0.5)
    high = xyz[xyz[:, 2] > np.median(xyz[:, 2])]
    ties = ties_of(photos, high, np.ones(len(high), bool), 0, 1)
    before = replace(placed(photos, 0, 1), ties=ties)
    kept = without_contradicted(scene_of(scanned_surface(low), photos, []), before).ties
    assert len(ties.point) > 50 and len(kept.point) == len(ties.point)


def test_a_pose_that_errs_keeps_its_ties(street):
    surface, photos, xyz = street
    ties = ties_of(photos, xyz, np.zeros(len(xyz), bool), 0, 1)
    off = replace(photos[1].pose, t=photos[1].pose.t + np.array([0.3, 0.0, 0.0]))
    moved = replace(photos[1], local_from_camera=replace(photos[1].local_from_camera, value=off))
    before = Placed(np.array([0, 1]), (photos[0], moved), ties)
    assert len(without_contradicted(scene_of(surface, photos, []), before).ties.point) == len(ties.point)
