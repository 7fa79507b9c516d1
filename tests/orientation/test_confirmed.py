"""Tie points that a third photo or the scan confirms are believed more than those that nothing confirms."""

import numpy as np
import pytest

from frontage.orientation.adjusted import AdjustedPhotos
from frontage.orientation.adjustment import AdjustmentOptions, adjust
from frontage.orientation.control import ControlPoints
from frontage.orientation.network import (
    TIES,
    TIES_NEVER,
    TIES_ONCE,
    TiePoints,
    build_network,
    by_confirmation,
)
from frontage.orientation.placed import Placed
from frontage.orientation.reflectance.surface import scanned_surface
from orientation.paintedwalls import Wall, looking, paint, posed, scan_of

FRONT = Wall((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), paint(12.0, 4.0))
SURFACE = scanned_surface(scan_of((FRONT,), 0.03))
PHOTOS = [posed(looking(x, -8.0), name=f"P{x}") for x in (4.0, 5.0, 6.0, 7.0)]
KNOWN = AdjustmentOptions(loss="none", snooping=False)


def places(count, rng, *, scanned):
    """Points (count, 3) m on the wall, or above it where nothing was scanned."""
    x, z = rng.uniform(3.0, 8.0, count), rng.uniform(0.5, 3.5, count)
    above = np.column_stack([x, rng.uniform(-1.5, 1.5, count), z * 0.4 + 4.1])
    return np.column_stack([x, np.zeros(count), z]) if scanned else above


def ties(parts, rng):
    """Tie points of parts: places (n, 3) m, the photos that show them, and the errors of their pixels."""
    found, start = [], 0
    for xyz, photos, error in parts:
        shown = np.concatenate([PHOTOS[k].project(xyz) for k in photos])
        pixels = shown + rng.normal(0, error, shown.shape)
        numbers = np.tile(np.arange(start, start + len(xyz)), len(photos))
        found.append(TiePoints(xyz, np.repeat(photos, len(xyz)), numbers, pixels))
        start += len(xyz)
    return TiePoints.joined(found)


def nothing():
    """No control points."""
    none = np.empty(0)
    two, three = np.empty((0, 2)), np.empty((0, 3))
    return ControlPoints(two, three, none, none, none, two, np.empty(0, bool), 0, 1.0)


def control(photo, rng):
    """Precise control points of a photo."""
    xyz = places(60, rng, scanned=True)
    pixels = photo.project(xyz) + rng.normal(0, 0.02, (60, 2))
    one = np.ones(60)
    return ControlPoints(pixels, xyz, 0.02 * one, one, 40 * one, 0 * pixels, one > 0, 60, 5.0)


def groups(counts, rng):
    """The groups of the measurements of points with three rays or two, on the scan or off it."""
    kinds = (((0, 1, 2), True), ((0, 1, 2), False), ((0, 1), True), ((0, 1), False))
    parts = [(places(n, rng, scanned=s), k, 0.1) for n, (k, s) in zip(counts, kinds, strict=True)]
    made = ties(parts, rng)
    images = by_confirmation(build_network(PHOTOS, made, [nothing()] * 4, SURFACE)).images
    ends = np.cumsum(counts)[:-1]
    kinds = np.split(np.arange(sum(counts)), ends)
    return [set(images.group[np.isin(images.point, kind)].tolist()) for kind in kinds]


def test_ties_are_grouped_by_what_confirms_them():
    rng = np.random.default_rng(0)
    assert groups((50, 50, 50, 50), rng) == [{TIES}, {TIES_ONCE}, {TIES_ONCE}, {TIES_NEVER}]


def test_ties_have_one_variance_as_long_as_control_may_outvote_them():
    """False ties that are believed less would move their photo too little to be found out."""
    made = ties(
        [(places(50, np.random.default_rng(0), scanned=False), (0, 1), 0.1)], np.random.default_rng(0)
    )
    assert set(build_network(PHOTOS, made, [nothing()] * 4, SURFACE).images.group.tolist()) == {TIES}


def test_groups_that_are_too_small_for_a_variance_join_others():
    rng = np.random.default_rng(0)
    assert groups((50, 50, 50, 30), rng) == [{TIES}, {TIES_ONCE}, {TIES_ONCE}, {TIES_ONCE}]
    assert groups((50, 5, 5, 5), rng) == [{TIES}] * 4
    assert groups((5, 5, 50, 50), rng) == [{TIES}, {TIES}, {TIES}, {TIES_NEVER}]


def end_of_row(seed):
    """A network whose last photo is held by few good ties and by many that two photos show off the scan."""
    rng = np.random.default_rng(seed)
    made = ties(
        [
            (places(300, rng, scanned=True), (0, 1, 2), 0.1),
            (places(40, rng, scanned=True), (1, 2, 3), 0.1),
            (places(80, rng, scanned=False), (2, 3), 0.6),
        ],
        rng,
    )
    found = [control(photo, rng) for photo in PHOTOS[:3]] + [nothing()]
    return by_confirmation(build_network(PHOTOS, made, found, SURFACE)), made, found


def test_a_photo_that_unconfirmed_ties_hold_has_honest_standard_errors():
    squared, off = [], []
    for seed in range(12):
        network, _, _ = end_of_row(seed)
        pose = adjust(network, KNOWN).photo_pose(3)
        error = pose.value.t - PHOTOS[3].pose.t
        squared.append(error @ np.linalg.solve(pose.covariance[:3, :3], error) / 3)
        off.append(np.linalg.norm(error))
    assert 0.5 < np.mean(squared) < 1.6
    assert 0.004 < np.mean(off) < 0.015  # 21 mm with one variance for all, and a squared error of 9


def test_ties_of_all_groups_support_a_photo():
    network, made, found = end_of_row(0)
    placed = Placed(np.arange(4), tuple(PHOTOS), made)
    state = AdjustedPhotos(placed, tuple(found), network, adjust(network, KNOWN))
    assert len(state.ties_of(3)) == pytest.approx(120, abs=3)
    assert state.ties.sum() == pytest.approx(900 + 120 + 160, abs=6)
