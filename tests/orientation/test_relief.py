"""A scan that shows a wall before or behind its place errs in control points and surfaces alike."""

from dataclasses import replace

import numpy as np

from frontage.orientation.adjustment import (
    AdjustmentOptions,
    Dependence,
    ImageObservations,
    Network,
    Photos,
    PointObservations,
    adjust,
    control_rows,
)
from orientation.adjustment.blocks import PINHOLE, disturbed, looking, pose_error, visible

CONTROL, TIES, HELD, SURFACES = range(4)
PLAIN = AdjustmentOptions(loss="none", snooping=False)
POINTS = 500
SIGMA_PX, SIGMA_M, BULGE_M, SIZE_M = 0.3, 0.002, 0.006, 2.0
INTO = np.array([0.0, 1.0, 0.0])
REACH = {CONTROL: 0.5, SURFACES: 0.5}
APART = Dependence(REACH, frozenset({CONTROL}), frozenset({CONTROL, SURFACES}))
RELATED = replace(APART, relief=(SURFACES, CONTROL))


def bulging_wall(seed):
    """Photos, close to a flat wall of which the scan shows every 2 m somewhere else; and their true poses."""
    rng = np.random.default_rng(seed)
    poses = tuple(looking([x, -6.0, 1.7], [x, 0.0, 3.5], name=f"P{x}") for x in (-4, -2, 0, 2, 4))
    xyz = np.column_stack([rng.uniform(-7, 7, POINTS), np.zeros(POINTS), rng.uniform(0.5, 7.5, POINTS)])
    bulge = BULGE_M * rng.normal(size=(20, 20))
    column, row = np.floor(xyz[:, [0, 2]] / SIZE_M).astype(int).T
    scanned = xyz + (bulge[column, row] + SIGMA_M * rng.normal(size=len(xyz)))[:, None] * INTO
    photo, point, pixels = visible(poses, (PINHOLE,), np.zeros(len(poses), int), xyz)
    pixels = pixels + SIGMA_PX * rng.normal(size=pixels.shape)
    is_tie = point % 2 == 0
    group = np.where(is_tie, TIES, CONTROL)
    images = ImageObservations(photo, point, pixels, np.full(len(photo), SIGMA_PX), group)
    held, ties = np.arange(1, POINTS, 2), np.arange(0, POINTS, 2)
    normal, sigma = np.tile(INTO, (len(ties), 1)), np.full(len(ties), SIGMA_M)
    flat = PointObservations(ties, normal, scanned[ties], sigma, np.full(len(ties), SURFACES))
    rows = PointObservations.joined(control_rows(held, scanned[held], np.eye(3) * 1e-8, HELD), flat)
    start = tuple(disturbed(p, rng, 0.01, 0.001) for p in poses)
    return Network(start, (PINHOLE,), Photos.free(np.zeros(len(poses), int)), scanned, images, rows), poses


def normalised(found, poses):
    """The mean squared normalised error of a photo, 1 when covariances are right."""
    errors = [pose_error(e.value, p) for e, p in zip(found.poses, poses, strict=True)]
    told = zip(errors, found.poses, strict=True)
    return np.mean([x @ np.linalg.solve(e.covariance, x) / 6 for x, e in told])


def test_control_points_err_with_the_surface_that_they_lie_on():
    apart, related = [], []
    for seed in range(4):
        net, poses = bulging_wall(seed)
        apart.append(normalised(adjust(net, PLAIN, APART), poses))
        related.append(normalised(adjust(net, PLAIN, RELATED), poses))
    assert np.mean(apart) > 1.6
    assert 0.5 < np.mean(related) < 1.3


def test_it_changes_what_poses_are_worth_and_not_the_poses():
    net, _ = bulging_wall(20)
    apart, related = adjust(net, PLAIN, APART), adjust(net, PLAIN, RELATED)
    for a, b in zip(apart.poses, related.poses, strict=True):
        assert np.array_equal(a.value.t, b.value.t)
        assert (b.sigma[:3] > 1.1 * a.sigma[:3]).any()
    without = adjust(net, PLAIN, replace(RELATED, reach={CONTROL: 0.5}))
    assert np.isfinite(without.covariance).all()  # nothing tells how the scan is displaced: as before
