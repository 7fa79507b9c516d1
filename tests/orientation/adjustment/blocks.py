"""Simulated blocks of photos in front of a facade, with known truth."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.rigid import Rigid3
from frontage.model.photo import Camera
from frontage.orientation.adjustment import (
    ImageObservations,
    Network,
    Photos,
    PointObservations,
    control_rows,
    held_mount,
)

SIGMA_PX = 0.5
SIGMA_CONTROL = 0.005
PINHOLE = Camera("PINHOLE", 3000, 2000, np.array([2000.0, 2010.0, 1500.0, 1000.0]))


@dataclass(frozen=True, eq=False)
class Block:
    """A network with noisy observations and wrong approximate values, and its true values."""

    network: Network
    poses: tuple[Rigid3, ...]
    cameras: tuple[Camera, ...]
    points: np.ndarray


def looking(place, target, roll=0.0, name="camera"):
    """The pose local_from_camera of a camera that looks from one place to another."""
    forward = np.asarray(target, float) - place
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    c, s = np.cos(roll), np.sin(roll)
    return Rigid3(
        "local", name, np.column_stack([c * right + s * down, c * down - s * right, forward]), place
    )


def disturbed(pose, rng, metres=0.05, radians=0.01):
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(radians * rng.standard_normal(3)).as_matrix()
    return Rigid3(pose.to, pose.frm, turn @ pose.R, pose.t + metres * rng.standard_normal(3))


def facade_block(
    seed=0,
    photos=8,
    points=150,
    control=12,
    camera=PINHOLE,
    noise=1.0,
    share=0.8,
    relief=2.0,
    start=1.0,
    camera_sigmas=(),
    camera_offset=0.0,
    sigma_px=SIGMA_PX,
):
    """Photos in two rows before a facade of 20 m, points seen by a share of them, and control."""
    rng = np.random.default_rng(seed)
    along = np.linspace(-9.0, 9.0, photos)
    poses = tuple(
        looking(
            [x, -12.0 - 2.0 * (i % 3), 2.0 + 5.0 * (i % 2)], [0.4 * x, 0.0, 6.0], 1.5 * (i % 4 == 3), f"P{i}"
        )
        for i, x in enumerate(along)
    )
    xyz = rng.uniform([-10.0, 0.0, 0.0], [10.0, relief, 12.0], (points, 3))
    photo, point, pixels = visible(poses, (camera,), np.zeros(photos, int), xyz)
    keep = rng.random(len(photo)) < share
    photo, point, pixels = photo[keep], point[keep], pixels[keep]
    pixels = pixels + noise * SIGMA_PX * rng.standard_normal(pixels.shape)
    images = ImageObservations(
        photo, point, pixels, np.full(len(photo), sigma_px), np.zeros(len(photo), np.int64)
    )
    measured = xyz[:control] + noise * SIGMA_CONTROL * rng.standard_normal((control, 3))
    surfaces = control_rows(np.arange(control), measured, np.eye(3) * SIGMA_CONTROL**2, 1)
    if control == 0:
        surfaces = PointObservations.none()
    network = Network(
        tuple(disturbed(p, rng, 0.05 * start, 0.01 * start) for p in poses),
        (replace(camera, params=camera.params + camera_offset),),
        Photos.free(np.zeros(photos, np.int64)),
        xyz + 0.05 * start * rng.standard_normal(xyz.shape),
        images,
        surfaces,
        (),
        camera_sigmas,
    )
    return Block(network, poses, (camera,), xyz)


def visible(poses, cameras, camera_of, xyz):
    """All pairs of photos and points within the picture, and their true pixels."""
    photo, point, pixels = [], [], []
    for i, pose in enumerate(poses):
        camera = cameras[camera_of[i]]
        uv = camera.project(pose.inverse.apply(xyz))
        inside = ((uv > 0) & (uv < [camera.width, camera.height])).all(axis=1)
        photo.append(np.full(inside.sum(), i))
        point.append(np.flatnonzero(inside))
        pixels.append(uv[inside])
    return np.concatenate(photo), np.concatenate(point), np.concatenate(pixels)


def pose_error(estimate, truth):
    """The error (6,) of an estimated pose in the order of its covariance."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(estimate.R @ truth.R.T).as_rotvec()
    return np.concatenate([estimate.t - truth.t, turn])


def rig_block(seed=0, stops=5, points=200, control=10, start=1.0):
    """A vehicle with three cameras, two of them of one model, that passes a facade."""
    rng = np.random.default_rng(seed)
    wide = Camera("OPENCV", 2000, 2000, np.array([1100.0, 1100.0, 1000.0, 1000.0, 0.01, -0.005, 1e-4, 2e-4]))
    cameras = (PINHOLE, wide)
    mounts = tuple(
        Rigid3(
            "body",
            f"C{i}",
            looking([0.0, 0.0, 0.0], [np.sin(a), np.cos(a), 0.3]).R,
            [0.3 * (i - 1), 0.2, 1.0],
        )
        for i, a in enumerate((-0.5, 0.0, 0.5))
    )
    bodies = tuple(
        disturbed(Rigid3("local", f"S{i}", np.eye(3), [x, -10.0, 1.5]), rng, 0.1, 0.03)
        for i, x in enumerate(np.linspace(-6, 6, stops))
    )
    held = tuple(held_mount(m) for m in mounts)
    photos = Photos(
        np.repeat(np.arange(stops), 3), np.tile([1, 0, 1], stops), np.tile([0, 1, 2], stops), held
    )
    views = tuple(bodies[b].after(m) for b, m in zip(photos.body, photos.body_from_camera, strict=True))
    xyz = rng.uniform([-10.0, 0.0, 0.0], [10.0, 2.0, 12.0], (points, 3))
    photo, point, pixels = visible(views, cameras, photos.camera, xyz)
    pixels = pixels + SIGMA_PX * rng.standard_normal(pixels.shape)
    images = ImageObservations(photo, point, pixels, np.full(len(photo), SIGMA_PX), np.zeros(len(photo), int))
    measured = xyz[:control] + SIGMA_CONTROL * rng.standard_normal((control, 3))
    surfaces = PointObservations.none()
    if control:
        surfaces = control_rows(np.arange(control), measured, np.eye(3) * SIGMA_CONTROL**2, 1)
    network = Network(
        tuple(disturbed(p, rng, 0.05 * start, 0.01 * start) for p in bodies),
        cameras,
        photos,
        xyz + 0.05 * start * rng.standard_normal(xyz.shape),
        images,
        surfaces,
    )
    return Block(network, bodies, cameras, xyz)
