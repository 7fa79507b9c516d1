"""Places a block of photos in the scan: first by its walls, without any point correspondence.

The walls of the block and of the scan are drawn alike. What is unknown about a pair of walls is a shift in
the wall and the relative size, which are searched exhaustively. A place is a similarity local_from_block.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.orientation.drawnwall import DISTANCE_M, DrawnWall, Fit, Similarity, grown, possible_sizes
from frontage.orientation.gradients import Channels
from frontage.orientation.nouns import Block
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import ImageOf
from frontage.orientation.wallpicture import scan_on_wall
from frontage.orientation.walls import UprightWall, block_walls, scan_walls

COARSE_M, FINE_M = 0.16, 0.08
"""Pixels of the search over all places. Where the first finds nothing, small texture may tell a place."""

_FINER = 0.5  # pixel near the best places, relative to that of the search over all places
_STEP, _FINER_STEP = 0.03, 0.01  # relative size, with pixels of 16 cm
_AROUND = 0.04  # relative size, about a place of the first search, with pixels of 16 cm
_NEAR_M = 1.0  # from a place of the search over all places
_TURN = 3.0  # sigmas of heading within which walls may belong together
_LEAST_TURN = np.radians(12.0)
_LONGEST_M = 100.0  # of a wall whose size nothing tells
_FIRST = 10  # places of the search over all places that are looked at more closely
_KEPT = 6  # places that are returned


P = TypeVar("P", "PossiblePlace", "Fit")


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
    """A possible place of a block with its log likelihood over chance and its correlation coefficient.

    The likelihood is that of the pictures and of the approximate positions.
    """

    similarity: Similarity
    gain: float
    score: float


def possible_places(
    block: Block,
    surface: ScannedSurface,
    image_of: ImageOf,
    start: Start,
    seed: int = 0,
    pixel: float = COARSE_M,
) -> list[PossiblePlace]:
    """Returns the most likely places of a block in the scan, the best first; empty if no wall fits any.

    pixel  m, with which walls are compared at all places; half of it near the best ones
    """
    upright = _upright(block, start.similarity.R)
    size = start.similarity.scale
    centres = np.array([p.pose.t for p in upright.photos])
    theirs = block_walls(upright.points, centres, 1.0 / size, seed=seed)
    ours = scan_walls(surface.pieces)
    charts, finer = ([scan_on_wall(surface, wall, m) for wall in ours] for m in (pixel, _FINER * pixel))
    prior = partial(_log_prior, start=start, upright=upright)
    found: list[Fit] = []
    for wall in theirs:
        shown, unit = grown(wall, upright.photos), _unit(wall, centres, start, size)
        drawn = DrawnWall(shown, unit, upright.photos, image_of)
        sizes = possible_sizes(start.sigma_size, _STEP * pixel / COARSE_M)
        sizes = _sensible(sizes, start, unit * drawn.longer)
        for k, host in enumerate(ours):
            if len(sizes) and _may_meet(host, wall, start):
                found += drawn.places(host, charts[k], pixel, sizes, k, prior)
    found.sort(key=lambda f: -f.gain)
    fine = [_finer(fit, finer, _FINER * pixel, prior) for fit in distinct(found, _FIRST)]
    placed = [PossiblePlace(_composed(f.similarity, start.similarity.R), f.gain, f.score) for f in fine if f]
    return distinct(sorted(placed, key=lambda p: -p.gain), _KEPT)


def distinct(places: Sequence[P], most: int) -> list[P]:
    """Returns the first places, at `most` so many, without those that repeat an earlier one."""
    kept: list[P] = []
    for place in places:
        if len(kept) == most:
            break
        if all(_apart(place.similarity, other.similarity) for other in kept):
            kept.append(place)
    return kept


def _finer(
    fit: Fit, charts: Sequence[Channels], pixel: float, prior: Callable[[Similarity], float]
) -> Fit | None:
    """The best place near one of the search over all places; None when there is none."""
    relative = pixel / (_FINER * COARSE_M)
    now = fit.similarity.scale / fit.drawn.unit
    sizes = now * np.exp(relative * np.arange(-_AROUND, _AROUND + 1e-9, _FINER_STEP))
    middle = fit.drawn.wall.pose.apply(_middle(fit.drawn.wall))
    for other in fit.drawn.places(fit.host, charts[fit.number], pixel, sizes, fit.number, prior):
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
    return float(np.sqrt(np.prod(DISTANCE_M)) / max(distance, 1e-9))


def _sensible(sizes: Float, start: Start, length: float) -> Float:
    """Returns the sizes, without those that make a wall of `length` m very long where the size is unknown.

    Tie points on hills far away lie on such walls, and it takes minutes to compare them.
    """
    return sizes if np.isfinite(start.sigma_size) else sizes[sizes * length <= _LONGEST_M]


def _may_meet(host: UprightWall, wall: UprightWall, start: Start) -> bool:
    turn = float(np.arccos(np.clip(host.inward @ wall.inward, -1.0, 1.0)))
    return turn < max(_TURN * start.sigma_turn, float(_LEAST_TURN))


def _composed(similarity: Similarity, turn: Float) -> Similarity:
    return replace(similarity, R=similarity.R @ turn)


def _log_prior(similarity: Similarity, start: Start, upright: Block) -> float:
    """Log likelihood of where the cameras of the upright block stand, as far as that is known.

    Where only the picture tells the size, there are many wrong places, most of which this excludes.
    """
    if not np.isfinite(start.sigma_shift):
        return 0.0
    centres = np.array([p.pose.t for p in upright.photos])
    expected = start.similarity.scale * centres + start.similarity.t
    off = float(np.linalg.norm(similarity.apply(centres).mean(0) - expected.mean(0)))
    if off > 4.0 * start.sigma_shift + 0.5:
        return -np.inf
    return -0.5 * (off / start.sigma_shift) ** 2


def _apart(a: Similarity, b: Similarity) -> bool:
    shifted, resized = np.linalg.norm(a.t - b.t), abs(np.log(a.scale / b.scale))
    return bool(shifted > 0.4 or resized > 0.05)
