"""What can be known of photos alone, and of the poses that they are compared with.

Errors against given poses are errors of both. Two figures tell them apart: tie points of one half of the
object against those of the other half, which have no error in common but those of the camera, and every
given pose against the pose that tie points give the photo when the given poses of all others are held.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from scipy.stats import chi2

from _common import bootstrap, figure
from frontage.geometry.arrays import Bool, Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Photo
from frontage.orientation.adjustment import Adjustment, AdjustmentOptions, Network, Photos, adjust
from frontage.orientation.free import dependence_of_ties, free_network
from frontage.orientation.network import TiePoints, distinct_cameras, tie_images
from frontage.orientation.nouns import Block

_CELL_M = 5.0  # of the halves, larger than what errs alike in one photo
_HELD = 1e-6  # m and rad

HEAD = (
    "poses",
    "apart mm",
    "sigma mm",
    "apart degrees",
    "sigma degrees",
    "normalised squared difference",
    "agree",
)


@dataclass(frozen=True, eq=False)
class Compared:
    """Differences of poses (p, 6), m and rad, and their covariances (p, 6, 6)."""

    off: Float
    covariance: Float

    def row(self, name: str) -> list[str]:
        """Differences and stated standard errors (medians, mm and degrees), normalised squared difference."""
        sigma = np.sqrt(np.einsum("pii->pi", self.covariance))
        place, turn = slice(0, 3), slice(3, 6)
        return [
            name,
            figure(bootstrap(1000 * np.linalg.norm(self.off[:, place], axis=1))),
            f"{1000 * np.median(np.linalg.norm(sigma[:, place], axis=1)):.2g}",
            figure(bootstrap(np.degrees(np.linalg.norm(self.off[:, turn], axis=1))), digits=3),
            f"{np.degrees(np.median(np.linalg.norm(sigma[:, turn], axis=1))):.2g}",
            figure(bootstrap(self.squared / 6, np.mean), digits=2),
            f"{self.agree.sum()} of {len(self.off)}",
        ]

    @property
    def squared(self) -> Float:
        """The squared differences (p,) in standard errors: chi square with six degrees of freedom."""
        weighted = np.linalg.solve(self.covariance, self.off[..., None])[..., 0]
        return np.asarray(np.einsum("pi,pi->p", self.off, weighted))

    @property
    def agree(self) -> Bool:
        """Which poses (p,) differ by no more than one of a thousand would by chance."""
        return np.asarray(self.squared < chi2.ppf(0.999, 6))


def castle_rows(block: Block, given: Sequence[Photo]) -> Iterator[list[str]]:
    """The rows of the table; `given` poses belong to the photos of the block."""
    block = taken_to(block, given)
    ours = free_network(block)
    poses = [photo.pose for photo in given]
    yield compared(ours, poses).row("ours against the given poses")
    yield halves(block).row("one half of the tie points against the other")
    others = left_out(block, given)
    yield others.row("every given pose against the other given ones")
    good = np.flatnonzero(others.agree)
    yield compared(ours, poses, photos=good).row("ours against the given poses that agree with the others")


def taken_to(block: Block, given: Sequence[Photo]) -> Block:
    """The block in metres: moved by the similarity that fits its places best to the given ones."""
    a = np.array([photo.pose.t for photo in block.photos])
    R, scale, shift = similarity(a, np.array([photo.pose.t for photo in given]))
    photos = tuple(
        replace(p, local_from_camera=Estimate(_moved(p.pose, R, scale, shift), np.zeros((6, 6)), 0.0))
        for p in block.photos
    )
    return replace(block, photos=photos, points=scale * block.points @ R.T + shift)


def similarity(a: Float, b: Float) -> tuple[Float, float, Float]:
    """Rotation, scale and shift that take places (n, 3) best to others (Umeyama 1991)."""
    x, y = a - a.mean(0), b - b.mean(0)
    u, d, vt = np.linalg.svd(y.T @ x)
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    R, scale = u @ (sign[:, None] * vt), float(d @ sign / (x**2).sum())
    return R, scale, b.mean(0) - scale * R @ a.mean(0)


def _moved(pose: Rigid3, R: Float, scale: float, shift: Float) -> Rigid3:
    return Rigid3("local", "camera", R @ pose.R, scale * R @ pose.t + shift)


def compared(
    one: Adjustment, poses: Sequence[Rigid3], other: Adjustment | None = None, photos: Int | None = None
) -> Compared:
    """Poses of a free network against others, after the similarity that fits all differences best.

    other   the network that the others come from, where they have errors
    photos  those to compare; None: all
    """
    wanted = np.arange(len(poses)) if photos is None else photos
    count = len(wanted)
    off = np.array([_off(one.photo_pose(k).value, poses[k]) for k in wanted])
    free = _freedoms(np.array([poses[k].t for k in wanted]))
    covariance = one.poses_covariance + (0.0 if other is None else other.poses_covariance)
    columns = (6 * wanted[:, None] + np.arange(6)).ravel()
    covariance = covariance[np.ix_(columns, columns)]
    left = np.eye(6 * count) - free @ np.linalg.pinv(free)
    covariance = (left @ covariance @ left.T).reshape(count, 6, count, 6)
    own = np.arange(count)
    return Compared((left @ off.ravel()).reshape(count, 6), covariance[own, :, own])


def halves(block: Block) -> Compared:
    """Poses from the tie points in every other cell of space, against those from the points between."""
    side = np.floor(block.points / _CELL_M).astype(np.int64).sum(axis=1) % 2 == 0
    one, other = (free_network(_of_points(block, part)) for part in (side, ~side))
    return compared(one, [other.photo_pose(k).value for k in range(len(block.photos))], other)


def left_out(block: Block, given: Sequence[Photo]) -> Compared:
    """Every photo as its tie points place it between the given poses of all others, against its own."""
    off, covariance = [], []
    held = np.eye(6) * _HELD**2
    for k, photo in enumerate(given):
        seen = np.zeros(len(block.points), bool)
        seen[block.point[block.photo == k]] = True
        part = _of_points(block, seen)
        cameras, number = distinct_cameras([p.camera for p in given])
        ties = TiePoints(part.points, part.photo, part.point, part.pixels, part.sizes)
        priors = [None if p is photo else Estimate(p.pose, held, 0.0) for p in given]
        network = Network(
            tuple(p.pose for p in given),
            tuple(cameras),
            Photos.free(number),
            part.points,
            tie_images(given, ties),
            pose_priors=tuple(priors),
        )
        found = adjust(network, AdjustmentOptions(critical=3.29), dependence_of_ties(part)).photo_pose(k)
        off.append(_off(found.value, photo.pose))
        covariance.append(found.covariance)
    return Compared(np.array(off), np.array(covariance))


def _of_points(block: Block, wanted: Bool) -> Block:
    """The block with some of its points (n,)."""
    kept = wanted[block.point]
    number = np.cumsum(wanted) - 1
    return replace(
        block,
        points=block.points[wanted],
        photo=block.photo[kept],
        point=number[block.point[kept]],
        pixels=block.pixels[kept],
        sizes=None if block.sizes is None else block.sizes[kept],
    )


def _off(one: Rigid3, other: Rigid3) -> Float:
    return np.concatenate([one.t - other.t, cv2.Rodrigues(one.R @ other.R.T)[0][:, 0]])


def _freedoms(places: Float) -> Float:
    """How a shift, a turn and a change of size move poses (6 p, 7), in units of the extent of the places."""
    arms = places - places.mean(axis=0)
    size = float(np.linalg.norm(arms, axis=1).mean())
    free = np.zeros((len(places), 6, 7))
    free[:, :3, :3] = np.eye(3)
    free[:, :3, 3:6] = np.swapaxes(np.cross(np.eye(3)[None], arms[:, None] / size), 1, 2)
    free[:, 3:, 3:6] = np.eye(3) / size
    free[:, :3, 6] = arms / size
    return free.reshape(-1, 7)
