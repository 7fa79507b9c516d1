"""Which way is up? From the vertical edges of buildings in all photos of a block at once.

The two ends of an image segment and the camera span a plane; the planes of vertical edges all contain the
plumb line. The line is found from the cameras' axes, because photos are held level, and improved by the
segments within some degrees of it (robust total least squares on the normals of the planes).
"""

from collections.abc import Sequence

import cv2
import numpy as np
from scipy.stats import binom

from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import skew
from frontage.model import Photo
from frontage.orientation.reflectance.tones import ImageOf
from frontage.solve.robust import tukey_weights

_SIDE_PX = 1600  # pictures are reduced to this longer side
_SHORTEST = 0.03  # of the longer side
_NEAR = (np.radians(12.0), np.radians(5.0), np.radians(2.0), np.radians(2.0))  # rounds of the improvement
_STEP = np.radians(3.0)  # of tilts that are tried
_TILTS = _STEP * np.array(sorted(range(-10, 11), key=abs))  # of all cameras together
_USUAL_TILT = np.radians(20.0)
_ONE_WAY = 0.7  # length of the mean of unit vectors, above which cameras look about the same way
_LEAST_SEGMENTS = 12
_CHANCE = 1e-6  # probability by which edges may be upright by chance
_TILTED = 0.3  # weight of tilts, which are free, against that of being level
_ON_SIDE = 0.02  # added for a photo on its side: rare, and level photos that look one way fit both ways
_KEPT = 0.02  # weight of the start in the improvement
_MOST_PHOTOS = 12


def up_from_cameras(photos: Sequence[Photo]) -> Float:
    """Returns the direction (3,) that is up if the photos were held level, upright or on their side.

    Every axis of every picture, both ways, is tried. The best has, in every photo, one axis nearly at right
    angles and the other nearly parallel to it; it is then improved by least squares.
    """
    x = np.array([p.pose.R[:, 0] for p in photos])
    y = np.array([p.pose.R[:, 1] for p in photos])
    tried = np.concatenate([-y, y, x, -x])
    across, down = (x @ tried.T) ** 2, (y @ tried.T) ** 2
    held = across + _TILTED * (1.0 - down), down + _TILTED * (1.0 - across) + _ON_SIDE
    best = int(np.minimum(*held).sum(0).argmin())
    on_side = held[1][:, best] < held[0][:, best]
    level, start = np.where(on_side[:, None], y, x), tried[best]
    # Cameras that look the same way leave the turn about their level axis open: it stays as it was.
    A = level.T @ level + _KEPT * len(photos) * np.eye(3)
    up = np.linalg.solve(A, _KEPT * len(photos) * start)
    up /= np.linalg.norm(up)
    upright = (y @ up)[~on_side]
    return np.asarray(-up if len(upright) and np.median(upright) > 0 else up)


def plumb_line(photos: Sequence[Photo], image_of: ImageOf, up: Float) -> Float:
    """Improves an approximate direction `up` (3,), in the frame of the photos' poses, by vertical edges.

    The photos are taken to be held level; how far all of them look up or down is tried.
    """
    normals, length = _edges(photos, image_of)
    return _improved(_best_tilt(photos, up, normals, length), normals, length)


def plumb_line_within(photos: Sequence[Photo], image_of: ImageOf, up: Float, sigma: float) -> Float:
    """Improves a direction `up` (3,) that is known to `sigma` rad to either side, by vertical edges.

    Returns `up` where no direction has many more edges than chance would give it.
    """
    normals, length = _edges(photos, image_of)
    found = _improved(_likeliest(up, sigma, normals, length), normals, length)
    near = int((np.abs(normals @ found) < np.sin(_NEAR[-1])).sum())
    chance = binom.sf(near - 1, len(normals), np.sin(_NEAR[-1]))  # if edges have all directions alike
    return found if near >= _LEAST_SEGMENTS and chance < _CHANCE else up


def _edges(photos: Sequence[Photo], image_of: ImageOf) -> tuple[Float, Float]:
    """Normals (n, 3) of the planes of the segments in some of the photos, and their lengths (n,)."""
    step = max(1, len(photos) // _MOST_PHOTOS)
    parts = [_plane_normals(p, image_of(p.id)) for p in photos[::step]]
    return np.concatenate([n for n, _ in parts]), np.concatenate([w for _, w in parts])


def _improved(now: Float, normals: Float, length: Float) -> Float:
    """Robust total least squares from an approximate direction (3,)."""
    for near in _NEAR:
        off = np.arcsin(np.clip(normals @ now, -1.0, 1.0))
        good = np.abs(off) < near
        if good.sum() < _LEAST_SEGMENTS:
            break
        weight = length[good] * tukey_weights(off[good], near / 3.0)
        N = normals[good]
        now = _nearest_to(np.linalg.eigh((N * weight[:, None]).T @ N)[1][:, 0], now)
    return now


def _best_tilt(photos: Sequence[Photo], up: Float, normals: Float, length: Float) -> Float:
    """The direction (3,) with the most vertical edges, among those that differ by the tilt of all cameras.

    Cameras that look the same way do not tell how far they all look up or down.
    """
    level = np.mean([p.pose.R[:, 0] - (p.pose.R[:, 0] @ up) * up for p in photos], axis=0)
    if np.linalg.norm(level) < _ONE_WAY:
        return up
    across = np.cross(up, level / np.linalg.norm(level))
    tried = np.cos(_TILTS)[:, None] * up + np.sin(_TILTS)[:, None] * across
    return _with_most_edges(tried, _TILTS / _USUAL_TILT, normals, length)


def _likeliest(up: Float, sigma: float, normals: Float, length: Float) -> Float:
    """Returns the direction (3,) within three standard errors of `up` that makes the most edges vertical."""
    sigma = float(np.clip(sigma, 1e-9, _USUAL_TILT))
    steps = np.arange(np.ceil(3.0 * sigma / _STEP) + 1) * _STEP
    steps = np.concatenate([-steps[:0:-1], steps])
    a, b = (tilt.ravel() for tilt in np.meshgrid(steps, steps))
    across = turn_upright(up)[:2]
    tried = up + np.tan(a)[:, None] * across[0] + np.tan(b)[:, None] * across[1]
    tried /= np.linalg.norm(tried, axis=1, keepdims=True)
    return _with_most_edges(tried, np.hypot(a, b) / sigma, normals, length)


def _with_most_edges(tried: Float, off: Float, normals: Float, length: Float) -> Float:
    """Returns that one of the directions `tried` (k, 3) that makes the most edges vertical.

    A direction counts less the more standard errors `off` (k,) it lies from the approximate one.
    """
    away = np.arcsin(np.clip(normals @ tried.T, -1.0, 1.0))
    support = length @ tukey_weights(away, _NEAR[1] / 3.0) * np.exp(-0.5 * off**2)
    return np.asarray(tried[int(support.argmax())])


def _plane_normals(photo: Photo, rgb: Array) -> tuple[Float, Float]:
    """Unit normals (n, 3) of the planes through the camera and its segments, and the segments' lengths."""
    height, width = rgb.shape[:2]
    factor = max(1.0, max(height, width) / _SIDE_PX)
    small = cv2.resize(
        rgb[..., 1], (round(width / factor), round(height / factor)), interpolation=cv2.INTER_AREA
    )
    lines = cv2.createLineSegmentDetector().detect(small)[0]
    if lines is None:
        return np.empty((0, 3)), np.empty(0)
    ends = (lines.reshape(-1, 2, 2).astype(np.float64) + 0.5) * (
        width / small.shape[1],
        height / small.shape[0],
    )
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    long = length > _SHORTEST * max(height, width)
    first, last = (photo.pose.rotate(photo.camera.ray(ends[long, k])) for k in (0, 1))
    normal = np.cross(first, last)
    size = np.linalg.norm(normal, axis=1)
    good = np.isfinite(size) & (size > 1e-9)
    return normal[good] / size[good, None], length[long][good]


def _nearest_to(axis: Float, other: Float) -> Float:
    return np.asarray(axis if axis @ other > 0 else -axis)


def turn_upright(up: Float) -> Float:
    """Returns the smallest rotation (3, 3) that takes the unit vector `up` to the third axis."""
    z = np.array([0.0, 0.0, 1.0])
    axis = np.cross(up, z)
    sine, cosine = float(np.linalg.norm(axis)), float(up @ z)
    if sine < 1e-12:
        return np.eye(3) if cosine > 0 else np.diag([1.0, -1.0, -1.0])
    K = skew(axis / sine)
    return np.asarray(np.eye(3) + sine * K + (1 - cosine) * K @ K)
