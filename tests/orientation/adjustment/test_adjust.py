"""The adjustment on simulated blocks: values, covariances, datum, rigs, self-calibration."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from frontage.errors import InputError
from frontage.geometry.rigid import Rigid3
from frontage.model.estimate import Estimate
from frontage.model.photo import Camera
from frontage.orientation.adjustment import (
    AdjustmentOptions,
    ImageObservations,
    NotDetermined,
    Photos,
    PointObservations,
    adjust,
    control_rows,
)
from frontage.orientation.adjustment.layout import layout_of
from frontage.orientation.adjustment.linearise import linearise, residuals
from frontage.orientation.adjustment.robust import plain_weights
from frontage.orientation.adjustment.state import State
from orientation.adjustment.blocks import facade_block, pose_error, rig_block, visible

PLAIN = AdjustmentOptions(loss="none", snooping=False, variance_components=False)


def _squared(errors, covariances):
    return np.einsum("ni,nij,nj->n", errors, np.linalg.inv(covariances), errors)


def _pose_errors(found, block):
    return np.array([pose_error(p.value, t) for p, t in zip(found.poses, block.poses, strict=True)])


def test_errors_match_their_covariances_over_30_blocks():
    poses, points = [], []
    for seed in range(30):
        block = facade_block(seed, photos=6, points=80, control=10)
        found = adjust(block.network)
        assert found.reason.startswith("converged") and found.datum_defect == 0
        assert found.rejected.sum() <= 2
        poses.append(_squared(_pose_errors(found, block), np.array([p.covariance for p in found.poses])))
        errors = (found.points - block.points)[found.determined]
        points.append(_squared(errors, found.point_covariance[found.determined]))
    assert 0.8 < np.concatenate(poses).mean() / 6 < 1.25
    assert 0.8 < np.concatenate(points).mean() / 3 < 1.25


def _dense_design(network, found):
    """Jacobian of all used rows in sigmas, unknowns: columns of bodies and cameras, then points."""
    state = State(
        np.array([p.value.R for p in found.poses]),
        np.array([p.value.t for p in found.poses]),
        tuple(c.value for c in found.cameras),
        np.array([m.value.R for m in found.mounts]),
        np.array([m.value.t for m in found.mounts]),
        found.points,
    )
    layout = layout_of(network, found.used, found.surface_used, found.determined)
    weights = plain_weights(network, layout, found.factors)
    rows = linearise(network, state, layout, weights, residuals(network, state))
    u, m = layout.columns, len(layout.rows)
    J = np.zeros((2 * m + len(layout.surface_rows), u + 3 * len(layout.points)))
    for i in range(m):
        columns = layout.photo_columns[layout.photo[i]]
        own = columns < u
        J[2 * i : 2 * i + 2, columns[own]] = rows.wide[i][:, own]
        J[2 * i : 2 * i + 2, u + 3 * layout.slot[i] : u + 3 * layout.slot[i] + 3] = rows.point[i]
    for k, slot in enumerate(layout.surface_slot):
        J[2 * m + k, u + 3 * slot : u + 3 * slot + 3] = rows.surface[k]
    return J, layout


@pytest.mark.parametrize("calibrated", [True, False])
def test_covariances_and_redundancies_are_those_of_the_dense_inverse(calibrated):
    sigmas = () if calibrated else (np.full(4, np.inf),)
    network = facade_block(1, photos=5, points=40, control=8, camera_sigmas=sigmas).network
    found = adjust(network, PLAIN)
    J, layout = _dense_design(network, found)
    inverse = np.linalg.inv(J.T @ J)
    np.testing.assert_allclose(found.covariance, inverse[: layout.columns, : layout.columns], rtol=1e-6)
    own = inverse[layout.columns :, layout.columns :]
    for slot, point in enumerate(layout.points):
        block = own[3 * slot : 3 * slot + 3, 3 * slot : 3 * slot + 3]
        np.testing.assert_allclose(found.point_covariance[point], block, rtol=1e-6, atol=1e-14)
    redundancy = 1 - np.einsum("ij,jk,ik->i", J, inverse, J)
    m = 2 * len(layout.rows)
    np.testing.assert_allclose(found.redundancy[layout.rows].ravel(), redundancy[:m], atol=1e-8)
    np.testing.assert_allclose(found.surface_redundancy[layout.surface_rows], redundancy[m:], atol=1e-8)
    assert redundancy.sum() == pytest.approx(found.dof, abs=1e-6)


def test_redundancies_add_up_with_priors_and_calibration():
    block = rig_block(2)
    covariance = np.diag([0.1, 0.1, 0.1, 0.02, 0.02, np.inf])
    priors = tuple(Estimate(p, covariance, 1.0) if i % 2 else None for i, p in enumerate(block.poses))
    sigmas = (np.array([5.0, 5.0, 0.0, 0.0]), np.array([np.inf, 5.0, 0, 0, 0.01, 0.01, 0, 0]))
    found = adjust(replace(block.network, pose_priors=priors, camera_sigmas=sigmas))
    total = np.nansum(found.redundancy) + np.nansum(found.surface_redundancy)
    total += found.prior_redundancy.sum() + found.camera_redundancy.sum()
    assert total == pytest.approx(found.dof, abs=1e-6)
    assert np.count_nonzero(found.prior_redundancy) == 2
    assert found.camera_redundancy[2] == 0  # the free focal length has no prior
    assert (found.cameras[0].covariance[2:] == 0).all() and (
        np.diag(found.cameras[0].covariance)[:2] > 0
    ).all()
    assert 0.9 < found.sigma0 < 1.1


def test_a_rig_of_three_cameras_is_one_body():
    block = rig_block(5)
    found = adjust(block.network)
    assert len(found.poses) == 5 and found.datum_defect == 0
    ratio = _squared(_pose_errors(found, block), np.array([p.covariance for p in found.poses])) / 6
    assert 0.4 < ratio.mean() < 1.9
    photo = found.photo_pose(2)
    expected = block.poses[0].after(block.network.photos.body_from_camera[2])
    error = pose_error(photo.value, expected)
    assert error @ np.linalg.solve(photo.covariance, error) / 6 < 3.0
    # The covariance at the end of the lever arm, from random poses of the body.
    rng = np.random.default_rng(0)
    draws = rng.multivariate_normal(np.zeros(6), found.poses[0].covariance, 4000)
    body, mounted = found.poses[0].value, block.network.photos.body_from_camera[2]
    turns = Rotation.from_rotvec(draws[:, 3:]).as_matrix()
    moved = [
        pose_error(Rigid3("local", "b", W @ body.R, body.t + d[:3]).after(mounted), photo.value)
        for W, d in zip(turns, draws, strict=True)
    ]
    np.testing.assert_allclose(np.std(moved, axis=0), photo.sigma, rtol=0.06)


def _with_mounts(block, seed, covariance, free=(1, 2)):
    """The network with mounts of some cameras wrong by what is unknown of them, and the true mounts."""
    rng = np.random.default_rng(seed)
    photos = block.network.photos
    true = [m.value for m in photos.mounts]
    finite = np.where(np.isfinite(covariance), covariance, 0.0)
    mounts = list(photos.mounts)
    for k in free:
        shift = rng.multivariate_normal(np.zeros(6), finite)
        turn = Rotation.from_rotvec(shift[3:]).as_matrix()
        mounts[k] = Estimate(Rigid3("body", "C", turn @ true[k].R, true[k].t + shift[:3]), covariance, 0.0)
    return replace(block.network, photos=replace(photos, mounts=tuple(mounts))), true


def test_mounts_with_standard_errors_are_estimated():
    """True errors of mounts and of photos agree with their covariances, over several vehicles."""
    squared = [[], []]
    for seed in range(8):
        block = rig_block(20 + seed)
        network, true = _with_mounts(block, seed, np.diag([0.02**2] * 3 + [0.005**2] * 3))
        found = adjust(network)
        assert (found.mounts[0].covariance == 0).all()
        assert found.mounts[1].sigma[:3].max() < 0.015 and found.mounts[1].sigma[3:].max() < 0.002
        for k in (1, 2):
            error = pose_error(found.mounts[k].value, true[k])
            squared[0].append(error @ np.linalg.solve(found.mounts[k].covariance, error) / 6)
        for photo in range(len(network.photos)):
            estimate = found.photo_pose(photo)
            body = block.poses[network.photos.body[photo]]
            error = pose_error(estimate.value, body.after(true[network.photos.mount[photo]]))
            squared[1].append(error @ np.linalg.solve(estimate.covariance, error) / 6)
        total = np.nansum(found.redundancy) + np.nansum(found.surface_redundancy)
        assert total + found.mount_redundancy == pytest.approx(found.dof, abs=1e-6)
    assert 0.7 < np.mean(squared[0]) < 1.4 and 0.7 < np.mean(squared[1]) < 1.4


def test_unknown_mounts_are_found_without_a_prior_and_leave_the_scale_free():
    unknown = np.diag(np.full(6, np.inf))
    network, true = _with_mounts(rig_block(31), 0, unknown)
    found = adjust(network)
    assert found.datum_defect == 0
    assert pose_error(found.mounts[2].value, true[2]) == pytest.approx(0, abs=0.02)
    network, _ = _with_mounts(rig_block(32, control=0), 0, unknown)
    assert adjust(network).datum_defect == 7  # with no known distance, nothing tells the scale
    length_known = np.diag([1e-4, np.inf, np.inf, np.inf, np.inf, np.inf])
    network, _ = _with_mounts(rig_block(32, control=0), 0, length_known)
    assert adjust(network).datum_defect == 6


def test_the_covariance_of_mounts_is_that_of_the_dense_inverse():
    network, _ = _with_mounts(rig_block(33, stops=3, points=60), 0, np.diag([np.inf] * 3 + [0.0] * 3), (1,))
    found = adjust(network, PLAIN)
    J, layout = _dense_design(network, found)
    u = layout.columns
    np.testing.assert_allclose(found.covariance, np.linalg.inv(J.T @ J)[:u, :u], rtol=1e-5, atol=1e-12)
    assert (found.mounts[1].sigma > 0).tolist() == [True] * 3 + [False] * 3


def test_a_mount_whose_photos_see_nothing_is_named():
    block = rig_block(34)
    images = block.network.images
    seen = block.network.photos.mount[images.photo] != 1
    fields = ("photo", "point", "pixels", "sigma", "group")
    less = replace(images, **{f: getattr(images, f)[seen] for f in fields})
    network, _ = _with_mounts(block, 0, np.diag(np.full(6, np.inf)), (1,))
    with pytest.raises(NotDetermined, match="mounts 1") as problem:
        adjust(replace(network, images=less))
    assert problem.value.mounts == (1,) and problem.value.bodies == ()


def test_a_rig_without_control_has_a_scale_but_no_place():
    block = rig_block(6, control=0)
    found = adjust(block.network)
    assert found.datum_defect == 6
    length = np.linalg.norm(found.poses[4].value.t - found.poses[0].value.t)
    true = np.linalg.norm(block.poses[4].t - block.poses[0].t)
    assert abs(length - true) < 0.3


def test_a_free_network_satisfies_the_inner_constraints():
    block = facade_block(7, control=0, start=0.2)
    found = adjust(block.network, PLAIN)
    assert found.datum_defect == 7 and 0.9 < found.sigma0 < 1.1
    joint = found.poses_covariance.reshape(len(found.poses), 6, -1)
    assert np.abs(joint[:, :3].sum(axis=0)).max() < 1e-9 * np.abs(joint).max()  # no common shift
    J, layout = _dense_design(block.network, found)
    J = J / (scale := np.linalg.norm(J, axis=0))
    values = np.linalg.eigvalsh(J.T @ J)
    assert values[6] < 1e-12 < values[7]  # exactly seven freedoms
    # Any generalised inverse gives the same adjusted observations and relative positions.
    inverse = np.linalg.pinv(J.T @ J, rcond=1e-11, hermitian=True) / np.outer(scale, scale)
    u = layout.columns
    between = np.zeros((1, u))
    axis = found.poses[0].value.R[:, 0]
    between[0, 3:6], between[0, 9:12] = axis, -axis  # how one photo is turned against the next
    expected = between @ inverse[:u, :u] @ between.T
    assert between @ found.poses_covariance @ between.T == pytest.approx(expected, rel=1e-4)
    moved = np.mean([f.value.t - p.t for f, p in zip(found.poses, block.network.poses, strict=True)], axis=0)
    assert np.abs(moved).max() < 1e-3  # the poses keep their mean place


def test_relative_geometry_of_a_free_network_is_right():
    block = facade_block(8, control=0, photos=10, points=200)
    found = adjust(block.network)
    a = found.points[found.determined]
    b = block.points[found.determined]
    scale = np.linalg.norm(b - b.mean(0)) / np.linalg.norm(a - a.mean(0))
    turn = Rotation.align_vectors(b - b.mean(0), (a - a.mean(0)) * scale)[0]
    left = b - b.mean(0) - turn.apply((a - a.mean(0)) * scale)
    assert np.sqrt((left**2).mean()) < 0.006


def test_surfaces_alone_move_the_block_along_their_normal():
    block = facade_block(9, control=0, relief=0.0, start=0.0)
    network = block.network
    on = np.arange(60)
    plane = PointObservations(
        on,
        np.tile([0.0, 1.0, 0.0], (60, 1)),
        np.tile([0.0, 0.25, 0.0], (60, 1)),
        np.full(60, 0.002),
        np.full(60, 1),
    )
    found = adjust(replace(network, surfaces=plane))
    # A plane fixes one shift and two turns; two shifts, a turn and the scale stay with the poses.
    assert found.datum_defect == 4
    shift = np.mean([f.value.t - p.t for f, p in zip(found.poses, block.poses, strict=True)], axis=0)
    assert np.abs(found.points[on, 1] - 0.25).max() < 0.02
    assert np.abs(shift[[0, 2]]).max() < 0.01


def test_self_calibration_recovers_focal_length_and_distortion():
    camera = Camera("OPENCV", 3000, 2000, np.array([2000.0, 2005.0, 1500.0, 1000.0, -0.05, 0.01, 0.0, 0.0]))
    block = facade_block(10, photos=10, points=300, control=20, camera=camera)
    offset = np.array([25.0, 25.0, 0.0, 0.0, 0.04, 0.0, 0.0, 0.0])
    wrong = Camera("OPENCV", 3000, 2000, camera.params + offset)
    sigmas = np.array([np.inf, np.inf, 5.0, 5.0, np.inf, 0.05, 0.0, 0.0])
    found = adjust(replace(block.network, cameras=(wrong,), camera_sigmas=(sigmas,)))
    estimate = found.cameras[0]
    error = (estimate.value.params - camera.params)[:6]
    assert np.abs(error / estimate.sigma[:6]).max() < 3.5
    assert estimate.sigma[0] < 5.0 and estimate.sigma[4] < 0.005
    assert (estimate.value.params[6:] == 0).all()
    correlation = found.focal_depth_correlation()
    assert correlation.shape == (10,) and (np.abs(correlation) < 1).all() and np.abs(correlation).max() > 0.1
    assert np.isnan(adjust(block.network).focal_depth_correlation()).all()


def test_pose_priors_alone_give_the_datum():
    block = facade_block(11, control=0)
    covariance = np.diag([0.02] * 3 + [np.inf] * 3) ** 2
    rng = np.random.default_rng(0)
    measured = [Rigid3(p.to, p.frm, p.R, p.t + 0.02 * rng.standard_normal(3)) for p in block.poses]
    priors = tuple(Estimate(p, covariance, 1.0) for p in measured)
    found = adjust(replace(block.network, pose_priors=priors))
    assert found.datum_defect == 0
    ratio = _squared(_pose_errors(found, block), np.array([p.covariance for p in found.poses])) / 6
    assert 0.3 < ratio.mean() < 2.0
    assert all((p.sigma[:3] < 0.02).all() for p in found.poses)


def test_what_is_not_determined_is_told():
    block = facade_block(12)
    images = block.network.images
    few = (images.photo != 3) | (np.cumsum(images.photo == 3) <= 2)  # two points in photo 3
    with pytest.raises(NotDetermined, match="bodies 3;") as caught:
        adjust(replace(block.network, images=_rows(images, few)))
    assert caught.value.bodies == (3,) and caught.value.cameras == ()
    with pytest.raises(NotDetermined, match="bodies 3;"):
        adjust(replace(block.network, images=_rows(images, images.photo != 3)), PLAIN)


def _rows(images, mask):
    return replace(images, **{f: getattr(images, f)[mask] for f in vars(images)})


def test_points_without_enough_rays_are_left_out_and_counted():
    block = facade_block(13)
    images = block.network.images
    first = np.flatnonzero(images.point == 50)[0]
    keep = (images.point != 50) | (np.arange(len(images)) == first)
    found = adjust(replace(block.network, images=_rows(images, keep)))
    assert found.dropped == 1 and not found.determined[50]
    assert np.isnan(found.point_covariance[50]).all() and found.sigma_points.shape == (150, 3)
    np.testing.assert_array_equal(found.points[50], block.network.points[50])
    assert not found.used[images.point[keep] == 50].any() and not found.rejected.any()


def test_points_that_only_photos_of_one_place_see_are_left_out():
    rng = np.random.default_rng(1)
    block = facade_block(3, photos=8, points=150, control=12)
    there = block.poses[3]
    twin = Rigid3("local", "twin", there.R, there.t + np.array([4e-4, 0.0, 0.0]))
    photos = Photos.free(np.zeros(9, np.int64))
    xyz = rng.uniform([-8.0, 0.0, 0.0], [8.0, 2.0, 10.0], (300, 3))
    common, own = visible((*block.poses, twin), block.cameras, photos.camera, block.points), []
    mine = common[0] == 8
    own.append([part[mine] for part in common])
    photo, point, pixels = visible((there, twin), block.cameras, np.zeros(2, int), xyz)
    own.append([np.where(photo == 0, 3, 8), point + len(block.points), pixels])
    photo, point, pixels = (np.concatenate(parts) for parts in zip(*own, strict=True))
    pixels = pixels + 0.5 * rng.standard_normal(pixels.shape)
    old = block.network.images
    images = ImageObservations(
        np.concatenate([old.photo, photo]),
        np.concatenate([old.point, point]),
        np.concatenate([old.pixels, pixels]),
        np.full(len(old) + len(photo), 0.5),
        np.zeros(len(old) + len(photo), np.int64),
    )
    network = replace(
        block.network,
        poses=(*block.network.poses, block.network.poses[3]),
        photos=photos,
        points=np.concatenate([block.network.points, xyz]),
        images=images,
        pose_priors=(),
    )
    found = adjust(network)
    assert found.reason.startswith("converged") and found.iterations < 10 * found.rounds
    only = np.unique(point[point >= len(block.points)])
    assert not found.determined[only].any()
    errors = np.array(
        [pose_error(p.value, t) for p, t in zip(found.poses, (*block.poses, twin), strict=True)]
    )
    assert _squared(errors, np.array([p.covariance for p in found.poses])).mean() / 6 < 2.0


def test_points_behind_a_camera_are_counted_and_do_no_harm():
    block = facade_block(14)
    points = block.network.points.copy()
    points[60] = [0.0, -40.0, 5.0]  # behind all cameras
    found = adjust(replace(block.network, points=points))
    seen = (block.network.images.point == 60).sum()
    assert seen > 2 and found.unseen == seen and not found.determined[60]
    assert 0.9 < found.sigma0 < 1.1


def test_control_rows_follow_the_axes_of_the_covariance():
    rng = np.random.default_rng(0)
    A = rng.standard_normal((2, 3, 3))
    covariance = A @ A.transpose(0, 2, 1) + 0.1 * np.eye(3)
    rows = control_rows(np.array([4, 7]), np.zeros((2, 3)), covariance, 1)
    np.testing.assert_array_equal(rows.point, [4, 4, 4, 7, 7, 7])
    D = rows.direction.reshape(2, 3, 3)
    back = np.linalg.inv(np.einsum("cri,cr,crj->cij", D, rows.sigma.reshape(2, 3) ** -2, D))
    np.testing.assert_allclose(back, covariance, rtol=1e-9)
    with pytest.raises(InputError, match="positive definite"):
        control_rows(np.array([0]), np.zeros((1, 3)), np.diag([1.0, 1.0, 0.0]), 1)


def test_a_network_that_does_not_hang_together_is_refused():
    network = facade_block(15).network
    with pytest.raises(InputError, match="point of an image observation"):
        replace(network, points=network.points[:10])
    with pytest.raises(InputError, match="number them apart"):
        replace(network, surfaces=replace(network.surfaces, group=np.zeros(36, np.int64)))
    with pytest.raises(InputError, match="unit vector"):
        replace(network.surfaces, direction=2 * network.surfaces.direction)
    with pytest.raises(InputError, match="standard error"):
        replace(network.images, sigma=np.zeros(len(network.images)))
    with pytest.raises(InputError, match="mount of a photo"):
        replace(network, photos=replace(network.photos, mounts=()))
    with pytest.raises(ValueError, match="covariance"):
        replace(network.photos, mounts=(Estimate(Rigid3.identity("body", "camera"), np.eye(3), 0.0),))


def test_the_same_network_gives_the_same_bits():
    network = facade_block(16).network
    a, b = adjust(network), adjust(network)
    np.testing.assert_array_equal(a.points, b.points)
    np.testing.assert_array_equal(a.covariance, b.covariance)


def test_poor_approximate_values_converge():
    block = facade_block(17, start=8.0)  # 0.4 m and 4.6 degrees
    found = adjust(block.network)
    ratio = _squared(_pose_errors(found, block), np.array([p.covariance for p in found.poses])) / 6
    assert 0.3 < ratio.mean() < 2.0


def test_a_single_photo_is_resected_on_control():
    block = facade_block(18, photos=1, points=40, control=40)
    found = adjust(block.network)
    error = pose_error(found.poses[0].value, block.poses[0])
    assert error @ np.linalg.solve(found.poses[0].covariance, error) / 6 < 3.0
    assert (found.poses[0].sigma[:3] < 0.02).all() and found.dof == 2 * found.used.sum() - 6


def test_noise_of_points_on_one_wall_does_not_pass_for_a_scale():
    block = facade_block(19, control=0, relief=0.0, start=0.2)
    rng = np.random.default_rng(1)
    on = np.arange(120)
    at = block.points[on] + 0.005 * rng.standard_normal((120, 1)) * [0.0, 1.0, 0.0]
    wall = PointObservations(on, np.tile([0.0, 1.0, 0.0], (120, 1)), at, np.full(120, 0.005), np.full(120, 1))
    found = adjust(replace(block.network, surfaces=wall))
    assert found.datum_defect == 4
    length = np.linalg.norm(found.poses[-1].value.t - found.poses[0].value.t)
    assert length == pytest.approx(np.linalg.norm(block.poses[-1].t - block.poses[0].t), rel=0.01)


def test_two_blocks_without_common_points_are_told_apart():
    network = facade_block(20, control=0).network
    left = network.images.point < 75
    keep = left == (network.images.photo < 4)
    with pytest.raises(NotDetermined) as caught:
        adjust(replace(network, images=_rows(network.images, keep)), PLAIN)
    assert len(caught.value.bodies) >= 4


@pytest.mark.parametrize("count", [0, 1])
def test_a_network_with_hardly_any_observation_is_told(count):
    network = facade_block(21, control=0).network
    keep = np.arange(len(network.images)) < count
    with pytest.raises(NotDetermined, match="bodies 0, 1, 2"):
        adjust(replace(network, images=_rows(network.images, keep)))


def test_steps_are_bounded():
    found = adjust(facade_block(22).network, AdjustmentOptions(iterations=1, rounds=1))
    assert found.iterations == 4 and found.rounds == 1


@pytest.mark.parametrize("model", ["SIMPLE_RADIAL", "OPENCV_FISHEYE", "FULL_OPENCV"])
def test_other_camera_models_are_calibrated(model):
    params = {
        "SIMPLE_RADIAL": [2000.0, 1500.0, 1000.0, -0.03],
        "OPENCV_FISHEYE": [1500.0, 1505.0, 1500.0, 1000.0, 0.01, -0.005, 0.0, 0.0],
        "FULL_OPENCV": [2000.0, 2005.0, 1500.0, 1000.0, -0.03, 0.01, 0.001, 0.0, 0.0, 0.0, 0.0, 0.0],
    }[model]
    camera = Camera(model, 3000, 2000, np.array(params))
    sigmas = np.where(np.array(params) > 10, 10.0, 0.0)
    block = facade_block(23, camera=camera, control=20)
    wrong = Camera(model, 3000, 2000, camera.params + 0.5 * sigmas)
    found = adjust(replace(block.network, cameras=(wrong,), camera_sigmas=(sigmas,)))
    free = sigmas > 0
    error = (found.cameras[0].value.params - camera.params)[free]
    assert np.abs(error / found.cameras[0].sigma[free]).max() < 4.0
    assert (found.cameras[0].sigma[free] < 8.0).all()
