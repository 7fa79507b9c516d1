"""Control points: places of the scan found in a photo whose pose is roughly known."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int, freeze
from frontage.model import Photo
from frontage.orientation.gradients import Channels, oriented_gradients
from frontage.orientation.reflectance.gaps import without_small_gaps
from frontage.orientation.reflectance.render import Rendering, render, rendering_factor
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import ImageOf, geometry_tone, photo_tone
from frontage.orientation.result import MANY
from frontage.orientation.templates import HALF, Shifts, find_shifts
from frontage.solve.abreast import each

_STEP = 12  # px between templates: a quarter of a template
_MARGIN_PX = 4
_GRADIENT_PX = 1  # to either side, which a gradient is taken from
_TEMPLATES_ACROSS = 8.5  # the picture, at least: larger ones are precise, but not of one place
_DENSE, _SPARSE = 0.5, 0.9  # of the points in view: those dense enough for the finest, coarsest rendering
_MOST = 4000  # templates of a rendering; more of them would only overlap more
_TELLING = 0.8  # of the weight of all points in a square of the photo, which the most precise ones have
_ENOUGH = 5 * MANY // 4  # points of a photo, so that many are left when some fail their tests
_SQUARE = 2.0  # templates, the side of such a square
_COARSEST = 16.0  # px of the photo per pixel of a rendering


@dataclass(frozen=True, eq=False)
class ControlPoints:
    """Points of the scan seen in one photo.

    pixels  (n, 2) px in the photo
    xyz     (n, 3) m local
    sigma   (n,) px, standard error of `pixels` per axis
    score   (n,) correlation 0..1
    side    (n,) px in the photo, of the template
    moved   (n, 2) px, from where the approximate pose expects the point to where it was found
    unique  (n,) bool, whether nothing nearby looks alike, so that the point helps to recognise the place
    tried   number of places that were compared
    radius  px of the photo, largest shift that was looked for
    """

    pixels: Float
    xyz: Float
    sigma: Float
    score: Float
    side: Float
    moved: Float
    unique: Bool
    tried: int
    radius: float

    def __post_init__(self) -> None:
        n = len(self.pixels)
        freeze(self, pixels=((n, 2), np.float64), xyz=((n, 3), np.float64), sigma=((n,), np.float64))
        freeze(self, score=((n,), np.float64), side=((n,), np.float64), moved=((n, 2), np.float64))
        freeze(self, unique=((n,), np.bool_))

    def __len__(self) -> int:
        return len(self.pixels)

    def take(self, rows: Array) -> "ControlPoints":
        """Returns the points at `rows`, by number or mask."""
        return ControlPoints(
            self.pixels[rows],
            self.xyz[rows],
            self.sigma[rows],
            self.score[rows],
            self.side[rows],
            self.moved[rows],
            self.unique[rows],
            self.tried,
            self.radius,
        )

    def telling(self) -> "ControlPoints":
        """Returns the most precise points of every part of the photo; all where there are few.

        Templates overlap, so that the others, a third of all points, repeat what these tell, with larger
        residuals.
        """
        if len(self) <= _ENOUGH:
            return self
        square = np.floor(self.pixels / (_SQUARE * self.side[:, None])).astype(np.int64)
        number = np.unique(square, axis=0, return_inverse=True)[1].ravel()
        order = np.lexsort([self.sigma, number])
        number, weight = number[order], 1.0 / self.sigma[order] ** 2
        first = np.flatnonzero(np.diff(number, prepend=-1))
        before = np.cumsum(weight) - weight
        share = (before - before[first][number]) / np.bincount(number, weight)[number]
        kept = share < _TELLING
        kept[np.argsort(share, kind="stable")[:_ENOUGH]] = True
        return self.take(np.sort(order[kept]))


def find_control(
    photo: Photo,
    surface: ScannedSurface,
    image_of: ImageOf,
    *,
    coarser: float = 1.0,
    radius: int = 12,
    step: int = 2 * _STEP,
    largest: int = HALF,
    wider: int = 1,
    unique: bool = False,
) -> ControlPoints:
    """Finds the scan in a photo by templates of its rendering at the approximate pose.

    Where points lie farther apart the rendering must be coarser, or it has gaps. There are several, each
    twice as coarse as the one before, and a place is looked for in the next one if it was not found. If few
    are found in all, places are looked for in drawings between these sizes, too. If they are still few,
    points may lie less evenly than their spacing says, and to measure them coarser drawings are tried.
    `coarser` reduces them all; `radius` is the largest shift and `step` the least distance between templates,
    in px of the rendering. To recognise a place takes `unique` points; where the place is known, others
    measure it as well: along an edge the correlation is high everywhere, and across it the peak is sharp.
    Templates reach `largest` px of the rendering to every side where the picture is large enough, or `wider`
    times as far as that.
    """
    picture = image_of(photo.id)
    factors = _factors(photo, surface, coarser)
    across = min(photo.camera.width, photo.camera.height) / factors[0]
    half = wider * int(np.clip(0.5 * across / _TEMPLATES_ACROSS, HALF, largest))
    parts, found = list[ControlPoints](), None

    def search(factor: float) -> Bool:
        """Adds what is found at this size where nothing was found before, and returns where that is."""
        drawn = render(photo, surface, factor)
        tone, scale = photo_tone(picture, factor)
        left = None if found is None else ~_resized(found, drawn.known.shape)
        apart = max(step, round(float(np.sqrt(drawn.known.sum() / _MOST))))
        template, there = rendering_channels(drawn, surface), oriented_gradients(tone)
        shifts = find_shifts(template, there, radius, apart, left, half=half, unique=unique)
        parts.append(_control(drawn, shifts, scale, radius, half, apart))
        here = _around(shifts.at, drawn.known.shape, half)
        return here if found is None else here | _resized(found, here.shape)

    def few() -> bool:
        return sum(len(part) for part in parts) < MANY

    for factor in factors:
        found = search(factor)
    if few():
        for factor in np.sqrt(np.multiply(factors[:-1], factors[1:])).tolist():
            found = search(factor)
    factor = 2.0 * factors[-1]
    while not unique and few() and factor <= _COARSEST:
        found, factor = search(factor), 2.0 * factor
    return _joined(parts)


def _around(at: Int, shape: tuple[int, ...], half: int) -> Bool:
    """What of a picture (h, w) lies around places (n, 2), nearer than half of half a template."""
    mask = np.zeros(shape, np.uint8)
    mask[at[:, 1], at[:, 0]] = 1
    return np.asarray(cv2.dilate(mask, np.ones((half + 1, half + 1), np.uint8)) > 0)


def _factors(photo: Photo, surface: ScannedSurface, coarser: float) -> list[float]:
    """How many px of the photo the pixels of its renderings have, from the finest to the coarsest."""
    finest, coarsest = (coarser * rendering_factor(photo, surface, share) for share in (_DENSE, _SPARSE))
    count = 1 + max(0, round(np.log2(coarsest / finest)))
    return sorted({min(finest * 2.0**k, _COARSEST) for k in range(count)})


def _resized(mask: Bool, shape: tuple[int, ...]) -> Bool:
    h, w = shape
    return np.asarray(cv2.resize(mask.astype(np.uint8), (w, h), interpolation=cv2.INTER_NEAREST) > 0)


def _joined(parts: Sequence[ControlPoints]) -> ControlPoints:
    """The control points of several renderings of one photo."""
    fields = ("pixels", "xyz", "sigma", "score", "side", "moved", "unique")
    arrays: dict[str, Any] = {f: np.concatenate([getattr(part, f) for part in parts]) for f in fields}
    tried, radius = sum(part.tried for part in parts), max(part.radius for part in parts)
    return ControlPoints(**arrays, tried=tried, radius=radius)


def rendering_channels(drawn: Rendering, surface: ScannedSurface) -> Channels:
    """Returns the oriented gradients of a rendering: of its tones, or of its shape where it has none.

    A margin along the edge of what the scan shows is left out. The photo has strong edges there, at the sky
    and at glass, which the rendering does not have; templates would be pushed away from them. Small gaps in
    a flat surface are no edges and have no margin.
    """
    if surface.tone is None:
        return oriented_gradients(*geometry_tone(drawn.depth, drawn.known))
    channels = oriented_gradients(drawn.tone, drawn.known)
    thickness = float(np.median(surface.pieces.thickness)) if len(surface.pieces) else 0.0
    measured = without_small_gaps(drawn, thickness).astype(np.uint8)
    side = 2 * (_MARGIN_PX + _GRADIENT_PX) + 1
    inner = cv2.erode(measured, np.ones((side, side), np.uint8), borderValue=0) > 0
    inner &= channels.known
    return Channels(channels.values * inner, inner)


def _control(
    drawn: Rendering, shifts: Shifts, scale: Float, radius: int, half: int, apart: int
) -> ControlPoints:
    side = 2.0 * half + 1.0
    overlap = max(1.0, side / apart)  # neighbours share pixels: their errors are not independent
    column, row = shifts.at.T
    solid = drawn.known[row, column] & (drawn.depth[row, column] > 0)
    at, shift = shifts.at[solid], shifts.shift[solid]
    xyz = drawn.points(at)
    pixels = (at + 0.5 + shift) * scale
    sigma = np.sqrt((shifts.sigma[solid] ** 2).mean(1)) * scale.mean() * overlap
    finite = np.isfinite(xyz).all(1)
    return ControlPoints(
        pixels[finite],
        xyz[finite],
        sigma[finite],
        shifts.score[solid][finite],
        np.full(int(finite.sum()), side * scale.mean()),
        (shift * scale)[finite],
        shifts.unique[solid][finite],
        shifts.tried,
        float(radius * scale.mean()),
    )


def all_control(
    photos: Sequence[Photo], surface: ScannedSurface, image_of: ImageOf, *, coarser: float, radius: int
) -> list[ControlPoints]:
    """Returns the unique control points of several photos, whose places are not yet known."""

    def one(photo: Photo) -> ControlPoints:
        return find_control(photo, surface, image_of, coarser=coarser, radius=radius, unique=True)

    return list(each(one, photos))
