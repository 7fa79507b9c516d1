"""What the approximate poses say about a photo that fits two places of a block."""

from collections.abc import Sequence

import cv2
import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import Photo
from frontage.orientation.nouns import Block
from frontage.orientation.ties.verify import Doubt

_SIGMAS = 4.0
_LEAST_TURN = np.radians(1.0)  # one sigma of the alignment of a block to approximate poses
_CLEARLY = 9.0  # difference of the squared, normalised residuals of two places


def local_from_block(
    block: Block, photos: Sequence[Photo], but: int | None = None
) -> tuple[float, Float, Float] | None:
    """Scale, rotation (3, 3) and translation (3,) from a block to the approximate poses; None without two.

    but  place in the block of a photo that shall not take part, because it is to be judged

    The rotation is the mean of the photos' own, because the centres of a walk lie on a line.
    """
    known = [
        (p.pose, g.value)
        for k, (p, n) in enumerate(zip(block.photos, block.numbers.tolist(), strict=True))
        if k != but and (g := photos[n].local_from_camera) is not None
    ]
    if len(known) < 2:
        return None
    u, _, vt = np.linalg.svd(sum((given.R @ own.R.T for own, given in known), np.zeros((3, 3))))
    R = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    own = np.array([o.t for o, _ in known]) @ R.T
    given = np.array([g.t for _, g in known])
    i, j = np.triu_indices(len(known), 1)
    apart = np.linalg.norm(own[i] - own[j], axis=1)
    wide = apart > 0.3 * apart.max()
    along = ((own[i] - own[j]) * (given[i] - given[j])).sum(1)[wide] / apart[wide] ** 2
    scale = float(np.median(along))
    if scale <= 0:
        return None
    return scale, R, np.median(given - scale * own, axis=0)


def contradicts(place: int, block: Block, photos: Sequence[Photo]) -> bool:
    """Whether the pose of photo `place` of a block is beyond four sigmas of its approximate pose."""
    given = photos[int(block.numbers[place])].local_from_camera
    motion = local_from_block(block, photos, but=place)
    if given is None or motion is None:
        return False
    scale, R, t = motion
    own = block.photos[place].pose
    shift = given.value.t - (scale * R @ own.t + t)
    turn = cv2.Rodrigues(given.value.R @ (R @ own.R).T)[0][:, 0]
    angles = given.covariance[3:, 3:] + _LEAST_TURN**2 * np.eye(3)
    off = float(shift @ np.linalg.pinv(given.covariance[:3, :3]) @ shift)
    return max(off, float(turn @ np.linalg.solve(angles, turn))) > _SIGMAS**2


def settles(doubt: Doubt, block: Block, photos: Sequence[Photo]) -> bool:
    """Whether the approximate pose of a doubtful photo clearly prefers its place to the rival's."""
    given = photos[int(block.numbers[doubt.photo])].local_from_camera
    motion = local_from_block(block, photos, but=doubt.photo)
    if given is None or motion is None or not np.any(doubt.shift):
        return False
    scale, R, t = motion
    residual = given.value.t - (scale * R @ block.photos[doubt.photo].pose.t + t)
    weight = np.linalg.pinv(given.covariance[:3, :3])
    here = float(residual @ weight @ residual)
    # Matches that lie `shift` too far along the wall move the camera back; both signs are tried to be safe.
    moved = residual + scale * R @ doubt.shift
    other = residual - scale * R @ doubt.shift
    return min(float(moved @ weight @ moved), float(other @ weight @ other)) - here > _CLEARLY
