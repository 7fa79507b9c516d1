"""Which pairs of photos are worth matching in full."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.model import Photo
from frontage.orientation.nouns import KeyPoints
from frontage.orientation.ties.matches import mutual, unit

_ALL_OF = 12  # photos of which all pairs are matched anyway
_COARSE = 2000  # key points of the largest scale that are tried first
_RATIO = 0.65  # stricter than for the full match, because chance matches would hide what is sought
_ALIKE = 6  # matches among them that make a pair worth while
_NEIGHBOURS = 8  # pairs per photo that are kept however few their matches
_DEPTHS_M = np.array([3.0, 6.0, 12.0, 25.0, 50.0])  # of a street scene
_GRID = 5  # rays per side of a picture
_SIGMAS = 3.0
_OBLIQUE = np.radians(80.0)  # angle between two rays to a point beyond which SIFT matches nothing


def candidate_pairs(photos: Sequence[Photo], keypoints: Sequence[KeyPoints]) -> list[tuple[int, int]]:
    """Returns the pairs (i, j), i < j, that may show the same thing, in ascending order.

    Pairs whose approximate poses let no view overlap are left out. Of more than a dozen photos, the two
    thousand largest key points of each are matched first, which costs a fiftieth, and pairs without any
    success are left out as well; every photo keeps its eight best ones.
    """
    pairs = [(i, j) for i, j in combinations(range(len(photos)), 2) if may_overlap(photos[i], photos[j])]
    if len(photos) <= _ALL_OF:
        return pairs
    coarse = [unit(k.descriptors[:_COARSE]) for k in keypoints]
    alike = np.array([len(mutual(coarse[i], coarse[j], _RATIO)) for i, j in pairs])
    keep = alike >= _ALIKE
    table = np.array(pairs, np.int64).reshape(-1, 2)
    for photo in range(len(photos)):
        mine = np.flatnonzero((table == photo).any(1))
        keep[mine[np.argsort(-alike[mine], kind="stable")[:_NEIGHBOURS]]] = True
    return [pair for pair, good in zip(pairs, keep.tolist(), strict=True) if good]


def may_overlap(a: Photo, b: Photo) -> bool:
    """Whether two photos can show the same thing, to three sigmas of their poses; true without poses."""
    if a.local_from_camera is None or b.local_from_camera is None:
        return True
    return _sees(a, b) or _sees(b, a)


def _sees(a: Photo, b: Photo) -> bool:
    """Whether photo b sees any of the places that photo a may show."""
    w, h = a.camera.width, a.camera.height
    grid = (np.arange(_GRID) + 0.5) / _GRID
    pixels = np.column_stack([np.repeat(grid * w, _GRID), np.tile(grid * h, _GRID)])
    rays = a.pose.rotate(a.camera.ray(pixels))
    xyz = (a.pose.t + rays[:, None] * _DEPTHS_M[:, None]).reshape(-1, 3)
    towards_a = np.repeat(-rays, len(_DEPTHS_M), axis=0)
    towards_b = b.pose.t - xyz
    distance = np.linalg.norm(towards_b, axis=1)
    slack = _slack(a, b, distance)
    facing = np.arccos(np.clip((towards_a * towards_b).sum(1) / np.maximum(distance, 1e-9), -1, 1))
    return bool((_inside(b, -towards_b, slack) & (facing < _OBLIQUE + slack)).any())


def _slack(a: Photo, b: Photo, distance: Float) -> Float:
    """Angle (n,) rad by which the poses of two photos may be wrong, for places at some distance (n,) m."""
    place = angle = 0.0
    for photo in (a, b):
        assert photo.local_from_camera is not None
        sigma = photo.local_from_camera.sigma
        place, angle = place + float((sigma[:3] ** 2).max()), angle + float((sigma[3:] ** 2).max())
    rad: Float = _SIGMAS * np.sqrt(angle + place / np.maximum(distance, 0.5) ** 2)
    return rad


def _inside(photo: Photo, directions: Float, slack: Float) -> Bool:
    """Whether directions (n, 3) lie in the picture's cone, widened by `slack` (n,) rad."""
    w, h = photo.camera.width, photo.camera.height
    rays = photo.camera.ray(np.array([[w / 2, h / 2], [0.0, 0.0], [w, 0.0], [0.0, h], [w, h]]))
    rays = rays[np.isfinite(rays).all(1)]
    if len(rays) < 5:
        return np.ones(len(directions), np.bool_)
    cone = np.arccos(np.clip(rays[1:] @ rays[0], -1, 1)).max()
    axis = photo.pose.rotate(rays[:1])[0]
    cosine = directions @ axis / np.maximum(np.linalg.norm(directions, axis=1), 1e-9)
    inside: Bool = np.arccos(np.clip(cosine, -1, 1)) < cone + slack
    return inside
