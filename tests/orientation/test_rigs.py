"""Photos of one exposure of a rig are one body, also those that see nothing or were placed wrongly."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from frontage.geometry.rigid import Rigid3, rotation_angle
from frontage.model import Camera, Estimate, Exposure, MountedCamera, Photo, Rig
from frontage.orientation import Block, Unoriented, orient_photos
from frontage.orientation.adjustment import Photos, adjust
from frontage.orientation.carry import carried_by_rigs
from frontage.orientation.network import TiePoints
from frontage.orientation.placed import Placed, Scene
from frontage.orientation.rigs import body_of, carriers_of, mounts_of
from frontage.orientation.ties import Blocks
from orientation.adjustment.blocks import pose_error, rig_block
from orientation.paintedwalls import EXACT, corner_of_two, looking, photograph, scan_of

CAMERA = Camera("PINHOLE", 600, 450, np.array([460.0, 460.0, 300.0, 225.0]))
SIDE = Rigid3("body", "camera", Rotation.from_euler("y", 35, degrees=True).as_matrix(), [0.4, 0.1, -0.2])
BACK = Rigid3("body", "camera", Rotation.from_euler("y", 180, degrees=True).as_matrix(), [0.1, 0.3, -0.9])
IDENTITY = Rigid3.identity("body", "camera")
BODIES = (looking(4.0, -9.0, heading=5.0), looking(6.5, -9.5, heading=-4.0))


def exactly(pose: Rigid3, covariance=EXACT) -> Estimate[Rigid3]:
    return Estimate(pose, covariance, 0.0)


def rig_of(side=None, back=None) -> Rig:
    mounts = (
        exactly(IDENTITY),
        exactly(SIDE) if side is None else side,
        exactly(BACK) if back is None else back,
    )
    cameras = tuple(MountedCamera(n, m) for n, m in zip(("front", "side", "back"), mounts, strict=True))
    exposures = (
        Exposure(str(k), tuple(f"{n}{k}" for n in ("front", "side", "back")), (0, 1, 2)) for k in (0, 1)
    )
    return Rig("car", cameras, tuple(exposures))


def photo(name: str, pose: Rigid3 | None = None, covariance=EXACT) -> Photo:
    return Photo(name, CAMERA, None if pose is None else exactly(pose, covariance))


def true_pose(name: str) -> Rigid3:
    mount = {"front": IDENTITY, "side": SIDE, "back": BACK}[name[:-1]]
    return BODIES[int(name[-1])].after(mount)


NAMES = [f"{n}{k}" for k in (0, 1) for n in ("front", "side", "back")]


def test_photos_of_an_exposure_share_a_body_and_its_prior():
    covariance = np.diag([1.0, 1.0, 2.0, 0.01, 0.01, 0.02])
    photos = [photo(name, true_pose(name)) for name in ("front0", "side0", "side1")]
    photos.append(photo("alone", BODIES[0]))
    found = carriers_of(photos, [0] * 4, [rig_of()])
    assert found.photos.body.tolist() == [0, 0, 1, 2] and found.photos.mount.tolist() == [1, 2, 2, 0]
    for body, pose in zip(found.bodies, (BODIES[0], BODIES[1], BODIES[0]), strict=True):
        assert np.allclose(body.matrix, pose.matrix, atol=1e-12)
    given = [exactly(p.pose, covariance) for p in photos]
    priors = found.priors(given)
    once = found.priors([given[0], None, None, None])
    assert priors[0] is not None and once[0] is not None and once[1] is None
    # Two photos of one exposure do not make the pose of the body better known than one of them does.
    assert (priors[0].sigma >= once[0].sigma - 1e-12).all()
    assert np.allclose(once[0].covariance, covariance)


def test_the_pose_of_a_body_has_the_errors_of_photo_and_mount():
    rng = np.random.default_rng(0)
    A, B = (rng.normal(size=(6, 6)) * 0.003 for _ in range(2))
    pose, mount = exactly(BODIES[0].after(SIDE), A @ A.T), exactly(SIDE, B @ B.T)
    found = body_of(pose, mount)
    assert np.allclose(found.value.matrix, BODIES[0].matrix)
    errors = []
    for _ in range(1500):
        p, m = (
            Rigid3(
                e.value.to,
                e.value.frm,
                Rotation.from_rotvec(d[3:]).as_matrix() @ e.value.R,
                e.value.t + d[:3],
            )
            for e, d in ((e, rng.multivariate_normal(np.zeros(6), e.covariance)) for e in (pose, mount))
        )
        errors.append(pose_error(p.after(m.inverse), BODIES[0]))
    np.testing.assert_allclose(np.std(errors, axis=0), found.sigma, rtol=0.09)


def test_unknown_mounts_come_from_exposures_that_tell_them():
    unknown = replace(rig_of(), cameras=tuple(MountedCamera(n) for n in ("front", "side", "back")))
    poses = {name: true_pose(name) for name in ("front0", "side0", "side1")}
    found = mounts_of(unknown, poses)
    assert found.keys() == {0, 1}  # nothing tells of the camera that looks back
    assert np.allclose(found[1].value.matrix, SIDE.matrix) and np.isinf(np.diag(found[1].covariance)).all()
    # By way of the side camera, one more photo tells of it: from the exposure that has no photo in front.
    found = mounts_of(unknown, {**poses, "back1": true_pose("back1")})
    assert np.allclose(found[2].value.matrix, BACK.matrix)
    photos = [photo(name, true_pose(name)) for name in ("front0", "side0", "back1")]
    assert carriers_of(photos, [0] * 3, [unknown]).photos.body.tolist() == [0, 0, 1]


def test_a_rig_brings_photos_along_and_overrules_a_wrong_block():
    ties = TiePoints(np.zeros((1, 3)), np.array([0, 1]), np.zeros(2, np.int64), np.zeros((2, 2)))
    good = Placed(np.array([0, 3]), tuple(photo(n, true_pose(n)) for n in ("front0", "front1")), ties)
    wrong = true_pose("side0")
    wrong = Rigid3("local", "camera", wrong.R, wrong.t + np.array([2.0, 0.0, 0.0]))  # one window farther
    near = true_pose("side1")
    near = Rigid3("local", "camera", near.R, near.t + np.array([0.02, 0.0, 0.0]))
    lone = Placed(
        np.array([1]),
        (photo("side0", wrong),),
        TiePoints(np.zeros((1, 3)), *[np.zeros(1, int)] * 2, np.zeros((1, 2))),
    )
    other = Placed(np.array([4]), (photo("side1", near),), TiePoints.none())
    given = [photo(name) for name in (*NAMES, "alone")]
    scene = Scene(given, None, None, (), 0, lambda _: None, (rig_of(),))  # type: ignore[arg-type]
    left = [Unoriented(n, "O101", "why") for n in ("back0", "back1", "alone")]
    placed, unoriented = carried_by_rigs(scene, [good, lone, other], left)
    assert [u.photo for u in unoriented] == ["alone"]
    found = {p.id: p.pose for part in placed for p in part.photos}
    assert found.keys() == set(NAMES)
    for name in ("front0", "side0", "back0"):
        assert np.allclose(found[name].matrix, true_pose(name).matrix, atol=1e-9)
    for name in ("front1", "side1", "back1"):  # both have a place, and the truth is between them
        assert np.allclose(found[name].t, true_pose(name).t + np.array([0.01, 0.0, 0.0]), atol=1e-9)
    assert len(placed[0].ties.photo) == 2 and len(placed[1].ties.photo) == 0
    assert {int(p.numbers[0]) for p in placed[3:]} == {2, 5}


def test_the_rig_makes_poses_better_than_free_photos():
    """The same measurements, adjusted with the cameras fixed to one another and without."""
    squared = {"rig": [], "free": []}
    for seed in range(4):
        block = rig_block(40 + seed, points=60)
        network, photos = block.network, block.network.photos
        true = [block.poses[b].after(m) for b, m in zip(photos.body, photos.body_from_camera, strict=True)]
        poses = tuple(
            network.poses[b].after(m) for b, m in zip(photos.body, photos.body_from_camera, strict=True)
        )
        free = replace(network, poses=poses, photos=Photos.free(photos.camera), pose_priors=())
        for name, one in (("rig", network), ("free", free)):
            found = adjust(one)
            errors = [pose_error(found.photo_pose(k).value, pose) for k, pose in enumerate(true)]
            squared[name].append(np.square(errors).mean(axis=0))
    gain = np.sqrt(np.mean(squared["rig"], axis=0) / np.mean(squared["free"], axis=0))
    assert (gain < 0.9).all() and gain.mean() < 0.85, gain


@pytest.fixture(scope="module")
def street():
    """Painted walls, their scan, and photos of two exposures of three cameras, one of which sees only sky."""
    walls = corner_of_two()
    exact = [photo(name, true_pose(name)) for name in NAMES]
    images = {p.id: photograph(walls, p, seed=k) for k, p in enumerate(exact)}
    return scan_of(walls), images


def oriented(street, rigs):
    """Orients the photos; those in front are a block, the others have no place of their own."""
    scan, images = street
    spread = np.diag([0.3**2] * 3 + [np.radians(2.0) ** 2] * 3)
    rng = np.random.default_rng(3)
    given = []
    for name in NAMES:
        d, pose = rng.multivariate_normal(np.zeros(6), spread), true_pose(name)
        turned = Rotation.from_rotvec(d[3:]).as_matrix() @ pose.R
        known = name.startswith("front")
        given.append(
            photo(name, Rigid3("local", "camera", turned, pose.t + d[:3]) if known else None, spread)
        )
    xyz = np.concatenate([w.points(0.5, np.random.default_rng(1), 0.005)[0] for w in corner_of_two()])
    numbers = np.array([0, 3])
    photos = tuple(photo(NAMES[k], true_pose(NAMES[k])) for k in numbers)
    empty = np.empty(0, np.int64)
    block = Block(numbers, photos, xyz, empty, empty, np.empty((0, 2)))
    lost = tuple((name, "it matches no other photo") for name in NAMES if not name.startswith("front"))
    return orient_photos(given, Blocks((block,), lost), scan, images.__getitem__, rigs=rigs)


def test_a_photo_without_control_is_oriented_by_its_rig(street):
    found = oriented(street, (rig_of(),))
    assert not found.unoriented and [p.photo.id for p in found.photos] == NAMES
    for p in found.photos:
        estimate, true = p.photo.local_from_camera, true_pose(p.photo.id)
        error = pose_error(estimate.value, true)
        assert np.linalg.norm(error[:3]) < 0.02 and np.linalg.norm(error[3:]) < np.radians(0.1), p.photo.id
        assert error @ np.linalg.solve(estimate.covariance, error) / 6 < 5.0
    verdicts = {p.photo.id: p.verdict for p in found.photos}
    assert verdicts["back0"] == verdicts["back1"] == "carried" and verdicts["front0"] == "confirmed"
    assert any("back0, back1" in note and "rig" in note for note in found.notes)
    control = {p.photo.id: p.control for p in found.photos}
    assert control["back0"] == 0 and control["side0"] > 12
    (rig,) = found.rigs
    assert [e.photos for e in rig.exposures] == [tuple(NAMES[:3]), tuple(NAMES[3:])]


def test_relative_poses_with_standard_errors_are_estimated(street):
    sigma = np.array([0.03] * 3 + [np.radians(0.5)] * 3)
    wrong = Rigid3(
        "body", "camera", Rotation.from_rotvec([0.006, -0.008, 0.005]).as_matrix() @ SIDE.R, SIDE.t + 0.02
    )
    back = exactly(BACK, np.diag(sigma**2))
    found = oriented(street, (rig_of(exactly(wrong, np.diag(sigma**2)), back),))
    (rig,) = found.rigs
    front, side, behind = (c.body_from_camera for c in rig.cameras)
    assert (front.covariance == 0).all()
    error = pose_error(side.value, SIDE)
    assert np.linalg.norm(error[:3]) < 0.015 and rotation_angle(side.value.R @ SIDE.R.T) < np.radians(0.1)
    assert error @ np.linalg.solve(side.covariance, error) / 6 < 5.0
    # What sees nothing learns nothing: its relative pose is as uncertain as before, and so is the photo.
    assert behind.sigma == pytest.approx(sigma, rel=1e-3)
    last = next(p for p in found.photos if p.photo.id == "back1")
    assert (last.photo.local_from_camera.sigma[3:] > 0.9 * sigma[3:]).all()
