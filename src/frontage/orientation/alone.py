"""Places a single photo that no other photo could be matched with, from its approximate pose.

Without such a pose, it is looked for beside the photos that were taken before and after it.

The photo is drawn on each wall of the scan that it may see, for headings within three sigmas of the given
one. Each drawing is searched for in the scan's own drawing of that wall, as for blocks. Control points found
at the best places then give the pose by resection (two points and the plumb line, in RANSAC).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3, rotation_angle
from frontage.model import Estimate, Photo, Provenance
from frontage.orientation.control import find_control
from frontage.orientation.drawnwall import DrawnWall, Fit, possible_sizes
from frontage.orientation.place import COARSE_M
from frontage.orientation.placed import agrees_with_prior
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import ImageOf
from frontage.orientation.resection import Resection, resect
from frontage.orientation.upright import plumb_line_within, turn_upright
from frontage.orientation.wallpicture import scan_on_wall
from frontage.orientation.walls import UprightWall, scan_walls

_TURN_STEP = np.radians(3.0)
_SIZE_STEP = 0.04
_LEAST_GAIN = 12.0
_TRIED = 12
_FEWEST = 20  # control points that agree
_LEAST_SHARE = 0.3  # of the control points found that must agree
_SURELY, _SURE_SHARE = 100, 0.7  # so many of them, and such a share, agree in one place only
_ELSEWHERE_M = 1.0  # less than the distance of two windows
_RIVAL = 0.6  # of the control points of a place, that agree in another one: the windows repeat
_MARGIN_M = 2.0
_SAME_M, _SAME_TURN = 0.5, np.radians(2.0)  # within which two places lead to the same control points
_PACE_M = 3.0  # least standard deviation of the way from one photo of a walk to the next
_LEVEL_M = 1.0  # standard deviation of the height: photos of a walk are taken from one height
_AIM = np.radians(20.0)  # standard deviation of the turn from one to the next
_LEVELS = ((3.0, 14, 3.0), (1.5, 12, 2.0))  # resolution, search radius, px of the rendering that agree


def place_alone(photo: Photo, surface: ScannedSurface, image_of: ImageOf, seed: int = 0) -> Photo | None:
    """Returns the photo with a pose that its own control points agree with.

    Returns None when there is none, or when two places agree with nearly as many.
    """
    given = photo.local_from_camera
    if given is None:
        return None
    fits = _fits(_levelled(photo, given, image_of), given, surface, image_of)
    starts = _starts(given, [(f.gain, f.similarity.pose(turned.pose)) for f, turned in fits])
    return best_place(photo, starts, surface, image_of, seed)


def _levelled(photo: Photo, given: Estimate[Rigid3], image_of: ImageOf) -> Photo:
    """The photo turned in its place so that its vertical edges are upright.

    Two points and the plumb line tell a pose only if that is known to a degree or so.
    """
    sigma = float(given.sigma[3:5].max())
    up = plumb_line_within([photo], image_of, np.array([0.0, 0.0, 1.0]), sigma)
    return _at(photo, Rigid3("local", "camera", turn_upright(up) @ given.value.R, given.value.t))


def best_place(
    photo: Photo, starts: Sequence[Rigid3], surface: ScannedSurface, image_of: ImageOf, seed: int = 0
) -> Photo | None:
    """Returns the photo at the place that most control points agree with, looked for from several starts.

    Returns None when there is none, or when another place comes near it. Places that contradict the
    approximate pose do not count.
    """
    tried: list[tuple[Resection, Photo]] = []
    for start in starts:
        found = _improved(_at(photo, start), surface, image_of, seed)
        if found is not None and agrees_with_prior(found[0].pose, photo):
            tried.append(found)
            if found[0].inliers.sum() >= _SURELY and found[0].inliers.mean() >= _SURE_SHARE:
                break
    if not tried:
        return None
    best, photo = max(tried, key=lambda t: int(t[0].inliers.sum()))
    others = [r for r, _ in tried if elsewhere(r.pose, best.pose)]
    rival = max((int(r.inliers.sum()) for r in others), default=0)
    return photo if rival < _RIVAL * best.inliers.sum() else None


def beside(number: int, photo: Photo, known: Mapping[int, Photo]) -> Photo:
    """Gives a photo without a pose that of the placed photo taken next to it; returns others unchanged.

    `known` are the placed photos by number, in the order in which they were taken. The standard error of the
    position is the usual distance from one photo to the next, times the number of steps to the placed one.
    """
    if photo.local_from_camera is not None or not known:
        return photo
    numbers = np.array(sorted(known))
    nearest = int(numbers[np.argmin(np.abs(numbers - number))])
    places = np.array([known[n].pose.t for n in numbers])
    way = np.linalg.norm(np.diff(places, axis=0), axis=1) / np.diff(numbers)
    pace = max(float(np.median(way)) if len(way) else 0.0, _PACE_M)
    shift = pace * abs(nearest - number)
    sigma = np.array([shift, shift, _LEVEL_M, *[_AIM] * 3])
    estimate = Estimate(known[nearest].pose, np.diag(sigma**2), 0.0, Provenance.INFERRED)
    return replace(photo, local_from_camera=estimate)


def elsewhere(a: Rigid3, b: Rigid3) -> bool:
    """Whether two poses are those of different places, such as one window apart."""
    return bool(np.linalg.norm(a.t - b.t) > _ELSEWHERE_M)


def _fits(
    photo: Photo, given: Estimate[Rigid3], surface: ScannedSurface, image_of: ImageOf
) -> list[tuple[Fit, Photo]]:
    """Places of the photo on walls of the scan, each with the turned photo that was drawn."""
    sigma_turn, sigma_shift = float(given.sigma[3:].max()), float(given.sigma[:3].max())
    reach = min(np.ceil(3.0 * sigma_turn / _TURN_STEP), 15)
    hosts = scan_walls(surface.pieces)
    found: list[tuple[Fit, Photo]] = []
    for number, host in enumerate(hosts):
        distance = -host.pose.inverse.apply(given.value.t[None])[0, 1]
        if distance < -3.0 * sigma_shift or photo.pose.R[:, 2] @ host.inward < 0.0:
            continue
        seen = _around(host, given.value.t, max(distance, 3.0), 3.0 * sigma_shift)
        chart = scan_on_wall(surface, host, COARSE_M)
        sizes = possible_sizes(min(sigma_shift / max(distance, 2.0), 0.4), _SIZE_STEP)
        for step in np.arange(-reach, reach + 1):
            turned = _turned(photo, float(step * _TURN_STEP))
            drawn = DrawnWall(seen, 1.0, [turned], image_of)
            found += [(fit, turned) for fit in drawn.places(host, chart, COARSE_M, sizes, number)]
    return found


def _starts(given: Estimate[Rigid3], found: Sequence[tuple[float, Rigid3]]) -> list[Rigid3]:
    """The likeliest of the poses found, with their gains, that are no repetitions of one another.

    The gain is a log likelihood over chance; that of the approximate position and heading is added.
    """
    off = np.array([pose.t - given.value.t for _, pose in found]).reshape(-1, 3)
    turn = np.array([rotation_angle(pose.R @ given.value.R.T) for _, pose in found])
    squared = ((off / given.sigma[:3]) ** 2).sum(1) + (turn / given.sigma[3:].max()) ** 2
    odds = np.array([gain for gain, _ in found]) - 0.5 * squared
    kept = list[Rigid3]()
    for k in np.argsort(-odds, kind="stable").tolist():
        if odds[k] < _LEAST_GAIN or len(kept) == _TRIED:
            break
        pose = found[k][1]
        if all(_apart(pose, other) for other in kept):
            kept.append(pose)
    return kept


def _apart(a: Rigid3, b: Rigid3) -> bool:
    """Whether two poses are so different that they do not lead to the same control points."""
    return bool(np.linalg.norm(a.t - b.t) > _SAME_M or rotation_angle(a.R @ b.R.T) > _SAME_TURN)


def _around(host: UprightWall, position: Float, distance: float, slack: float) -> UprightWall:
    """The part of a wall that a photo from this position may show."""
    x = float(host.pose.inverse.apply(position[None])[0, 0])
    reach = 1.5 * distance + slack
    x0, z0, x1, z1 = host.extent
    low, high = max(x0 - _MARGIN_M, x - reach), min(x1 + _MARGIN_M, x + reach)
    return replace(host, extent=(low, z0 - _MARGIN_M, max(high, low + 1.0), z1 + _MARGIN_M))


def _improved(
    photo: Photo, surface: ScannedSurface, image_of: ImageOf, seed: int
) -> tuple[Resection, Photo] | None:
    found: Resection | None = None
    for coarser, radius, agree in _LEVELS:
        control = find_control(photo, surface, image_of, coarser=coarser, radius=radius, unique=True)
        pixel = control.radius / radius
        up = photo.pose.R.T @ np.array([0.0, 0.0, 1.0])
        found = resect(photo.camera, control.pixels, control.xyz, agree * pixel, up=up, seed=seed)
        if found is None or found.inliers.sum() < max(_FEWEST, _LEAST_SHARE * len(control)):
            return None
        photo = _at(photo, found.pose)
    assert found is not None
    return found, photo


def _at(photo: Photo, pose: Rigid3) -> Photo:
    estimate = Estimate(pose, np.zeros((6, 6)), 0.0, Provenance.MEASURED)
    return replace(photo, local_from_camera=estimate)


def _turned(photo: Photo, angle: float) -> Photo:
    """The photo turned about the plumb line by an angle, rad, in its place."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ photo.pose.R
    return _at(photo, Rigid3("local", "camera", R, photo.pose.t))
