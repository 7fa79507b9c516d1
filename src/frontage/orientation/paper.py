"""The orientation of photos as in paper B, kept as a baseline that can be selected and compared with.

Becker and Haala (2008, section 2.2.2, after Boehm and Becker 2007) look for SIFT key points in the
reflectance image of the scan and in the green channel of a photo, match them, and remove wrong matches by a
closed-form space resection in RANSAC. The matches that agree are the control points of the photo, and their
adjustment gives the pose with its standard errors. Approximate poses are not used.

What the paper leaves open is filled in here: 0.8 for the ratio of the distances to the two nearest
descriptors (Lowe 2004), P3P for the resection, and 3 mrad, four centimetres at twelve metres, for what
agrees.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float, Int, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model import Camera, Estimate, Photo, Scan
from frontage.orientation.reflectance.raster import ReflectanceImage, reflectance_images
from frontage.orientation.reflectance.tones import ImageOf
from frontage.orientation.resection import Resection, resect

_GREEN = 1  # "only the green channel of the photograph has been considered"
_SIDE_PX = 3200  # longer side to which photos are reduced before key points are found
_RATIO = 0.8
_AGREE_RAD = 0.003
_FEWEST = 10  # control points of a pose; six or seven of a hundred wrong matches agree by chance
_ROUNDS = 3  # in which matches are taken anew
_BLOCK = 512  # rows of a product of descriptors
_STEPS, _STEP = 20, 1e-6  # of the adjustment: their number, and that of the numerical derivatives (m, rad)


@dataclass(frozen=True, eq=False)
class PaperPhoto:
    """What the paper's chain found of one photo.

    id       of the photo
    photo    with its pose and the covariance (6, 6) of that; None where no ten matches agree with one
    matched  number of key points of the scan that were matched, right or wrong
    pixels   (n, 2) px, the control points that agree, in the photo
    xyz      (n, 3) m local, in the scan
    rms      px per axis, of their residuals; NaN without any
    """

    id: str
    photo: Photo | None
    matched: int
    pixels: Float
    xyz: Float
    rms: float

    def __post_init__(self) -> None:
        n = len(self.pixels)
        freeze(self, pixels=((n, 2), np.float64), xyz=((n, 3), np.float64))


@dataclass(frozen=True, eq=False)
class _Keys:
    """Key points of a picture: `at` (n, 2) px, first pixel centre at 0.5, and unit descriptors (n, 128)."""

    at: Float
    looks: Array


def orient_as_paper(
    photos: Sequence[Photo],
    scans: Scan | Sequence[Scan],
    image_of: ImageOf,
    *,
    source: str = "auto",
    ratio: float = _RATIO,
    agree: float = _AGREE_RAD,
    seed: int = 0,
) -> tuple[PaperPhoto, ...]:
    """Orients every photo on its own in the frame of the scans, as the paper does.

    photos    with cameras; their poses are not used
    scans     structured ones, or clouds with known stations
    image_of  returns the picture (h, w, 3) uint8 of a photo id
    source    "intensity", "colour" or "auto": what of the scans is compared
    ratio     largest distance to the nearest descriptor, per distance to the second nearest
    agree     rad, largest angle between a match and a pose that it agrees with

    Raises ValueError for a scan that no reflectance image can be made of.
    """
    given = (scans,) if isinstance(scans, Scan) else scans
    pictures = [picture for scan in given for picture in reflectance_images(scan, source, seed=seed)]
    control = [_on_surface(picture) for picture in pictures]
    return tuple(_oriented(photo, control, image_of, ratio, agree, seed) for photo in photos)


def match_reflectance(
    photo: Photo, picture: ReflectanceImage, image_of: ImageOf, ratio: float = _RATIO
) -> tuple[Float, Float]:
    """Returns pixels (n, 2) of a photo and points (n, 3) m local of the scan that look alike."""
    keys, xyz = _on_surface(picture)
    theirs = _photo_keys(photo, image_of)
    rows = _matches(keys.looks, theirs.looks, ratio)
    return theirs.at[rows[:, 1]], xyz[rows[:, 0]]


def refine_pose(
    camera: Camera, pixels: Float, xyz: Float, start: Rigid3
) -> tuple[Estimate[Rigid3], Float] | None:
    """Adjusts a pose local_from_camera to control points by least squares.

    pixels  (n, 2) px; xyz (n, 3) m local, without errors

    Returns the pose with its covariance (6, 6) from the residuals, and the residuals (n, 2) px, computed
    minus measured. Returns None for fewer than four points, or where they do not determine the pose.
    """
    if len(pixels) < 4:
        return None
    pose = start
    for _ in range(_STEPS):
        off = camera.project(pose.inverse.apply(xyz)) - pixels
        slope = _derivatives(camera, xyz, pose)
        if not (np.isfinite(off).all() and np.isfinite(slope).all()):
            return None
        step = np.asarray(np.linalg.lstsq(slope, -off.ravel(), rcond=None)[0], np.float64)
        pose = _moved(pose, step)
        if np.abs(step).max() < 1e-9:
            break
    off = camera.project(pose.inverse.apply(xyz)) - pixels
    slope = _derivatives(camera, xyz, pose)
    dof = off.size - 6
    normal = slope.T @ slope
    if not np.isfinite(normal).all() or np.linalg.cond(normal) > 1e14:
        return None
    covariance = np.linalg.inv(normal) * float((off**2).sum()) / dof
    return Estimate(pose, 0.5 * (covariance + covariance.T), float(dof)), off


def _oriented(
    photo: Photo,
    control: Sequence[tuple[_Keys, Float]],
    image_of: ImageOf,
    ratio: float,
    agree: float,
    seed: int,
) -> PaperPhoto:
    """The photo from its matches with all pictures of the scans together."""
    theirs = _photo_keys(photo, image_of)
    pairs = [_matches(keys.looks, theirs.looks, ratio) for keys, _ in control]
    pixels = np.concatenate([np.empty((0, 2)), *(theirs.at[rows[:, 1]] for rows in pairs)])
    parts = [xyz[rows[:, 0]] for (_, xyz), rows in zip(control, pairs, strict=True)]
    pixels, xyz = _distinct(pixels, np.concatenate([np.empty((0, 3)), *parts]))
    threshold = agree * float(photo.camera.params[0])
    found = _resected(photo.camera, pixels, xyz, threshold, seed)
    nothing = PaperPhoto(photo.id, None, len(pixels), np.empty((0, 2)), np.empty((0, 3)), float("nan"))
    if found is None:
        return nothing
    fitted = _adjusted(photo.camera, pixels, xyz, found, threshold)
    if fitted is None:
        return nothing
    estimate, rows, residuals = fitted
    posed, rms = replace(photo, local_from_camera=estimate), float(np.sqrt(np.mean(residuals**2)))
    return PaperPhoto(photo.id, posed, len(pixels), pixels[rows], xyz[rows], rms)


def _resected(camera: Camera, pixels: Float, xyz: Float, threshold: float, seed: int) -> Resection | None:
    """The space resection; None where the best that chance offers is points that fall on one another."""
    try:
        return resect(camera, pixels, xyz, threshold, seed=seed)
    except cv2.error:
        return None


def _adjusted(
    camera: Camera, pixels: Float, xyz: Float, found: Resection, threshold: float
) -> tuple[Estimate[Rigid3], Int, Float] | None:
    """The pose that fits all matches (rows) which agree with it, and their residuals px."""
    rows, pose = np.flatnonzero(found.inliers), found.pose
    for _ in range(_ROUNDS):
        refined = refine_pose(camera, pixels[rows], xyz[rows], pose)
        if refined is None:
            return None
        pose = refined[0].value
        off = camera.project(pose.inverse.apply(xyz)) - pixels
        agreeing = np.flatnonzero(np.nan_to_num(np.linalg.norm(off, axis=1), nan=np.inf) < threshold)
        if len(agreeing) < _FEWEST or np.array_equal(agreeing, rows):
            break
        rows = agreeing
    if len(rows) < _FEWEST:
        return None
    refined = refine_pose(camera, pixels[rows], xyz[rows], pose)
    return None if refined is None else (refined[0], rows, refined[1])


def _on_surface(picture: ReflectanceImage) -> tuple[_Keys, Float]:
    """The key points of a reflectance image that have a 3-D point, and the points (n, 3) m."""
    keys = _keys(np.ascontiguousarray(picture.pixels))
    xyz = picture.points(keys.at)
    there = np.isfinite(xyz).all(1)
    return _Keys(keys.at[there], keys.looks[there]), xyz[there]


def _photo_keys(photo: Photo, image_of: ImageOf) -> _Keys:
    """The key points of the green channel, in pixels of the full picture."""
    green = np.ascontiguousarray(image_of(photo.id)[..., _GREEN])
    h, w = green.shape
    factor = min(1.0, _SIDE_PX / max(h, w))
    size = (round(w * factor), round(h * factor))
    keys = _keys(cv2.resize(green, size, interpolation=cv2.INTER_AREA) if factor < 1.0 else green)
    return _Keys(keys.at * (w / size[0], h / size[1]), keys.looks)


def _keys(grey: Array) -> _Keys:
    """SIFT key points (Lowe 2004) with default settings."""
    found, looks = cv2.SIFT.create(enable_precise_upscale=True).detectAndCompute(grey, None)
    if looks is None:
        return _Keys(np.empty((0, 2)), np.empty((0, 128), np.float32))
    length = np.maximum(np.linalg.norm(looks, axis=1, keepdims=True), 1e-6)
    return _Keys(np.array([k.pt for k in found], np.float64) + 0.5, (looks / length).astype(np.float32))


def _matches(a: Array, b: Array, ratio: float) -> Int:
    """Pairs (m, 2): each of a (n, 128) with its nearest of b (k, 128), unless the second is as near."""
    pairs = [np.empty((0, 2), np.int64)]
    for first in range(0, len(a) if len(b) > 1 else 0, _BLOCK):
        cosine = a[first : first + _BLOCK] @ b.T
        two = np.argpartition(-cosine, 1, axis=1)[:, :2]
        distance = np.sqrt(np.maximum(2.0 - 2.0 * np.take_along_axis(cosine, two, 1), 0.0))
        swap = distance[:, 0] > distance[:, 1]
        nearest = np.where(swap, two[:, 1], two[:, 0])
        good = np.flatnonzero(distance.min(1) < ratio * distance.max(1))
        pairs.append(np.column_stack([first + good, nearest[good]]))
    return np.concatenate(pairs).astype(np.int64)


def _distinct(pixels: Float, xyz: Float) -> tuple[Float, Float]:
    """Matches (n, 2) px, (n, 3) m without repetitions: SIFT describes one place for several directions."""
    places = np.round(np.column_stack([pixels, 100.0 * xyz])).astype(np.int64)
    rows = np.sort(np.unique(places, axis=0, return_index=True)[1])
    return pixels[rows], xyz[rows]


def _derivatives(camera: Camera, xyz: Float, pose: Rigid3) -> Float:
    """Derivatives (2 n, 6) px of the pixels of points by the pose, translation first."""
    columns = []
    for axis in np.eye(6):
        ahead, behind = (
            camera.project(_moved(pose, s * _STEP * axis).inverse.apply(xyz)) for s in (1.0, -1.0)
        )
        columns.append(((ahead - behind) / (2.0 * _STEP)).ravel())
    return np.column_stack(columns)


def _moved(pose: Rigid3, step: Float) -> Rigid3:
    """The pose after a small motion (6,), in the tangent order of `geometry.rigid`."""
    return Rigid3("local", "camera", cv2.Rodrigues(step[3:])[0] @ pose.R, pose.t + step[:3])
