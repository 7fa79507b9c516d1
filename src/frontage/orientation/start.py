"""What approximate poses tell of a block before it is compared with the scan."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import rotation_angle
from frontage.model import Photo
from frontage.orientation.drawnwall import Similarity
from frontage.orientation.nouns import Block
from frontage.orientation.place import Start
from frontage.orientation.reflectance.tones import ImageOf
from frontage.orientation.upright import plumb_line_within, turn_upright

_OUTLIER = 3.0  # sigmas
_VAGUE = 0.5  # relative size: beyond, positions do not tell the scale


def start_from_poses(block: Block, given: Sequence[Photo]) -> Start | None:
    """Returns the similarity that fits approximate poses, with its sigmas; None without any pose.

    `given` are all photos; `block.numbers` tells which of them the block holds. Rotations are averaged after
    Hartley et al. (2013, chordal mean); positions give scale and shift.
    """
    pairs = [
        (photo, given[number])
        for photo, number in zip(block.photos, block.numbers, strict=True)
        if given[number].local_from_camera is not None
    ]
    if not pairs:
        return None
    turns = np.array([theirs.pose.R @ ours.pose.R.T for ours, theirs in pairs])
    sigma = np.array([theirs.local_from_camera.sigma for _, theirs in pairs])
    sigma_turn, sigma_shift = float(np.median(sigma[:, 3:])), float(np.median(sigma[:, :3]))
    R, good = _mean_rotation(turns, sigma_turn)
    ours = np.array([photo.pose.t for photo, _ in pairs])[good]
    theirs = np.array([photo.pose.t for _, photo in pairs])[good]
    n = len(ours)
    scale, sigma_size = _size(ours @ R.T, theirs, sigma_shift)
    t = theirs.mean(0) - scale * R @ ours.mean(0)
    return Start(
        Similarity(scale, R, t),
        max(sigma_turn, 1e-3) / np.sqrt(n),
        sigma_size if sigma_size < _VAGUE else np.inf,
        max(sigma_shift, 0.05),  # errors of GPS are common to a walk: more photos do not help
    )


def levelled(block: Block, start: Start, image_of: ImageOf) -> Start:
    """Returns a start that agrees with the vertical edges of the photos.

    Approximate poses are tilted by as much as they are turned. Pictures of a wall that are tilted by some
    degrees are not found in the scan, and edges tell the plumb line to tenths of a degree. The middle of the
    cameras stays where it is.
    """
    now = start.similarity
    up = plumb_line_within(block.photos, image_of, now.R[2], start.sigma_turn)
    R = turn_upright(now.R @ up) @ now.R
    middle = np.mean([photo.pose.t for photo in block.photos], axis=0)
    return replace(start, similarity=Similarity(now.scale, R, now.apply(middle) - now.scale * R @ middle))


def _mean_rotation(turns: Float, sigma: float) -> tuple[Float, np.ndarray]:
    """The mean of rotations (n, 3, 3) and which of them (n,) agree with it."""
    good = np.ones(len(turns), np.bool_)
    R = _nearest(turns.sum(0))
    for _ in range(3):
        angle = np.array([rotation_angle(R.T @ turn) for turn in turns])
        limit = max(_OUTLIER * np.sqrt(3.0) * sigma, 2.0 * float(np.median(angle)), 1e-3)
        good = angle <= limit
        R = _nearest(turns[good].sum(0))
    return R, good


def _nearest(matrix: Float) -> Float:
    U, _, Vt = np.linalg.svd(matrix)
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))])
    return np.asarray(U @ sign @ Vt)


def _size(turned: Float, theirs: Float, sigma: float) -> tuple[float, float]:
    """Metres per block unit from positions (n, 3) in equal axes, and its relative sigma."""
    a, b = turned - turned.mean(0), theirs - theirs.mean(0)
    spread = float((a**2).sum())
    if spread < 1e-12:
        return 1.0, np.inf
    scale = float((a * b).sum()) / spread
    if scale <= 0:
        scale = float(np.sqrt((b**2).sum() / spread))
    return scale, sigma / (scale * np.sqrt(spread))
