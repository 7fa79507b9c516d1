"""Dense template matching between a rendering of the scan and a photo, with honest standard errors.

Templates lie on a regular grid of the rendering. Each is compared with the photo by the normalised
correlation of oriented gradients, over shifts up to the search radius. A peak counts only if it stands out
from the correlation with other places of the photo, which tell what chance achieves. Its standard error
follows from the sharpness of the peak and from the share of the pattern that does not agree
(Foerstner 1982, for least squares matching): ``var = (1 - r^2) / (r n (-r''))`` with n independent samples.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from frontage.geometry.arrays import Array, Bool, Float, Int, freeze
from frontage.orientation.gradients import Channels

HALF = 24  # px of the rendering: a template has 49 x 49
_STEP = 16  # px between templates
_LEAST_KNOWN = 0.5  # share of a template that must be known, of a large one as much as a whole small one has
_STANDS_OUT = 4.5  # standard deviations above the mean of what chance achieves
_ELSEWHERE, _FEWEST_ELSEWHERE = 200, 20  # places of the photo that tell what chance achieves
_AT_ONCE = 512  # templates whose pixels are held in memory
_OVERLAPPING = 30.0  # templates over every pixel, from which sums over the whole picture take less time
_CORRELATED_PX2 = 6.0  # area that one independent sample represents, after the joining blur


@dataclass(frozen=True, eq=False)
class Shifts:
    """Where templates of the rendering were found in the photo.

    at     (n, 2) int64 px, centre of the template: column and row in the rendering
    shift  (n, 2) px of the rendering, from there to the place in the photo
    sigma  (n, 2) px, standard error of the shift
    score  (n,) correlation at the peak, -1..1
    unique (n,) bool, whether the peak also stands out from its own surroundings
    tried  number of templates that were compared
    """

    at: Int
    shift: Float
    sigma: Float
    score: Float
    unique: Bool
    tried: int

    def __post_init__(self) -> None:
        n = len(self.at)
        freeze(
            self,
            at=((n, 2), np.int64),
            shift=((n, 2), np.float64),
            sigma=((n, 2), np.float64),
            score=((n,), np.float64),
            unique=((n,), np.bool_),
        )

    def __len__(self) -> int:
        return len(self.at)


def known_share(known: Bool, half: int = HALF) -> Array:
    """Returns which share of a template around every pixel (h, w) is known; what is outside is not."""
    side = 2 * half + 1
    share: Array = cv2.boxFilter(known.astype(np.float32), -1, (side, side), borderType=cv2.BORDER_CONSTANT)
    return share


def least_known(half: int = HALF) -> float:
    """Returns which share of a template must be known: half of it, or as much as a whole small one has.

    Where the scan has many gaps, large templates see enough of it between them.
    """
    return min(_LEAST_KNOWN, ((2 * HALF + 1) / (2 * half + 1)) ** 2)


def correlation_surfaces(
    template: Channels,
    photo: Channels,
    radius: int,
    step: int = _STEP,
    half: int = HALF,
    wanted: Bool | None = None,
) -> tuple[Int, Array]:
    """Correlates templates on a grid with the photo within `radius` px.

    `wanted` (h, w) tells where a template is of use; everywhere where its surface is known if None.

    Returns their centres (n, 2) column and row, and the surfaces (n, 2 r + 1, 2 r + 1) float32. Templates
    whose search window leaves the picture are left out.
    """
    h, w = template.shape
    reach = half + radius
    rows, columns = np.arange(reach, h - reach, step), np.arange(reach, w - reach, step)
    grid = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    useful = known_share(template.known, half) > least_known(half)
    useful &= True if wanted is None else wanted
    grid = grid[useful[grid[:, 1], grid[:, 0]]].astype(np.int64)
    power = (photo.values**2).sum(0)
    if len(grid) * (2 * half + 1) ** 2 > _OVERLAPPING * h * w:
        return grid, _surfaces_by_shift(template, photo, power, grid, half, radius)
    surfaces = [_surface(template, photo, power, c, r, half, radius) for c, r in grid]
    shape = (0, 2 * radius + 1, 2 * radius + 1)
    return grid, np.stack(surfaces) if surfaces else np.empty(shape, np.float32)


def find_shifts(
    template: Channels,
    photo: Channels,
    radius: int,
    step: int = _STEP,
    wanted: Bool | None = None,
    *,
    half: int = HALF,
    unique: bool = False,
) -> Shifts:
    """Finds the templates of a rendering in the photo, within `radius` px of where it expects them.

    `wanted` (h, w) tells where they are looked for; everywhere if None. Templates reach `half` px to every
    side. `unique` peaks stand out from all that is nearby; otherwise it is enough that a peak is higher than
    chance.
    """
    at, surfaces = correlation_surfaces(template, photo, radius, step, half, wanted)
    if not len(at):
        none = np.empty((0, 2))
        return Shifts(at, none, none, np.empty(0), np.empty(0, np.bool_), 0)
    peak = surfaces.reshape(len(at), -1).argmax(1)
    row, column = np.divmod(peak, 2 * radius + 1)
    inside = (row > 0) & (row < 2 * radius) & (column > 0) & (column < 2 * radius)
    top = surfaces[np.arange(len(at)), row, column]
    alone = _unique(surfaces, top)
    real = alone if unique else alone | _beyond_chance(top, template, photo, at, half)
    good = np.flatnonzero(inside & real & (top > 0))
    shift, sigma, score = _fitted(surfaces[good], row[good], column[good])
    samples = _samples(template, at[good], half)
    sigma = sigma / np.sqrt(samples / _CORRELATED_PX2)[:, None]
    usable = np.isfinite(shift).all(1) & np.isfinite(sigma).all(1) & (np.abs(shift) <= radius).all(1)
    return Shifts(
        at[good][usable],
        shift[usable],
        sigma[usable],
        score[usable],
        alone[good][usable],
        len(at),
    )


def _surface(
    template: Channels, photo: Channels, power: Array, c: int, r: int, half: int, radius: int
) -> Array:
    inner = (slice(r - half, r + half + 1), slice(c - half, c + half + 1))
    reach = half + radius
    outer = (slice(r - reach, r + reach + 1), slice(c - reach, c + reach + 1))
    mask = template.known[inner].astype(np.float32)
    patch = template.values[:, *inner]
    product = sum(
        cv2.matchTemplate(there[outer], here, cv2.TM_CCORR)
        for there, here in zip(photo.values, patch, strict=True)
    )
    energy = cv2.matchTemplate(power[outer], mask, cv2.TM_CCORR) * float((patch**2).sum())
    surface: Array = np.asarray(product) / np.sqrt(np.maximum(energy, 1e-9))
    return surface


def _surfaces_by_shift(
    template: Channels, photo: Channels, power: Array, grid: Int, half: int, radius: int
) -> Array:
    """The surfaces of all templates at once, shift by shift: sums over windows of one product of pictures."""
    h, w = template.shape
    side, size = 2 * half + 1, 2 * radius + 1
    inner = (slice(radius, h - radius), slice(radius, w - radius))
    column, row = (grid - radius).T
    values, mask = template.values[:, *inner], template.known[inner].astype(np.float32)

    def total(layer: Array) -> Array:
        window = cv2.boxFilter(layer, -1, (side, side), normalize=False, borderType=cv2.BORDER_CONSTANT)
        return np.asarray(window[row, column])

    patch = total((values**2).sum(0))
    surfaces = np.empty((len(grid), size, size), np.float32)
    for down, right in np.ndindex(size, size):
        there = (slice(down, down + h - 2 * radius), slice(right, right + w - 2 * radius))
        product = np.einsum("khw,khw->hw", values, photo.values[:, *there])
        energy = total(mask * power[there]) * patch
        surfaces[:, down, right] = total(product) / np.sqrt(np.maximum(energy, 1e-9))
    return surfaces


def _beyond_chance(top: Array, template: Channels, photo: Channels, at: Int, half: int) -> Array:
    """Whether peaks (n,) are higher than what templates at (n, 2) reach by chance, elsewhere in the photo.

    The surroundings of a peak do not tell that: along an edge the correlation is high everywhere.
    """
    elsewhere = _elsewhere(photo.shape, half)
    every = 1 if half <= 2 * HALF else 2  # of the pixels of large templates, which are alike in pairs
    values = _patches(photo.values, elsewhere, half, every)
    power = _patches((photo.values**2).sum(0)[None], elsewhere, half, every)
    stands = np.zeros(len(at), np.bool_)
    for first in range(0, len(at), _AT_ONCE):
        rows = slice(first, first + _AT_ONCE)
        patches = _patches(template.values, at[rows], half, every)
        masks = _patches(template.known[None], at[rows], half, every)
        energy = (masks.astype(np.float32) @ power.T) * (patches**2).sum(1)[:, None]
        chance = (patches @ values.T) / np.sqrt(np.maximum(energy, 1e-9))
        other = np.abs(at[rows, None] - elsewhere).max(-1) > half
        count = np.maximum(other.sum(1), 1)
        mean = (chance * other).sum(1) / count
        spread = np.sqrt(((chance - mean[:, None]) ** 2 * other).sum(1) / count)
        stands[rows] = (top[rows] - mean > _STANDS_OUT * spread) & (other.sum(1) >= _FEWEST_ELSEWHERE)
    return stands


def _unique(surfaces: Array, top: Array) -> Array:
    """Whether peaks (n,) stand out from the other values of their surfaces by robust standard deviations."""
    flat = surfaces.reshape(len(surfaces), -1)
    middle = np.median(flat, axis=1)
    spread = 1.4826 * np.median(np.abs(flat - middle[:, None]), axis=1)
    return np.asarray(top - middle > _STANDS_OUT * np.maximum(spread, 1e-6))


def _elsewhere(shape: tuple[int, int], half: int) -> Int:
    """Places (k, 2), column and row, all over a picture, where a whole template fits."""
    h, w = shape
    rng = np.random.default_rng(0)
    return np.column_stack([rng.integers(half, side - half, _ELSEWHERE) for side in (w, h)])


def _patches(layers: Array, at: Int, half: int, every: int = 1) -> Array:
    """The templates' pixels (n, k * p) of layers (k, h, w) around places (n, 2), `every` so many of a row."""
    side = 2 * half + 1
    windows = sliding_window_view(layers, (side, side), axis=(1, 2))[..., ::every, ::every]
    picked: Array = windows[:, at[:, 1] - half, at[:, 0] - half].swapaxes(0, 1).reshape(len(at), -1)
    return picked


def _fitted(surfaces: Array, row: Int, column: Int) -> tuple[Float, Float, Float]:
    """Peak positions relative to the middle (n, 2), sigmas for one sample (n, 2), and peak heights (n,).

    A paraboloid is fitted to the 3 x 3 values around the peak. Its twist matters: along an edge that is not
    parallel to an axis the position is open, although both sections through the peak are sharp.
    """
    n = np.arange(len(row))[:, None, None]
    steps = np.arange(-1, 2)
    around = surfaces[n, row[:, None, None] + steps[:, None], column[:, None, None] + steps].astype(
        np.float64
    )
    top = around[:, 1, 1]
    slope = 0.5 * np.column_stack([around[:, 1, 2] - around[:, 1, 0], around[:, 2, 1] - around[:, 0, 1]])
    across = 2 * top - around[:, 1, 2] - around[:, 1, 0]
    down = 2 * top - around[:, 2, 1] - around[:, 0, 1]
    twist = 0.25 * (around[:, 0, 2] + around[:, 2, 0] - around[:, 0, 0] - around[:, 2, 2])
    with np.errstate(divide="ignore", invalid="ignore"):
        determinant = across * down - twist**2
        determinant = np.where((determinant > 1e-18) & (across > 1e-9), determinant, np.nan)
        inverse = np.stack([down, -twist, -twist, across], -1).reshape(-1, 2, 2) / determinant[:, None, None]
        shift = np.column_stack([column, row]) - surfaces.shape[1] // 2 + (inverse @ slope[..., None])[..., 0]
        height = np.clip(top, 1e-3, 1 - 1e-6)[:, None]
        sigma = np.sqrt((1 - height**2) / height * np.diagonal(inverse, axis1=1, axis2=2))
    return shift, sigma, top


def _samples(template: Channels, at: Int, half: int) -> Float:
    """The number of known pixels (n,) of the templates."""
    count = known_share(template.known, half) * (2 * half + 1) ** 2
    return np.asarray(np.maximum(count[at[:, 1], at[:, 0]], 1.0), np.float64)
