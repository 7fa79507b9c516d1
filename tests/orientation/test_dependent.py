"""Weights and covariances hold when the errors of neighbouring observations are alike."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.orientation.adjustment import (
    AdjustmentOptions,
    Dependence,
    ImageObservations,
    Network,
    Photos,
    adjust,
    bundle,
    control_rows,
)
from frontage.orientation.adjustment.dependent import alike_groups
from orientation.adjustment.blocks import PINHOLE, disturbed, looking, pose_error, visible

SIGMA = 0.5
CLUSTERS, EACH, SIZE = 100, 8, 0.3
PLAIN = AdjustmentOptions(loss="none", snooping=False)
ALIKE = Dependence({0: SIZE}, frozenset({0}), frozenset({0}))


def network(seed, own=0.0, shared=0.0, crowd=1):
    """Photos of control points in clusters, a fifth of which have `crowd` times as many points.

    Of the variance, `own` is common to a cluster in one photo and `shared` to a cluster in all of them.
    Returns the network and its true poses.
    """
    rng = np.random.default_rng(seed)
    poses = tuple(
        looking([x, -12.0, 2.0 + abs(x) / 4], [0.4 * x, 0.0, 6.0], name=f"P{x}") for x in (-6, 0, 6)
    )
    each = np.where(np.arange(CLUSTERS) < CLUSTERS // 5, EACH * crowd, EACH)
    cluster = np.repeat(np.arange(CLUSTERS), each)
    middle = rng.uniform([-9.0, 0.0, 1.0], [9.0, 3.0, 11.0], (CLUSTERS, 3))
    xyz = middle[cluster] + rng.uniform(-0.1, 0.1, (len(cluster), 3)) * SIZE
    photo, point, pixels = visible(poses, (PINHOLE,), np.zeros(3, int), xyz)
    in_photo = rng.normal(size=(3, CLUSTERS, 2))[photo, cluster[point]]
    in_all = rng.normal(size=(CLUSTERS, 2))[cluster[point]]
    alone = rng.normal(size=pixels.shape)
    error = np.sqrt(own) * in_photo + np.sqrt(shared) * in_all + np.sqrt(1 - own - shared) * alone
    pixels = pixels + SIGMA * error
    images = ImageObservations(photo, point, pixels, np.full(len(photo), SIGMA), np.zeros(len(photo), int))
    held = control_rows(np.arange(len(xyz)), xyz, np.eye(3) * 1e-8, 1)
    start = tuple(disturbed(p, rng, 0.01, 0.001) for p in poses)
    return Network(start, (PINHOLE,), Photos.free(np.zeros(3, np.int64)), xyz, images, held), poses


def errors(found, poses):
    """Errors (p, 6) of poses."""
    return np.array([pose_error(e.value, p) for e, p in zip(found.poses, poses, strict=True)])


def normalised(found, poses):
    """The squared normalised error of all poses together, 1 on average when covariances are right."""
    x = errors(found, poses).ravel()
    return x @ np.linalg.solve(found.covariance, x) / len(x)


@pytest.mark.parametrize(("own", "shared"), [(0.6, 0.0), (0.0, 0.6), (0.3, 0.4)])
def test_errors_that_are_alike_do_not_make_poses_too_certain(own, shared):
    plain, told = [], []
    for seed in range(6):
        net, poses = network(seed, own, shared)
        plain.append(normalised(adjust(net, PLAIN), poses))
        told.append(normalised(adjust(net, PLAIN, ALIKE), poses))
    assert np.mean(plain) > 2.5
    assert 0.7 < np.mean(told) < 1.35


def test_the_shares_of_the_variance_are_found():
    found = []
    for seed in range(4):
        net, _ = network(40 + seed, own=0.3, shared=0.4)
        found.append(variogram_of(net))
    assert np.mean([v.own.sum() for v in found]) == pytest.approx(0.3, abs=0.08)
    assert np.mean([v.shared.sum() for v in found]) == pytest.approx(0.4, abs=0.08)


def test_no_more_is_alike_over_a_longer_range_where_errors_fade():
    fading = replace(ALIKE, fading=frozenset({0}))
    rising, sums = 0, []
    for seed in range(4):
        net, _ = network(60 + seed, own=0.3, shared=0.4)
        free, told = variogram_of(net), variogram_of(net, fading)
        rising += (np.diff(free.shared) > 1e-9).any() or (np.diff(free.own) > 1e-9).any()
        assert (np.diff(told.shared) < 1e-9).all() and (np.diff(told.own) < 1e-9).all()
        sums.append([told.own.sum(), told.shared.sum()])
    assert rising  # residuals hardly tell a long range from a longer one
    assert np.mean(sums, axis=0) == pytest.approx([0.3, 0.4], abs=0.1)


def test_residuals_are_not_asked_what_is_alike_over_more_than_the_object():
    wide = Dependence({0: 3.0}, frozenset({0}), frozenset({0}))  # the third range is more than the wall
    fading = replace(wide, fading=frozenset({0}), least={0: 0.001})
    asked = 0.0
    for seed in range(4):
        net, _ = network(80 + seed, own=0.3, shared=0.4)
        free, told = variogram_of(net, wide), variogram_of(net, fading)
        asked += free.own[2:].sum() + free.shared[2:].sum()
        assert not told.own[2:].any() and not told.shared[2]
        assert told.shared[3] == pytest.approx((0.001 / 0.0035) ** 2, rel=0.3)  # as stated
        assert told.shared[0] > 0
    assert asked > 0.01


def variogram_of(net, dependence=ALIKE):
    """The variogram of the control of a network."""
    with pytest.MonkeyPatch.context() as patch:
        told = []
        patch.setattr(bundle, "alike_groups", lambda *a: told.append(alike_groups(*a)) or told[-1])
        adjust(net, PLAIN, dependence)
    (group,) = told[0]
    return group.variogram


def test_independent_errors_leave_standard_errors_as_they_are():
    ratios, squared = [], []
    for seed in range(4):
        net, poses = network(100 + seed)
        plain, told = adjust(net, PLAIN), adjust(net, PLAIN, ALIKE)
        ratios += [b.sigma / a.sigma for a, b in zip(plain.poses, told.poses, strict=True)]
        squared.append(normalised(told, poses))
        assert np.array_equal(plain.redundancy, told.redundancy, equal_nan=True)
    assert 0.9 < np.sqrt(np.mean(np.square(ratios))) < 1.2
    # What is found alike by chance cannot be less than nothing: standard errors are a fifth too large.
    assert 0.6 < np.mean(squared) < 1.3


def test_a_crowd_that_errs_together_does_not_outweigh_the_others():
    plain, told = [], []
    for seed in range(5):
        net, poses = network(200 + seed, own=0.3, shared=0.5, crowd=12)
        plain.append(errors(adjust(net, PLAIN), poses))
        told.append(errors(adjust(net, PLAIN, ALIKE), poses))
    # A crowd of 96 points is one measurement, as a cluster of 8 is.
    assert np.sqrt(np.mean(np.square(told))) < 0.8 * np.sqrt(np.mean(np.square(plain)))


def test_points_lie_as_surely_as_the_photos_say():
    net, _ = network(5, own=0.7)
    plain, told = adjust(net, PLAIN), adjust(net, PLAIN, ALIKE)
    assert np.isfinite(told.sigma_points).all()
    assert (told.sigma_points >= 0.99 * plain.sigma_points).all()


def test_what_is_alike_over_long_ranges_is_an_error_of_all_photos():
    net, _ = network(3, shared=0.5)
    far = Dependence(ALIKE.reach, ALIKE.own, ALIKE.shared, {0: 1.0})
    seen, told = adjust(net, PLAIN, ALIKE), adjust(net, PLAIN, far)
    for a, b in zip(seen.poses, told.poses, strict=True):
        assert np.array_equal(a.value.t, b.value.t)  # no place is trusted less than another
    added = (told.covariance - seen.covariance).reshape(3, 6, 3, 6)[:, 0, :, 0]
    sigma = np.sqrt(np.diag(added))
    # the root of half the variance of 0.5 px is 0.35 px, and a pixel 6 mm at 12 m: 2 mm, and a turn
    assert (sigma > 0.0015).all() and (sigma < 0.01).all()
    alike = added / np.outer(sigma, sigma)
    assert alike[0, 1] > 0.5 and alike[1, 2] > 0.5  # they see the same part of the wall


def test_neighbours_are_displaced_together_by_at_least_what_is_stated():
    net, _ = network(4)
    least = Dependence(ALIKE.reach, ALIKE.own, ALIKE.shared, least={0: 0.005})
    seen, told = adjust(net, PLAIN, ALIKE), adjust(net, PLAIN, least)
    added = (told.covariance - seen.covariance).reshape(3, 6, 3, 6)[:, 0, :, 0]
    sigma = np.sqrt(np.diag(added))
    # The wall is about two ranges of 3.6 m wide and high: a few independent displacements of 5 mm.
    assert (sigma > 0.001).all() and (sigma < 0.02).all()
    # half a pixel is 3.5 mm at 14 m
    assert variogram_of(net, least).shared[-1] == pytest.approx((0.005 / 0.0035) ** 2, rel=0.15)


def test_what_is_alike_over_all_of_the_object_takes_no_weight_from_its_group():
    net, _ = network(6)
    wide = Dependence({0: 3.0}, frozenset({0}), frozenset({0}))  # 12 times as far is more than the wall
    seen = adjust(net, PLAIN, wide)
    told = adjust(net, PLAIN, Dependence(wide.reach, wide.own, wide.shared, least={0: 0.005}))
    for a, b in zip(seen.poses, told.poses, strict=True):
        assert np.array_equal(a.value.t, b.value.t)
        assert (b.sigma[:3] > a.sigma[:3]).all()
