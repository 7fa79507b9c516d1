"""The relative orientation of two photos: five-point RANSAC on rays, then matching along epipolar lines."""

from typing import Any

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.geometry.rigid import skew
from frontage.model import Camera
from frontage.orientation.nouns import KeyPoints, PairMatches
from frontage.orientation.ties import colmap as door
from frontage.orientation.ties.matches import mutual
from frontage.orientation.ties.options import TieOptions
from frontage.orientation.ties.repetition import pair_rival
from frontage.orientation.ties.sight import Sight, sight_of

_GUIDED_RATIO = 0.85
_SOME = 0.1  # share of a rival above which its matches are taken out of the pair


def match_pair(
    a: KeyPoints,
    b: KeyPoints,
    camera_a: Camera,
    camera_b: Camera,
    *,
    first: int = 0,
    second: int = 1,
    options: TieOptions | None = None,
) -> PairMatches | None:
    """Matches two photos and finds their relative orientation; None when they do not show the same thing.

    first, second  the numbers that the photos have in the result

    Photos taken from one place have `angle` near 0, and their `direction` means nothing. Raises MissingExtra
    without pycolmap.
    """
    options = options or TieOptions()
    door.require()
    one, two = sight_of(a, camera_a), sight_of(b, camera_b)
    found = _oriented(one, two, options)
    if found is None:
        return None
    rows, R, t = found
    rival, shifted = pair_rival(one, two, rows, R, t)
    if _SOME < rival.share < 1.0:  # these matches lie on their epipolar lines by chance
        rows = rows[~shifted]
    if len(rows) < options.least_matches:
        return None
    va, vb = one.rays[rows[:, 0]] @ R.T, two.rays[rows[:, 1]]
    angle = float(np.median(np.arctan2(np.linalg.norm(np.cross(va, vb), axis=1), (va * vb).sum(1))))
    return PairMatches(first, second, rows, R, t, angle, rival.share)


def _oriented(one: Sight, two: Sight, options: TieOptions) -> tuple[Int, Float, Float] | None:
    """Matches (m, 2), rotation and unit translation (second_from_first); None with too few matches."""
    rows = mutual(one.looks, two.looks, options.ratio)
    if len(rows) < options.least_matches:
        return None
    limit = options.epipolar * 0.5 * (one.pixel + two.pixel)
    with door.silent() as colmap:
        pose = _five_point(colmap, one.rays[rows[:, 0]], two.rays[rows[:, 1]], limit, options)
        if pose is None:
            return None
        R, t = pose
        rows = np.concatenate([rows, _guided(one, two, rows, skew(t) @ R, 2 * limit)])
        R, t, good = _refined(colmap, R, t, one.rays[rows[:, 0]], two.rays[rows[:, 1]], limit)
    rows = _one_to_one(rows[good])
    return (rows, R, t / np.linalg.norm(t)) if len(rows) >= options.least_matches else None


def _five_point(
    colmap: Any, u: Float, v: Float, limit: float, options: TieOptions
) -> tuple[Float, Float] | None:
    """Rotation and unit translation (second_from_first) that most pairs of rays (n, 3) agree with."""
    ransac = colmap.RANSACOptions(
        max_error=limit,
        confidence=0.9999,
        min_num_trials=200,
        max_num_trials=4000,
        random_seed=options.seed,
        min_inlier_ratio=0.05,
        num_threads=1,
    )
    found = colmap.estimate_relative_pose(u, v, ransac)
    if found is None or found["num_inliers"] < options.least_matches // 2:
        return None
    pose = found["cam2_from_cam1"]
    return pose.rotation.matrix(), np.array(pose.translation)


def _refined(colmap: Any, R: Float, t: Float, u: Float, v: Float, limit: float) -> tuple[Float, Float, Bool]:
    """Fits the orientation to its inliers, twice, and returns it with them."""
    for _ in range(2):
        good = epipolar_inliers(R, t, u, v, limit)
        if good.sum() < 8:
            break
        start = colmap.Rigid3d(colmap.Rotation3d(R), t)
        better = colmap.refine_relative_pose(start, u, v, good)
        if better is None:
            break
        R = better["cam2_from_cam1"].rotation.matrix()
        t = np.array(better["cam2_from_cam1"].translation)
    return R, t, epipolar_inliers(R, t, u, v, limit)


def epipolar_inliers(R: Float, t: Float, u: Float, v: Float, limit: float) -> Bool:
    """Whether pairs of rays (n, 3) meet in front of both cameras, to `limit` rad."""
    E = skew(t / max(float(np.linalg.norm(t)), 1e-12)) @ R
    lines, back = u @ E.T, v @ E
    residual = np.abs((v * lines).sum(1))
    near = residual <= limit * np.sqrt((lines**2).sum(1) + (back**2).sum(1) + 1e-18)  # Sampson's distance
    ru = u @ R.T
    cosine = (ru * v).sum(1)
    depth_first = (v @ t) * cosine - ru @ t
    depth_second = v @ t - (ru @ t) * cosine
    slack = limit * np.linalg.norm(t)
    good: Bool = near & (depth_first > -slack) & (depth_second > -slack)
    return good


class _Band:
    """Gate that admits second key points near the epipolar line of the first."""

    def __init__(self, E: Float, u: Float, v: Float, limit: float) -> None:
        lines = u @ E.T
        self._lines = (lines / np.maximum(np.linalg.norm(lines, axis=1, keepdims=True), 1e-9)).astype(
            np.float32
        )
        self._rays = np.ascontiguousarray(v.T, np.float32)
        self._limit = np.float32(limit)

    def __call__(self, part: slice) -> Array:
        table = self._lines[part] @ self._rays
        near: Array = np.abs(table, out=table) < self._limit
        return near


def _guided(one: Sight, two: Sight, rows: Int, E: Float, limit: float) -> Int:
    """More matches (m, 2) along the epipolar lines of E, of key points that `rows` leave free."""
    free_a = np.setdiff1d(np.arange(len(one.looks)), rows[:, 0])
    free_b = np.setdiff1d(np.arange(len(two.looks)), rows[:, 1])
    band = _Band(E, one.rays[free_a], two.rays[free_b], limit)
    more = mutual(one.looks[free_a], two.looks[free_b], _GUIDED_RATIO, band)
    return np.column_stack([free_a[more[:, 0]], free_b[more[:, 1]]])


def _one_to_one(rows: Int) -> Int:
    """Rows (m, 2) of which no two share a key point; earlier ones win; sorted by the first column."""
    for column in (0, 1):
        _, keep = np.unique(rows[:, column], return_index=True)
        rows = rows[np.sort(keep)]
    return rows[np.argsort(rows[:, 0], kind="stable")]
