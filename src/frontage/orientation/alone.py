"""Places a single photo that no other photo could be matched with, from its approximate pose.

The photo is drawn on each wall of the scan that it may see, for headings within three sigmas of the given
one. Each drawing is searched for in the scan's own drawing of that wall, as for blocks. Control points found
at the best places then give the pose by resection (two points and the plumb line, in RANSAC).
"""

from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Photo, Provenance
from frontage.orientation.control import find_control
from frontage.orientation.place import COARSE_M, DrawnWall, Fit, possible_sizes
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import ImageOf
from frontage.orientation.resection import Resection, resect
from frontage.orientation.wallpicture import scan_on_wall
from frontage.orientation.walls import UprightWall, scan_walls

_TURN_STEP = np.radians(3.0)
_SIZE_STEP = 0.04
_LEAST_GAIN = 12.0
_TRIED = 6
_FEWEST = 20  # control points that agree
_LEAST_SHARE = 0.3  # of the control points found that must agree
_MARGIN_M = 2.0
_LEVELS = ((3.0, 14, 3.0), (1.5, 12, 2.0))  # resolution, search radius, px of the rendering that agree


def place_alone(photo: Photo, surface: ScannedSurface, image_of: ImageOf, seed: int = 0) -> Photo | None:
    """Returns the photo with a pose that its own control points agree with; None when there is none."""
    given = photo.local_from_camera
    if given is None:
        return None
    fits = sorted(_fits(photo, given, surface, image_of), key=lambda f: -f[0].gain)
    best: tuple[Resection, Photo] | None = None
    for fit, turned in fits[:_TRIED]:
        if fit.gain < _LEAST_GAIN:
            break
        start = fit.similarity.pose(turned.pose)
        found = _improved(_at(photo, start), surface, image_of, seed)
        if found is not None and (best is None or found[0].inliers.sum() > best[0].inliers.sum()):
            best = found
    return None if best is None else best[1]


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
