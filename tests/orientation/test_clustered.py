"""Covariances hold when the errors of neighbouring observations are alike."""

import numpy as np
import pytest

from frontage.orientation.adjustment import (
    AdjustmentOptions,
    Dependence,
    ImageObservations,
    Network,
    Photos,
    adjust,
    control_rows,
)
from orientation.adjustment.blocks import PINHOLE, disturbed, looking, pose_error, visible

SIGMA = 0.5
CLUSTERS, EACH = 48, 8
PLAIN = AdjustmentOptions(loss="none", snooping=False)


def network(seed, share):
    """Photos of control points that lie in clusters; `share` of the variance is common to a cluster in a
    photo. Returns the network, its true poses, and the cluster of every point."""
    rng = np.random.default_rng(seed)
    poses = tuple(
        looking([x, -12.0, 2.0 + abs(x) / 4], [0.4 * x, 0.0, 6.0], name=f"P{x}") for x in (-6, 0, 6)
    )
    cluster = np.repeat(np.arange(CLUSTERS), EACH)
    middle = rng.uniform([-9.0, 0.0, 1.0], [9.0, 3.0, 11.0], (CLUSTERS, 3))
    xyz = middle[cluster] + rng.uniform(-0.3, 0.3, (len(cluster), 3))
    photo, point, pixels = visible(poses, (PINHOLE,), np.zeros(3, int), xyz)
    shared = rng.normal(size=(3, CLUSTERS, 2))[photo, cluster[point]]
    own = rng.normal(size=pixels.shape)
    pixels = pixels + SIGMA * (np.sqrt(share) * shared + np.sqrt(1 - share) * own)
    images = ImageObservations(photo, point, pixels, np.full(len(photo), SIGMA), np.zeros(len(photo), int))
    held = control_rows(np.arange(len(xyz)), xyz, np.eye(3) * 1e-8, 1)
    start = tuple(disturbed(p, rng, 0.01, 0.001) for p in poses)
    return Network(start, (PINHOLE,), Photos.free(np.zeros(3, np.int64)), xyz, images, held), poses, cluster


def dependence(cluster, displacement=0.0, reach=5.0):
    return Dependence(cluster, np.full(len(cluster), displacement), reach)


def normalised(found, poses):
    """Squared normalised errors (p,), 1 on average when covariances are right."""
    errors = [pose_error(e.value, p) for e, p in zip(found.poses, poses, strict=True)]
    return [x @ np.linalg.solve(e.covariance, x) / 6 for e, x in zip(found.poses, errors, strict=True)]


def test_errors_shared_within_clusters_do_not_make_poses_too_certain():
    plain, clustered = [], []
    for seed in range(16):
        net, poses, cluster = network(seed, share=0.7)
        plain += normalised(adjust(net, PLAIN), poses)
        clustered += normalised(adjust(net, PLAIN, dependence(cluster)), poses)
    assert np.mean(plain) > 2.0
    assert 0.7 < np.mean(clustered) < 1.4


def test_independent_errors_leave_standard_errors_as_they_are():
    ratios, squared = [], []
    for seed in range(8):
        net, poses, cluster = network(100 + seed, share=0.0)
        plain, clustered = adjust(net, PLAIN), adjust(net, PLAIN, dependence(cluster))
        ratios += [b.sigma / a.sigma for a, b in zip(plain.poses, clustered.poses, strict=True)]
        squared += normalised(clustered, poses)
        assert np.array_equal(plain.redundancy, clustered.redundancy, equal_nan=True)
    assert 0.9 < np.sqrt(np.mean(np.square(ratios))) < 1.3
    assert np.min(ratios) >= 1.0 - 1e-9
    assert 0.6 < np.mean(squared) < 1.3


def test_a_displacement_of_all_control_is_one_of_all_photos():
    net, _, cluster = network(3, share=0.0)
    none, shared = (adjust(net, PLAIN, dependence(cluster, d, reach=1e4)) for d in (0.0, 0.02))
    for a, b in zip(none.poses, shared.poses, strict=True):
        added = b.covariance - a.covariance
        assert np.diag(added)[:3] == pytest.approx(0.02**2, rel=0.02)
        assert np.abs(np.diag(added)[3:]).max() < 0.02 * np.diag(a.covariance)[3:].min()


def test_a_displacement_that_soon_changes_averages_out():
    net, _, cluster = network(4, share=0.0)
    far, near = (adjust(net, PLAIN, dependence(cluster, 0.02, reach)) for reach in (1e4, 0.5))
    for a, b in zip(far.poses, near.poses, strict=True):
        assert b.sigma[3:].min() > a.sigma[3:].min()  # neighbours that differ turn the photo


def test_points_lie_as_surely_as_the_photos_say():
    net, _, cluster = network(5, share=0.7)
    plain, clustered = adjust(net, PLAIN), adjust(net, PLAIN, dependence(cluster))
    assert np.isfinite(clustered.sigma_points).all()
    assert (clustered.sigma_points >= 0.99 * plain.sigma_points).all()
