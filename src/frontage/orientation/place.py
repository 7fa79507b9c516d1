"""Places a block of photos in the scan: first by its walls, without any point correspondence.

The walls of the block and of the scan are drawn alike. What is unknown about a pair of walls is a shift in
the wall and the relative size, which are searched exhaustively. A place is a similarity local_from_block.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from frontage.geometry.arrays import Float, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model import Photo
from frontage.orientation.correlate import Place, find_places
from frontage.orientation.gradients import Channels
from frontage.orientation.nouns import Block
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import ImageOf
from frontage.orientation.wallpicture import photos_on_wall, scan_on_wall
from frontage.orientation.walls import UprightWall, block_walls, scan_walls

COARSE_M, FINE_M = 0.16, 0.08  # pixels of the two searches
_COARSE_STEP, _FINE_STEP = 0.03, 0.01  # relative size
_AROUND = 0.04  # relative size, about a place of the coarse search
_NEAR_M = 1.0  # from a place of the coarse search
_DISTANCE_M = (4.0, 40.0)  # from cameras to a wall, where nothing else tells the size of a block
_TURN = 3.0  # sigmas of heading within which walls may belong together
_LEAST_TURN = np.radians(12.0)
_MOST_PHOTOS = 8  # that are drawn on a wall
_MARGIN = 0.15  # of its extent, by which a block's wall is drawn beyond the points that it was found from
_MOST_PX = 1200  # of the longer side of a block's wall
_FIRST = 10  # places of the coarse search that are looked at more closely
_KEPT = 6  # places that are returned
_PER_PAIR = 6  # places of a pair of walls


P = TypeVar("P", "PossiblePlace", "Fit")


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
class Start:
    """What is known of a block before it is compared with the scan.

    similarity  approximate; its rotation makes the third axis upright
    sigma_turn  rad, of the heading; inf = unknown
    sigma_size  relative, of the scale; inf = unknown
    sigma_shift m, of the place; inf = unknown
    """

    similarity: Similarity
    sigma_turn: float = np.inf
    sigma_size: float = np.inf
    sigma_shift: float = np.inf


@dataclass(frozen=True, eq=False)
class PossiblePlace:
    """A possible place of a block with its log likelihood over chance and its correlation coefficient."""

    similarity: Similarity
    gain: float
    score: float


def possible_places(
    block: Block, surface: ScannedSurface, image_of: ImageOf, start: Start, seed: int = 0
) -> list[PossiblePlace]:
    """Returns the most likely places of a block in the scan, the best first; empty if no wall fits any."""
    upright = _upright(block, start.similarity.R)
    size = start.similarity.scale
    centres = np.array([p.pose.t for p in upright.photos])
    theirs = block_walls(upright.points, centres, 1.0 / size, seed=seed)
    ours = scan_walls(surface.pieces)
    maps = {pixel: [scan_on_wall(surface, wall, pixel) for wall in ours] for pixel in (COARSE_M, FINE_M)}
    found: list[Fit] = []
    for wall in theirs:
        drawn = DrawnWall(_grown(wall), _unit(wall, centres, start, size), upright.photos, image_of)
        for k, host in enumerate(ours):
            if _may_meet(host, wall, start):
                sizes = possible_sizes(start.sigma_size, _COARSE_STEP)
                found += drawn.places(host, maps[COARSE_M][k], COARSE_M, sizes, k)
    found.sort(key=lambda f: -f.gain)
    coarse = [f for f in found if _agrees(f.similarity, start, upright)]
    fine = [_finer(fit, maps[FINE_M]) for fit in _distinct(coarse, _FIRST)]
    placed = [PossiblePlace(_composed(f.similarity, start.similarity.R), f.gain, f.score) for f in fine if f]
    return _distinct(sorted(placed, key=lambda p: -p.gain), _KEPT)


@dataclass(frozen=True, eq=False)
class DrawnWall:
    """A wall of the block, `unit` metres per block unit, which is drawn from photos when it is compared."""

    wall: UprightWall
    unit: float
    photos: Sequence[Photo]
    image_of: ImageOf

    def picture(self, metres: float) -> tuple[Channels, float]:
        """The wall with pixels of so many metres, and their size in block units."""
        pixel = max(metres / self.unit, max(_sides(self.wall)) / _MOST_PX)
        if metres not in self._kept:
            photos = _squarest(self.photos, self.wall)
            self._kept[metres] = photos_on_wall(photos, self.image_of, self.wall, pixel)
        return self._kept[metres], pixel

    @cached_property
    def _kept(self) -> dict[float, Channels]:
        return {}

    def places(
        self, host: UprightWall, chart: Channels, metres: float, sizes: Float, number: int
    ) -> list["Fit"]:
        """The best places of this wall on a wall of the scan; `sizes` relative to the approximate one."""
        picture, pixel = self.picture(metres)
        found = find_places(chart, picture, sizes * pixel * self.unit / metres)[:_PER_PAIR]
        return [
            Fit(
                _similarity(host, self.wall, place, pixel, metres),
                place.gain,
                place.score,
                self,
                host,
                number,
            )
            for place in found
        ]


@dataclass(frozen=True, eq=False)
class Fit:
    """A place of a wall of the (upright) block on a wall of the scan."""

    similarity: "Similarity"
    gain: float
    score: float
    drawn: DrawnWall
    host: UprightWall
    number: int


def _finer(fit: Fit, charts: Sequence[Channels]) -> Fit | None:
    """The best place near one of the coarse search; None when there is none."""
    now = fit.similarity.scale / fit.drawn.unit
    sizes = now * np.exp(np.arange(-_AROUND, _AROUND + 1e-9, _FINE_STEP))
    middle = fit.drawn.wall.pose.apply(_middle(fit.drawn.wall))
    for other in fit.drawn.places(fit.host, charts[fit.number], FINE_M, sizes, fit.number):
        moved = other.similarity.apply(middle) - fit.similarity.apply(middle)
        if np.linalg.norm(moved) < _NEAR_M:
            return other
    return None


def _middle(wall: UprightWall) -> Float:
    x0, z0, x1, z1 = wall.extent
    return np.array([[0.5 * (x0 + x1), 0.0, 0.5 * (z0 + z1)]])


def _upright(block: Block, R: Float) -> Block:
    """The block turned so that its third axis points up and its heading is the approximate one."""
    turn = Rigid3("block", "block", R, np.zeros(3))
    photos = tuple(
        replace(p, local_from_camera=replace(p.local_from_camera, value=turn.after(p.pose)))
        for p in block.photos
        if p.local_from_camera is not None
    )
    return replace(block, photos=photos, points=turn.apply(block.points))


def _unit(wall: UprightWall, centres: Float, start: Start, size: float) -> float:
    """Metres per block unit to draw the wall with: as known, or so that the cameras stand 12 m off."""
    if np.isfinite(start.sigma_size):
        return size
    distance = float(np.median(-wall.pose.inverse.apply(centres)[:, 1]))
    return float(np.sqrt(np.prod(_DISTANCE_M)) / max(distance, 1e-9))


def possible_sizes(sigma: float, step: float) -> Float:
    """Sizes (k,) within three sigmas of 1, or of walls seen from 4 m to 40 m when sigma is inf."""
    if np.isfinite(sigma):
        reach = min(3.0 * sigma + step, 1.2)
        low, high = -reach, reach
    else:
        middle = np.log(np.prod(_DISTANCE_M)) / 2.0
        low, high = (float(np.log(d) - middle) for d in _DISTANCE_M)
    return np.asarray(np.exp(np.arange(low, high + step, step)))


def _grown(wall: UprightWall) -> UprightWall:
    x0, z0, x1, z1 = wall.extent
    dx, dz = _MARGIN * (x1 - x0), _MARGIN * (z1 - z0)
    return replace(wall, extent=(x0 - dx, z0 - dz, x1 + dx, z1 + dz))


def _sides(wall: UprightWall) -> tuple[float, float]:
    x0, z0, x1, z1 = wall.extent
    return x1 - x0, z1 - z0


def _squarest(photos: Sequence[Photo], wall: UprightWall) -> list[Photo]:
    """The photos that look at the wall, the squarest views first, not more than are needed."""
    facing = [(float(p.pose.R[:, 2] @ wall.inward), k) for k, p in enumerate(photos)]
    return [photos[k] for cosine, k in sorted(facing, reverse=True)[:_MOST_PHOTOS] if cosine > 0.2]


def _may_meet(host: UprightWall, wall: UprightWall, start: Start) -> bool:
    turn = float(np.arccos(np.clip(host.inward @ wall.inward, -1.0, 1.0)))
    return turn < max(_TURN * start.sigma_turn, float(_LEAST_TURN))


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


def _composed(similarity: Similarity, turn: Float) -> Similarity:
    return replace(similarity, R=similarity.R @ turn)


def _agrees(similarity: Similarity, start: Start, upright: Block) -> bool:
    """Whether the cameras of the upright block stand where they may, as far as that is known."""
    if not np.isfinite(start.sigma_shift):
        return True
    centres = np.array([p.pose.t for p in upright.photos])
    expected = start.similarity.scale * centres + start.similarity.t
    off = similarity.apply(centres).mean(0) - expected.mean(0)
    return float(np.linalg.norm(off)) < 4.0 * start.sigma_shift + 0.5


def _distinct(places: Sequence[P], most: int) -> list[P]:
    """The first places without those that repeat an earlier one."""
    kept: list[P] = []
    for place in places:
        if len(kept) == most:
            break
        if all(_apart(place.similarity, other.similarity) for other in kept):
            kept.append(place)
    return kept


def _apart(a: Similarity, b: Similarity) -> bool:
    shifted, resized = np.linalg.norm(a.t - b.t), abs(np.log(a.scale / b.scale))
    return bool(shifted > 0.4 or resized > 0.05)
