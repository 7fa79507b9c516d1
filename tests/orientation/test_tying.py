"""Photos are tied to one another, and tie points left out, by what the scan shows behind them."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.orientation import views
from frontage.orientation.network import TiePoints
from frontage.orientation.placed import Placed
from frontage.orientation.reflectance.render import render
from frontage.orientation.reflectance.surface import scanned_surface
from frontage.orientation.tying import tied_to_neighbours, without_contradicted
from frontage.orientation.views import Views
from orientation.paintedwalls import LANDSCAPE, corner_of_two, looking, posed, scan_of
from orientation.sharedviews import common, painted_street, placed, scene_of


@pytest.fixture(scope="module")
def street():
    return painted_street()


def test_pairs_without_tie_points_are_tied_where_their_poses_agree(street):
    surface, photos, xyz = street
    (pair, false), (other, _) = common(photos, xyz, 0, 1), common(photos, xyz, 0, 2, wrong=1.0)
    scene = scene_of(surface, photos, [pair, other])
    before = placed(photos, 0, 1, 2)
    tied = tied_to_neighbours(scene, before, Views(scene, [before]))
    count = len(tied.ties.xyz)
    assert count == pytest.approx((~false).sum(), rel=0.05)  # not at the borders of what the scan shows
    near = np.linalg.norm(tied.ties.xyz[:, None] - xyz[None], axis=2).min(1)
    assert np.median(near) < 0.02 and set(tied.ties.photo.tolist()) == {0, 1}
    again = tied_to_neighbours(scene, tied, Views(scene, [tied]))
    assert len(again.ties.xyz) == count


def test_rays_that_meet_behind_the_wall_tie_nothing(street):
    """As those of matches between different windows do, which differ by the same parallax."""
    surface, photos, xyz = street
    behind = photos[0].pose.t + 1.5 * (xyz - photos[0].pose.t)
    pair, _ = common(photos, behind, 0, 1, wrong=0.0)
    assert len(pair.pixels) > 100
    scene, before = scene_of(surface, photos, [pair]), placed(photos, 0, 1)
    assert not len(tied_to_neighbours(scene, before, Views(scene, [before])).ties.xyz)


def left_of(surface, before):
    """The tie points that are left."""
    scene = scene_of(surface, before.photos, [])
    return without_contradicted(before, Views(scene, [before])).ties


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
    after = left_of(surface, before)
    assert not false[after.point].any() and len(after.xyz) == len(xyz)
    assert len(after.point) == pytest.approx((~false[ties.point]).sum(), rel=0.03)


def test_ties_of_what_was_not_scanned_stay(street):
    _, photos, xyz = street
    low = scan_of(corner_of_two(), 0.04)
    low = low.take(low.xyz[:, 2] < np.median(xyz[:, 2]) - 0.5)
    high = xyz[xyz[:, 2] > np.median(xyz[:, 2])]
    ties = ties_of(photos, high, np.ones(len(high), bool), 0, 1)
    before = replace(placed(photos, 0, 1), ties=ties)
    kept = left_of(scanned_surface(low), before)
    assert len(ties.point) > 50 and len(kept.point) == len(ties.point)


def test_a_pose_that_errs_keeps_its_ties(street):
    surface, photos, xyz = street
    ties = ties_of(photos, xyz, np.zeros(len(xyz), bool), 0, 1)
    off = replace(photos[1].pose, t=photos[1].pose.t + np.array([0.3, 0.0, 0.0]))
    moved = replace(photos[1], local_from_camera=replace(photos[1].local_from_camera, value=off))
    before = Placed(np.array([0, 1]), (photos[0], moved), ties)
    assert len(left_of(surface, before).point) > 0.95 * len(ties.point)


def test_photos_that_agree_keep_a_point_that_one_photo_contradicts(street):
    """One photo shows something else of the same row: the three others stay tied."""
    surface, _, xyz = street
    poses = [looking(x, -7.5) for x in (1.5, 2.5, 3.5, 4.5)]
    chosen = [posed(pose, LANDSCAPE, f"{k}.jpg") for k, pose in enumerate(poses)]
    none = np.zeros(len(xyz), bool)
    ties = ties_of(chosen, xyz, none, 0, 1, 2, 3)
    wrong = (ties.photo == 3) & (ties.point % 7 == 0)
    pixels = ties.pixels + np.where(wrong[:, None], [25.0, 0.0], 0.0)
    before = replace(placed(chosen, 0, 1, 2, 3), ties=replace(ties, pixels=pixels))
    after = left_of(surface, before)
    left = set(zip(after.photo.tolist(), after.point.tolist(), strict=True))
    rows = list(zip(ties.photo.tolist(), ties.point.tolist(), strict=True))
    kept = np.array([row in left for row in rows])
    assert wrong.sum() > 30 and not kept[wrong].any() and kept[~wrong].mean() > 0.97


def test_photos_are_drawn_once_for_all_that_the_scan_is_asked(street, monkeypatch):
    surface, photos, xyz = street
    drawn = []
    monkeypatch.setattr(views, "render", lambda photo, *rest: drawn.append(photo.id) or render(photo, *rest))
    ties = ties_of(photos, xyz, np.zeros(len(xyz), bool), 0, 1)
    before = replace(placed(photos, 0, 1, 2), ties=ties)
    scene = scene_of(surface, photos, [common(photos, xyz, 0, 2)[0], common(photos, xyz, 1, 2)[0]])
    known = Views(scene, [before])
    without_contradicted(tied_to_neighbours(scene, before, known), known)
    assert sorted(drawn) == ["0.jpg", "1.jpg", "2.jpg"]


@pytest.mark.parametrize("away", [6.0, 24.0])
def test_distances_are_told_in_their_standard_errors(street, away):
    """Half of all distances are below 1.18, those of wide pixels far away as well as of small ones."""
    surface, _, xyz = street
    rng = np.random.default_rng(3)
    pair = [posed(looking(x, -away, heading=turn), LANDSCAPE, "") for x, turn in ((2.0, 10.0), (6.0, -10.0))]
    ties = ties_of(pair, xyz, np.zeros(len(xyz), bool), 0, 1)
    pixels = ties.pixels.reshape(2, -1, 2).swapaxes(0, 1) + rng.normal(0, 0.5, (len(ties.photo) // 2, 2, 2))
    before = placed(pair, 0, 1)
    off = Views(scene_of(surface, pair, []), [before]).off(0, 1, pixels)
    off = off[np.isfinite(off)]
    assert len(off) > 300 and 0.9 < np.median(off) < 1.3 and (off > 3.72).mean() < 0.02


def test_ties_of_a_pair_that_are_false_for_the_most_part_are_left_out(street):
    """Errors of the poses put all points off alike; here the nearest quarter is where it should be."""
    surface, photos, xyz = street
    false = np.random.default_rng(6).random(len(xyz)) < 0.65
    before = replace(placed(photos, 0, 1), ties=ties_of(photos, xyz, false, 0, 1))
    after = left_of(surface, before)
    assert not false[after.point].any()
    assert len(after.point) >= 0.95 * (~false[before.ties.point]).sum()
