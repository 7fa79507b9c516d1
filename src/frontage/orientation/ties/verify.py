"""After mapping: would a photo fit one window further along the wall as well?

The key points of a photo are compared with the tie points that other photos have seen, and each of the
nearest few is carried to the wall: those of the right place meet there, those of a repeated window lie one
pitch apart. The comparison is made for every other photo by itself, so that two halves of a block which are
shifted against each other are found although each half agrees with itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.orientation.nouns import Block, KeyPoints
from frontage.orientation.ties.matches import several, unit
from frontage.orientation.ties.options import TieOptions
from frontage.orientation.ties.repetition import Rival, bin_size, strongest_shift
from frontage.orientation.ties.sight import pixel_angle
from frontage.orientation.ties.wall import wall_through

_KEY_POINTS, _POINTS = 2048, 6000  # at most, of a photo and of the block
_NEIGHBOURS = 3
_ENOUGH = 15  # matches by which a photo agrees or disagrees with another


@dataclass(frozen=True, eq=False)
class Doubt:
    """Place of a photo in its block, the shift (3,) in block units by which it fits too, the share."""

    photo: int
    shift: Float
    share: float


def doubts(block: Block, keypoints: Sequence[KeyPoints], options: TieOptions) -> list[Doubt]:
    """Returns the photos of a block that fit elsewhere on the wall, or that other photos contradict."""
    looks = _descriptors(block, keypoints)
    seen = np.zeros((len(block.photos), len(block.points)), np.bool_)
    seen[block.photo, block.point] = True
    found = []
    agree = np.zeros((len(block.photos), len(block.photos)), np.bool_)
    rivals: list[tuple[Rival, Float]] = []
    for i in range(len(block.photos)):
        rival, shift, agree[i] = _judge(i, block, keypoints[int(block.numbers[i])], looks, seen, options)
        rivals.append((rival, shift))
    main = _largest_group(agree | agree.T)
    for i, (rival, shift) in enumerate(rivals):
        if rival.share > options.rival or not main[i]:
            found.append(Doubt(i, shift, rival.share))
    return found


def _descriptors(block: Block, keypoints: Sequence[KeyPoints]) -> Array:
    """Descriptors (m, 128) float32 of the image measurements of a block."""
    looks = np.zeros((len(block.photo), 128), np.float32)
    for k, n in enumerate(block.numbers.tolist()):
        mine = block.photo == k
        if mine.any():
            rows = KDTree(keypoints[n].pixels).query(block.pixels[mine])[1]
            looks[mine] = unit(keypoints[n].descriptors[rows])
    return looks


def _judge(
    i: int, block: Block, points: KeyPoints, looks: Array, seen: Bool, options: TieOptions
) -> tuple[Rival, Float, Bool]:
    """The strongest rival of photo i, its shift (3,) in the block, and which photos (p,) agree with i."""
    photo, rng = block.photos[i], np.random.default_rng(i)
    camera_from_block = photo.pose.inverse
    others = np.flatnonzero((block.photo != i) & _in_view(photo.project(block.points))[block.point])
    others = np.sort(rng.permutation(others)[:_POINTS])
    mine = camera_from_block.apply(block.points[seen[i]])
    if len(others) < _ENOUGH or len(mine) < _ENOUGH:
        return Rival(0.0, np.zeros(2), 1.0), np.zeros(3), np.ones(len(block.photos), np.bool_)
    facing = mine.mean(0) / np.linalg.norm(mine.mean(0))
    wall = wall_through(mine, rng, facing)
    some = np.sort(rng.permutation(len(points))[:_KEY_POINTS])
    rays = photo.camera.ray(points.pixels[some])
    near = several(unit(points.descriptors[some]), looks[others], _NEIGHBOURS)
    target = camera_from_block.apply(block.points[block.point[others]])
    shifts = (
        wall.meet(np.zeros(3), target / np.linalg.norm(target, axis=1, keepdims=True))[near[:, 1]]
        - wall.meet(np.zeros(3), rays)[near[:, 0]]
    )
    size = bin_size(pixel_angle(photo.camera), wall.distance)
    rival = strongest_shift(shifts, near[:, 0], size, wall.distance)
    by = block.photo[others][near[:, 1]]
    share = (seen & seen[i]).any(1)
    agree = _agreement(shifts, near[:, 0], by, rival, share, options)
    return rival, photo.pose.rotate((rival.shift @ wall.axes)[None])[0], agree


def _agreement(shifts: Float, source: Int, by: Int, rival: Rival, share: Bool, options: TieOptions) -> Bool:
    """Which photos (p,) agree: they `share` points, and the rival does not explain more than no shift."""
    with np.errstate(invalid="ignore"):
        right = np.abs(shifts).max(1) < 1.5 * rival.bin
    wrong = rival.same_shift(shifts)
    result = share.copy()
    for j in np.flatnonzero(share).tolist():
        own = len(np.unique(source[right & (by == j)]))
        other = len(np.unique(source[wrong & (by == j)]))
        result[j] = other < _ENOUGH or other <= options.rival * own
    return result


def _in_view(pixels: Float) -> Bool:
    visible: Bool = np.isfinite(pixels.sum(1))
    return visible


def _largest_group(joined: Bool) -> Bool:
    """The members (p,) of the largest connected group of photos; the first of several."""
    left, best = set(range(len(joined))), set[int]()
    while left:
        group, front = set[int](), {min(left)}
        while front:
            group |= front
            front = set(np.flatnonzero(joined[sorted(front)].any(0)).tolist()) - group
        left -= group
        if len(group) > len(best):
            best = group
    return np.isin(np.arange(len(joined)), sorted(best))
