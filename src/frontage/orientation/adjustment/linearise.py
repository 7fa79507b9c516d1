"""Residuals and derivatives of all observations at a state.

For a camera at ``C = t + R l`` on a body (R, t) with lever arm l, the point in the camera frame is
``x = A (X - C)`` with ``A = camera_from_local``. With the left perturbation of the pose (geometry.rigid) and
``P`` the derivative of the projection::

    by point        P A
    by translation  -P A
    by rotation     each row a of P A gives  a x (X - t)

and for a mount that is estimated too, in the axes of the body::

    by translation  -P A R
    by rotation     each row a of P A gives  (a x (X - C)) R
"""

from dataclasses import dataclass

import numpy as np
from scipy import linalg
from scipy.spatial.transform import Rotation

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.geometry.rigid import Rigid3, skew
from frontage.model.estimate import Estimate
from frontage.orientation.adjustment.derivatives import by_parameters, by_point
from frontage.orientation.adjustment.layout import Layout
from frontage.orientation.adjustment.network import Network
from frontage.orientation.adjustment.state import State


@dataclass(frozen=True, eq=False)
class Residuals:
    """Residuals: images (m, 2) px, projected minus measured, NaN where not seen; surfaces (k,) m."""

    images: Float
    surfaces: Float


@dataclass(frozen=True, eq=False)
class Weights:
    """Square roots of the weights: images (m,) per px, surfaces (k,) per m; zero for what is not used."""

    images: Float
    surfaces: Float


@dataclass(frozen=True, eq=False)
class Linearised:
    """Weighted residuals and derivatives of the rows of a layout; everything is in sigmas.

    point        (m_a, 2, 3) derivatives by the point, `wide` (m_a, 2, k) by the columns of the row's photo
    miss         (m_a, 2)
    surface      (k_a, 3) derivatives by the point, `surface_miss` (k_a,)
    priors       per body (6 or fewer, 6) derivatives of its prior and the miss; None without a prior
    cameras      (free parameters,) derivatives of the priors of the cameras, `camera_miss` likewise
    mounts       derivatives (r, f) of the priors of the mounts by their f columns, `mount_miss` (r,)
    """

    point: Float
    wide: Float
    miss: Float
    surface: Float
    surface_miss: Float
    priors: tuple[tuple[Float, Float] | None, ...]
    cameras: Float
    camera_miss: Float
    mounts: Float
    mount_miss: Float


def residuals(network: Network, state: State) -> Residuals:
    """The residuals of all observations, used or not."""
    images = np.full((len(network.images), 2), np.nan)
    xyz = camera_points(network, state, slice(None))
    camera_of = network.photos.camera[network.images.photo]
    for i, camera in enumerate(state.cameras):
        rows = np.flatnonzero(camera_of == i)
        images[rows] = camera.project(xyz[rows]) - network.images.pixels[rows]
    rows_of = network.surfaces
    surfaces = np.einsum("ki,ki->k", rows_of.direction, state.points[rows_of.point] - rows_of.at)
    return Residuals(images, np.asarray(surfaces, np.float64))


def linearise(network: Network, state: State, layout: Layout, weights: Weights, at: Residuals) -> Linearised:
    """Derivatives and residuals `at` the state, times the weights; unseen image points count nothing."""
    image_weight = weights.images[layout.rows][:, None]
    miss = at.images[layout.rows] * image_weight
    point, wide = _image_derivatives(network, state, layout)
    unseen = ~np.isfinite(miss).all(axis=1) | ~np.isfinite(wide).all(axis=(1, 2))
    for block in (point, wide):
        block *= image_weight[:, :, None]
        block[unseen] = 0.0
    miss[unseen] = 0.0
    surface_weight = weights.surfaces[layout.surface_rows]
    cameras, camera_miss = camera_prior_rows(network, state)
    return Linearised(
        point,
        wide,
        miss,
        network.surfaces.direction[layout.surface_rows] * surface_weight[:, None],
        at.surfaces[layout.surface_rows] * surface_weight,
        prior_rows(network, state),
        cameras,
        camera_miss,
        *mount_prior_rows(network, state),
    )


def camera_points(network: Network, state: State, rows: Array | slice) -> Float:
    """The observed points (r, 3) m in the frames of the cameras that see them."""
    photo, point = network.images.photo[rows], network.images.point[rows]
    centre = state.positions[network.photos.body] + state.levers(network.photos)
    ray = state.points[point] - centre[photo]
    return np.asarray(np.einsum("mji,mj->mi", state.camera_axes(network.photos)[photo], ray), np.float64)


def _image_derivatives(network: Network, state: State, layout: Layout) -> tuple[Float, Float]:
    """Derivatives (m_a, 2, 3) by the point and (m_a, 2, k) by the columns of the photo, px per unit."""
    xyz = camera_points(network, state, layout.rows)
    point = point_derivatives(network, state, layout.rows, xyz)
    wide = np.zeros((len(layout.rows), 2, layout.width))
    camera_of = network.photos.camera[layout.photo]
    for index, free in enumerate(layout.free):
        rows = np.flatnonzero(camera_of == index)
        if len(free):
            wide[rows, :, 6 : 6 + len(free)] = by_parameters(state.cameras[index], xyz[rows], free)
    body = network.photos.body[layout.photo]
    arm = state.points[network.images.point[layout.rows]] - state.positions[body]
    wide[:, :, :3] = -point
    _cross(point, arm[:, None, :], wide[:, :, 3:6])
    if any(len(f) for f in layout.mounted):
        _mount_derivatives(network, state, layout, point, wide[:, :, layout.first_mounted :])
    return point, wide


def _mount_derivatives(network: Network, state: State, layout: Layout, point: Float, out: Float) -> None:
    """Writes the derivatives (m_a, 2, q) by the mounts; `point` (m_a, 2, 3) are those by points."""
    photos = network.photos
    centre = state.positions[photos.body] + state.levers(photos)
    arm = state.points[network.images.point[layout.rows]] - centre[layout.photo]
    both = np.concatenate([-point, np.empty_like(point)], axis=2)
    _cross(point, arm[:, None, :], both[:, :, 3:])
    axes = state.rotations[photos.body[layout.photo]]
    both = np.concatenate([both[:, :, :3] @ axes, both[:, :, 3:] @ axes], axis=2)
    mount = photos.mount[layout.photo]
    for number, free in enumerate(layout.mounted):
        rows = np.flatnonzero(mount == number)
        out[rows, :, : len(free)] = both[rows][:, :, free]


def point_derivatives(network: Network, state: State, rows: Int, xyz: Float | None = None) -> Float:
    """Derivatives (r, 2, 3), px per m, of image rows by the local coordinates of their points."""
    if xyz is None:
        xyz = camera_points(network, state, rows)
    photo = network.images.photo[rows]
    camera_of = network.photos.camera[photo]
    total = np.empty((len(rows), 2, 3))
    for index, camera in enumerate(state.cameras):
        mine = np.flatnonzero(camera_of == index)
        total[mine] = by_point(camera, xyz[mine])
    return np.asarray(total @ state.camera_axes(network.photos).transpose(0, 2, 1)[photo], np.float64)


def _cross(a: Float, b: Float, out: Float) -> None:
    """The cross product along the last axis, several times faster than `numpy.cross`."""
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[..., i] = a[..., j] * b[..., k] - a[..., k] * b[..., j]


def prior_rows(network: Network, state: State) -> tuple[tuple[Float, Float] | None, ...]:
    """Per body the derivative (r, 6) and the miss (r,) of its pose prior, in sigmas."""
    return tuple(
        None
        if prior is None
        else _prior(prior, state.rotations[i], state.positions[i], np.isfinite(np.diag(prior.covariance)))
        for i, prior in enumerate(network.pose_priors)
    )


def _prior(prior: Estimate[Rigid3], rotation: Float, position: Float, known: Bool) -> tuple[Float, Float]:
    """The derivative (r, 6) and the miss (r,) of the components of a pose that are `known` (6,)."""
    turn = Rotation.from_matrix(rotation @ prior.value.R.T).as_rotvec()
    derivative = np.eye(6)
    derivative[3:, 3:] = _inverse_left_jacobian(turn)
    root = np.linalg.cholesky(prior.covariance[np.ix_(known, known)])
    miss = np.concatenate([position - prior.value.t, turn])
    rows = np.linalg.solve(root, np.column_stack([derivative, miss])[known])
    return np.asarray(rows[:, :6], np.float64), np.asarray(rows[:, 6], np.float64)


def mount_prior_rows(network: Network, state: State) -> tuple[Float, Float]:
    """Derivatives (r, f) by the f columns of the mounts, and misses (r,), of their priors, in sigmas."""
    blocks, miss = [np.empty((0, 0))], [np.empty(0)]
    for number, mount in enumerate(network.photos.mounts):
        free = np.diag(mount.covariance) > 0
        if free.any():
            known = free & np.isfinite(np.diag(mount.covariance))
            rows = _prior(mount, state.turns[number], state.arms[number], known)
            blocks.append(rows[0][:, free])
            miss.append(rows[1])
    return np.asarray(linalg.block_diag(*blocks), np.float64), np.concatenate(miss)


def _inverse_left_jacobian(turn: Float) -> Float:
    """Derivative (3, 3) of the logarithm of a rotation by a small rotation applied after it."""
    angle = float(np.linalg.norm(turn))
    S = skew(turn)
    factor = 1 / 12 if angle < 1e-4 else 1 / angle**2 - 0.5 / (angle * np.tan(angle / 2))
    return np.asarray(np.eye(3) - 0.5 * S + factor * (S @ S), np.float64)


def camera_prior_rows(network: Network, state: State) -> tuple[Float, Float]:
    """Derivatives and misses (f,) of the priors of the estimated camera parameters, in sigmas."""
    weight, miss = [np.empty(0)], [np.empty(0)]
    for sigma, given, camera in zip(network.camera_sigmas, network.cameras, state.cameras, strict=True):
        free = sigma > 0
        weight.append(1.0 / sigma[free])  # 1 / inf is 0: no prior
        miss.append((camera.params - given.params)[free] * weight[-1])
    return np.concatenate(weight), np.concatenate(miss)
