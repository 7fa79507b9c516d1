"""Placed photos, each with the scan drawn as it sees it, and what they tell of one another through it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import Camera, Photo
from frontage.orientation.adjustment.derivatives import by_point
from frontage.orientation.network import TIE_SIGMA_PX
from frontage.orientation.placed import Placed, Scene
from frontage.orientation.reflectance.depths import local_planes
from frontage.orientation.reflectance.render import Rendering, render, rendering_factor

FEWEST = 20
"""Points of a pair of photos that agree, below which they tell nothing."""


class Views:
    """The placed photos by number, each with the scan drawn as it sees it, when that is asked for."""

    def __init__(self, scene: Scene, parts: Iterable[Placed] = ()) -> None:
        self._scene = scene
        self._photos: dict[int, Photo] = {}
        self._drawn: dict[int, Rendering] = {}
        self._seen: dict[tuple[int, int], Seen] = {}
        for part in parts:
            self.add(part)

    def add(self, part: Placed) -> None:
        """Adds photos that got a place."""
        self._photos.update(zip(part.numbers.tolist(), part.photos, strict=True))

    def points(self, number: int) -> list["Seen"]:
        """What each of the placed neighbours of a photo tells of it, where that is enough."""
        found = []
        for common in self._scene.common:
            for own, other in ((0, 1), (1, 0)):
                numbers = common.first, common.second
                if numbers[own] == number and numbers[other] in self._photos:
                    found.append(self._told(number, numbers[other], common.pixels[:, (own, other)]))
        return [seen for seen in found if len(seen.pixels) >= FEWEST]

    def off(self, first: int, second: int, pixels: Float) -> Float:
        """How far (m,) the second of pixels (m, 2, 2) is from where the scan puts what the first one shows.

        In standard errors of that distance, which are those of both measurements, seen through the surface,
        and that of the surface along the ray. Errors of the poses are not among them. NaN where the first
        photo sees nothing of the scan.
        """
        drawing, photo = self._drawing(first), self._photos[second]
        camera, pose = drawing.photo.camera, drawing.photo.pose
        planes = local_planes(drawing, pixels[:, 0])
        ray = camera.ray(pixels[:, 0])
        ray /= ray[:, 2:]
        xyz = ray * planes.depth[:, None]
        # A step of a pixel moves the point aside and, on a slanted surface, along the ray as well.
        aside = planes.depth[:, None, None] * _by_pixel(camera, ray) + ray[:, :, None] * planes.slope[:, None]
        along = np.hypot(planes.rough, self._scene.surface.sigma)
        error = np.concatenate([TIE_SIGMA_PX * aside, (along[:, None] * ray)[:, :, None]], axis=2)
        there = photo.pose.inverse.apply(pose.apply(xyz))
        turn = photo.pose.R.T @ pose.R
        seen = by_point(photo.camera, there) @ turn @ error
        covariance = seen @ seen.swapaxes(1, 2) + TIE_SIGMA_PX**2 * np.eye(2)
        off = photo.camera.project(there) - pixels[:, 1]
        good = np.isfinite(off).all(1) & np.isfinite(covariance).all((1, 2))
        distance = np.full(len(off), np.nan)
        weighted = np.linalg.solve(covariance[good], off[good][..., None])[..., 0]
        distance[good] = np.sqrt((off[good] * weighted).sum(1))
        return distance

    def _told(self, number: int, neighbour: int, pixels: Float) -> "Seen":
        """What one neighbour tells of a photo, from pixels (m, 2, 2) in the photo and in the neighbour."""
        if (number, neighbour) not in self._seen:
            drawing = self._drawing(neighbour)
            xyz = drawing.behind(pixels[:, 1])
            there = np.isfinite(xyz).all(1)
            away = np.linalg.norm(xyz[there] - drawing.photo.pose.t, axis=1)
            self._seen[number, neighbour] = Seen(pixels[there, 0], xyz[there], away)
        return self._seen[number, neighbour]

    def _drawing(self, number: int) -> Rendering:
        if number not in self._drawn:
            photo, surface = self._photos[number], self._scene.surface
            self._drawn[number] = render(photo, surface, rendering_factor(photo, surface))
        return self._drawn[number]


@dataclass(frozen=True, eq=False)
class Seen:
    """What a neighbour tells of a photo.

    pixels  (n, 2) px, places in the photo
    xyz     (n, 3) m, points of the scan that the neighbour sees there
    away    (n,) m, how far these points are from the neighbour
    """

    pixels: Float
    xyz: Float
    away: Float

    @staticmethod
    def joined(parts: Sequence["Seen"]) -> "Seen":
        """What several neighbours tell, one after the other."""
        return Seen(*(np.concatenate([getattr(p, f) for p in parts]) for f in ("pixels", "xyz", "away")))


def _by_pixel(camera: Camera, ray: Float) -> Float:
    """Derivative (m, 3, 2), per px, of rays (m, 3) that are 1 long along the axis; the axis stays."""
    inverse = np.linalg.inv(by_point(camera, ray)[:, :, :2])
    return np.concatenate([inverse, np.zeros((len(ray), 1, 2))], axis=1)
