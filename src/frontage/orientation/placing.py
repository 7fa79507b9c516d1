"""Finds the place of a block in the scan: possible places, each improved by control, the best chosen."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.model import Estimate, Photo, Provenance
from frontage.orientation.control import ControlPoints, all_control
from frontage.orientation.drawnwall import Similarity
from frontage.orientation.nouns import Block
from frontage.orientation.place import COARSE_M, Start, possible_places
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import ImageOf
from frontage.orientation.similarity import FittedSimilarity, fit_similarity

_RADIUS = 12  # px, of the search for control
_COARSE, _FINE = 3.0, 1.5  # resolutions at which control is looked for, relative to the scan's own

_TRIED = 5  # possible places that are improved
_LEAST_GAIN = 12.0  # log likelihood over chance of a possible place
_FEWEST = 12  # control points that agree, for a block to be placed
_FIT_PX = 6.0  # largest robust spread of control, in px of the finest rendering, of a place that fits
_HOPELESS = 0.5  # coarse control of a place, relative to the best, below which it cannot become a rival
_RIVAL = 0.8  # agreeing control of another place, relative to the best, that makes a place ambiguous
_APART_M = 0.5
_PHOTOS = 8  # of a block that are enough to find its place


@dataclass(frozen=True, eq=False)
class BlockPlace:
    """Where a block lies in the scan.

    similarity  local_from_block
    agreeing    number of control points that agree with it
    rival       agreeing control of the next place, relative to it; 0 when there is none
    rival_off   m, how far that place is away
    """

    similarity: Similarity
    agreeing: int
    rival: float = 0.0
    rival_off: float = 0.0

    @property
    def ambiguous(self) -> bool:
        """Whether another place explains the photos about as well."""
        return self.rival > _RIVAL


def find_place(
    block: Block,
    surface: ScannedSurface,
    image_of: ImageOf,
    start: Start,
    seed: int = 0,
    pixel: float = COARSE_M,
) -> BlockPlace | None:
    """Returns the place of a block in the scan, or None when no place agrees with the photos.

    pixel  m, with which the walls of both are compared
    """
    places = possible_places(block, surface, image_of, start, seed, pixel)
    tried = [p for p in places if p.gain > _LEAST_GAIN][:_TRIED]
    chosen = _some(block)
    coarse = _improved(chosen, surface, image_of, [place.similarity for place in tried], _COARSE)
    least = _HOPELESS * max((f.count for f in coarse), default=0)
    likely = [f.similarity for f in coarse if f.count >= least]
    good = _improved(chosen, surface, image_of, likely, _FINE)
    if not good:
        return None
    centres = np.array([p.pose.t for p in block.photos])
    best = good[0]
    off = [_distance(best.similarity, f.similarity, centres) for f in good]
    others = [(f.count / best.count, d) for f, d in zip(good, off, strict=True) if d > _APART_M]
    rival, rival_off = max(others, default=(0.0, 0.0))
    return BlockPlace(best.similarity, best.count, rival, rival_off)


def placed_photos(block: Block, similarity: Similarity) -> list[Photo]:
    """Returns the photos of a block with approximate poses in the scan."""
    none = np.zeros((6, 6))
    return [
        replace(p, local_from_camera=Estimate(similarity.pose(p.pose), none, 0.0, Provenance.MEASURED))
        for p in block.photos
    ]


def _some(block: Block) -> Block:
    """The block with at most a few photos, spread over it."""
    n = len(block.photos)
    if n <= _PHOTOS:
        return block
    keep = np.unique(np.linspace(0, n - 1, _PHOTOS).round().astype(np.int64))
    photos = tuple(block.photos[k] for k in keep)
    empty = np.empty(0, np.int64)
    return Block(block.numbers[keep], photos, block.points, empty, empty, np.empty((0, 2)))


def _improved(
    block: Block,
    surface: ScannedSurface,
    image_of: ImageOf,
    places: Sequence[Similarity],
    coarser: float,
) -> list[FittedSimilarity]:
    """Improves places by control of one resolution; those that enough of it agrees with, the best first."""
    good = []
    for similarity in places:
        photos = placed_photos(block, similarity)
        control = all_control(photos, surface, image_of, coarser=coarser, radius=_RADIUS)
        if sum(len(c) for c in control) < _FEWEST:
            continue
        fitted = fit_similarity(block.photos, control, similarity)
        if _fits(fitted, control):
            good.append(fitted)
    return sorted(good, key=lambda f: -f.count)


def _fits(fitted: FittedSimilarity, control: Sequence[ControlPoints]) -> bool:
    """Whether enough control agrees, within a few px of the rendering that it was found in."""
    pixel = float(np.median([c.radius for c in control])) / _RADIUS
    return fitted.count >= _FEWEST and fitted.sigma < _FIT_PX / 2.0 * pixel


def _distance(a: Similarity, b: Similarity, centres: np.ndarray) -> float:
    return float(np.median(np.linalg.norm(a.apply(centres) - b.apply(centres), axis=1)))
