"""A block of two photos from their relative orientation, where the mapper refuses."""

from collections.abc import Sequence

import numpy as np

from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Photo
from frontage.orientation.nouns import Block, CommonPoints, KeyPoints, PairMatches

_LEAST_ANGLE = np.radians(1.0)
_LEAST_POINTS = 30
_LEAST_SHARE = 0.2  # of the matches; photos from one place have few by chance


def block_of_two(pair: PairMatches, photos: Sequence[Photo], keypoints: Sequence[KeyPoints]) -> Block | None:
    """Triangulates a pair, the distance of its cameras being 1; None when too few rays meet at an angle."""
    numbers = (pair.first, pair.second)
    common = CommonPoints.of(pair, keypoints)
    u, v = (photos[n].camera.ray(common.pixels[:, k]) for k, n in enumerate(numbers))
    centre, back = -pair.rotation.T @ pair.direction, v @ pair.rotation
    cosine = np.clip((u * back).sum(1), -1, 1)
    sine2 = np.maximum(1 - cosine**2, 1e-12)
    along = (u @ centre - cosine * (back @ centre)) / sine2
    other = (cosine * (u @ centre) - back @ centre) / sine2
    good = (along > 0) & (other > 0) & (np.arcsin(np.sqrt(sine2)) > _LEAST_ANGLE)
    if good.sum() < max(_LEAST_POINTS, _LEAST_SHARE * len(good)):
        return None
    points = 0.5 * (u * along[:, None] + centre + back * other[:, None])[good]
    poses = (
        Rigid3("local", "camera", np.eye(3), np.zeros(3)),
        Rigid3("local", "camera", pair.rotation.T, centre),
    )
    unknown = np.full((6, 6), np.nan)
    oriented = tuple(
        Photo(photos[n].id, photos[n].camera, Estimate(pose, unknown, 0.0), photos[n].time)
        for n, pose in zip(numbers, poses, strict=True)
    )
    m = len(points)
    return Block(
        np.array(numbers, np.int64),
        oriented,
        points,
        np.tile([0, 1], m),
        np.repeat(np.arange(m), 2),
        common.pixels[good].reshape(-1, 2),
        None if common.sizes is None else common.sizes[good].ravel(),
    )
