"""One wall of a block of photos, drawn to be found on a wall of the scan."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from frontage.geometry.arrays import Float, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model import Photo
from frontage.orientation.correlate import Place, find_places
from frontage.orientation.gradients import Channels
from frontage.orientation.reflectance.tones import ImageOf
from frontage.orientation.wallpicture import photos_on_wall
from frontage.orientation.walls import UprightWall

DISTANCE_M = (4.0, 40.0)
"""From cameras to a wall, where nothing else tells the size of a block."""

_MOST_PHOTOS = 8  # that are drawn on a wall
_MARGIN = 0.15  # of its extent, by which a block's wall is drawn beyond the points that it was found from
_SQUARE = 0.5  # cosine between a ray and the wall's normal, above which a photo shows the wall well
_MOST_PX = 1200  # of the longer side of a block's wall
_PER_PAIR = 6  # places of a pair of walls
_BEYOND_M = 3.0  # the end of a wall, where a photo may show more of it or of the next one
_LEAST_SIDE_M = 2.0  # of the part of a wall that a photo shows


@dataclass(frozen=True, eq=False)
class Similarity:
    """``x_local = scale R x_block + t``: R (3, 3), t (3,) m, scale in m per block unit."""

    scale: float
    R: Float
    t: Float

    def __post_init__(self) -> None:
        freeze(self, R=((3, 3), np.float64), t=((3,), np.float64))

    def apply(self, xyz: Float) -> Float:
        """Moves points (n, 3) of the block to local metres."""
        return np.asarray(self.scale * xyz @ self.R.T + self.t)

    def pose(self, block_from_camera: Rigid3) -> Rigid3:
        """Moves the pose of a camera; its frame keeps its size."""
        return Rigid3(
            "local", "camera", self.R @ block_from_camera.R, self.apply(block_from_camera.t[None])[0]
        )


@dataclass(frozen=True, eq=False)
class DrawnWall:
    """A wall of the block, `unit` metres per block unit, which is drawn from photos when it is compared."""

    wall: UprightWall
    unit: float
    photos: Sequence[Photo]
    image_of: ImageOf

    @property
    def longer(self) -> float:
        """The longer side of the wall in block units."""
        return max(_sides(self.wall))

    def picture(self, metres: float) -> tuple[Channels, float]:
        """The wall with pixels of so many metres, if its size is `unit`, and their size in block units."""
        pixel = max(metres / self.unit, self.longer / _MOST_PX)
        if pixel not in self._kept:
            photos = _squarest(self.photos, self.wall)
            self._kept[pixel] = photos_on_wall(photos, self.image_of, self.wall, pixel)
        return self._kept[pixel], pixel

    @cached_property
    def _kept(self) -> dict[float, Channels]:
        return {}

    def places(
        self,
        host: UprightWall,
        chart: Channels,
        metres: float,
        sizes: Float,
        number: int,
        prior: Callable[[Similarity], float] | None = None,
    ) -> list["Fit"]:
        """The likeliest places of this wall on a wall of the scan.

        chart   of the host, with pixels of `metres` m
        sizes   (k,) relative to the approximate one; the wall is drawn anew for every octave of them
        prior   log likelihood of a similarity local_from_(upright block), -inf if it cannot be; it is added
        """
        found = list[Fit]()
        octave = np.round(np.log2(sizes))
        for power in np.unique(octave):
            some = sizes[octave == power]
            picture, pixel = self.picture(metres / float(2.0**power))
            for place in find_places(chart, picture, some * pixel * self.unit / metres):
                similarity = _similarity(host, self.wall, place, pixel, metres)
                gain = place.gain + (0.0 if prior is None else prior(similarity))
                found.append(Fit(similarity, gain, place.score, self, host, number))
        likely = [fit for fit in found if np.isfinite(fit.gain)]
        return sorted(likely, key=lambda f: -f.gain)[:_PER_PAIR]


@dataclass(frozen=True, eq=False)
class Fit:
    """A place on a wall of the scan where a wall of the block may lie; the block is upright."""

    similarity: Similarity
    gain: float
    score: float
    drawn: DrawnWall
    host: UprightWall
    number: int


def possible_sizes(sigma: float, step: float) -> Float:
    """Sizes (k,) within three sigmas of 1, or of walls seen from 4 m to 40 m when sigma is inf."""
    if np.isfinite(sigma):
        reach = min(3.0 * sigma + step, 1.2)
        low, high = -reach, reach
    else:
        middle = np.log(np.prod(DISTANCE_M)) / 2.0
        low, high = (float(np.log(d) - middle) for d in DISTANCE_M)
    return np.asarray(np.exp(np.arange(low, high + step, step)))


def grown(wall: UprightWall, photos: Sequence[Photo]) -> UprightWall:
    """The wall with a margin, or as far as the photos show it from not too far aside, if that is more.

    Two photos that hardly overlap have their tie points in a strip, and see much more of the wall. The more
    photos there are, the less of it lies beyond their tie points, and larger walls take more time.
    """
    x0, z0, x1, z1 = wall.extent
    margin = _MARGIN * np.array([x1 - x0, z1 - z0])
    reach = np.maximum(margin, max(x1 - x0, z1 - z0) / max(len(photos) - 1, 1))
    low, high = np.array([x0, z0]), np.array([x1, z1])
    shown = np.concatenate([[low, high], *(_shown(photo, wall) for photo in _squarest(photos, wall))])
    low = np.minimum(low - margin, np.maximum(shown.min(0), low - reach))
    high = np.maximum(high + margin, np.minimum(shown.max(0), high + reach))
    return replace(wall, extent=(float(low[0]), float(low[1]), float(high[0]), float(high[1])))


def shown_part(photo: Photo, wall: UprightWall) -> UprightWall | None:
    """Returns the part of a wall, and of its plane just beyond it, that a photo shows; None if hardly any."""
    shown = _shown(photo, wall)
    if not len(shown) or not _squarest([photo], wall):
        return None
    x0, z0, x1, z1 = wall.extent
    low = np.maximum(shown.min(0), np.array([x0, z0]) - _BEYOND_M)
    high = np.minimum(shown.max(0), np.array([x1, z1]) + _BEYOND_M)
    if (high - low).min() < _LEAST_SIDE_M:
        return None
    return replace(wall, extent=(float(low[0]), float(low[1]), float(high[0]), float(high[1])))


def _shown(photo: Photo, wall: UprightWall) -> Float:
    """Places (k, 2) on a wall, to the right and up, that rays of a photo meet at less than 60 degrees."""
    camera = photo.camera
    x, y = np.meshgrid(np.linspace(1, camera.width - 1, 9), np.linspace(1, camera.height - 1, 9))
    ray = wall.pose.inverse.rotate(photo.pose.rotate(camera.ray(np.column_stack([x.ravel(), y.ravel()]))))
    start = wall.pose.inverse.apply(photo.pose.t[None])[0]
    ray = ray[np.isfinite(ray).all(1) & (ray[:, 1] > _SQUARE)]
    return np.asarray((start - ray * (start[1] / ray[:, 1])[:, None])[:, ::2])


def _sides(wall: UprightWall) -> tuple[float, float]:
    x0, z0, x1, z1 = wall.extent
    return x1 - x0, z1 - z0


def _squarest(photos: Sequence[Photo], wall: UprightWall) -> list[Photo]:
    """Returns the photos that show the wall least obliquely, the best first, and no more than are needed."""
    facing = [(float(p.pose.R[:, 2] @ wall.inward), k) for k, p in enumerate(photos)]
    return [photos[k] for cosine, k in sorted(facing, reverse=True)[:_MOST_PHOTOS] if cosine > 0.2]


def _similarity(
    host: UprightWall, wall: UprightWall, place: Place, pixel: float, metres: float
) -> Similarity:
    """The similarity local_from_(upright block) that lays the block's wall on the scan's."""
    scale = place.size * metres / pixel
    R = host.pose.R @ wall.pose.R.T
    corner_block = wall.pose.apply(np.array([[wall.extent[0], 0.0, wall.extent[3]]]))[0]
    x, z = host.extent[0] + place.column * metres, host.extent[3] - place.row * metres
    corner_local = host.pose.apply(np.array([[x, 0.0, z]]))[0]
    return Similarity(scale, R, corner_local - scale * R @ corner_block)
