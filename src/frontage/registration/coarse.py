"""Coarse search over heading and plan position by correlating walls with walls (4 degrees of freedom).

Both sides are upright pieces in plan: place, direction of the outward normal, weight. For every heading the
correlation ``c(t) = sum_i sum_j w_i w_j G(p_i + t - q_j) f(theta_i - theta_j)`` of all shifts t is one FFT:
``f(a) = 15 cos a + 6 cos 2a + cos 3a`` is 22 for walls that look the same way, -6 across, -10 for walls that
turn their backs; its harmonics are images whose correlations add in the frequency domain.
"""

from dataclasses import dataclass

import numpy as np
from scipy import fft, ndimage

from frontage.geometry.arrays import Array, Float
from frontage.registration.surfels import Surfels
from frontage.registration.walls import Walls

CELL = 0.5  # m of the images
BLUR = 1.2  # cells, one sigma: with the cells, half a metre of slack
TURN = np.radians(0.75)  # rad between headings: 0.4 m at 30 m
SPAN = 3.0  # sigmas of the prior that are searched
_PEAKS = 8
_APART = (1.5, np.radians(3.0))  # m and rad between peaks
_HARMONICS = {1: 15.0, 2: 6.0, 3: 1.0}
_TWO_FACED = {2: 15.0, 4: 6.0}  # where the side of a wall is unknown
_PRIOR = 0.01  # score that one squared sigma of the prior is worth: it decides between equals only


@dataclass(frozen=True, eq=False)
class Plan:
    """Upright pieces in plan: `xy` (n, 2) m, `theta` (n,) rad of the outward normal, `weight` (n,)."""

    xy: Float
    theta: Float
    weight: Float
    oriented: bool = True


@dataclass(frozen=True)
class Peak:
    """A candidate: turn by `turn` rad about the pivot, then shift by `shift` (2,) m; `score` 0..1."""

    turn: float
    shift: tuple[float, float]
    score: float


def plan_of_surfels(s: Surfels) -> Plan:
    """Upright pieces of a scan, gathered in half-metre cells: high walls count no more than 4 m of wall."""
    s = s.take(s.upright)
    theta = np.arctan2(s.normal[:, 1], s.normal[:, 0])
    bins = np.floor((theta + np.pi) / (2 * np.pi / 24)).astype(np.int64) % 24
    key = np.column_stack([np.floor(s.xyz[:, :2] / CELL).astype(np.int64), bins])
    _, number = np.unique(key, axis=0, return_inverse=True)
    number = number.ravel()
    area: Array = np.bincount(number, s.area)
    place = np.column_stack([np.bincount(number, s.area * s.xyz[:, a]) for a in (0, 1)]) / area[:, None]
    east, north = (np.bincount(number, s.area * s.normal[:, a]) for a in (0, 1))
    oriented = bool(s.oriented.mean() > 0.5) if len(s) else True
    return Plan(place, np.arctan2(north, east), np.minimum(area, 4.0 * CELL), oriented)


def plan_of_walls(walls: Walls) -> Plan:
    """Walls of a model as points every half cell along their exposed extent in plan."""
    xy, theta, weight = [np.zeros((0, 2))], [np.zeros(0)], [np.zeros(0)]
    for p in walls.of_kind("wall"):
        for part in getattr(p.polygon, "geoms", [p.polygon]):
            x0, _, x1, _ = part.bounds
            u = np.linspace(x0, x1, max(int(2 * (x1 - x0) / CELL), 1) + 1)
            xy.append((p.point + u[:, None] * p.along)[:, :2])
            theta.append(np.full(len(u), np.arctan2(p.normal[1], p.normal[0])))
            weight.append(np.full(len(u), 0.5))
    return Plan(np.concatenate(xy), np.concatenate(theta), np.concatenate(weight))


def search(
    source: Plan, target: Plan, pivot: Float, sigma: tuple[float, float], most: int = _PEAKS
) -> list[Peak]:
    """The best motions of `source` onto `target`, best first: turns about `pivot` (2,) and shifts.

    sigma  one sigma of the prior on the shift, m, and on the turn, rad: three of them are searched
    """
    if len(source.xy) == 0 or len(target.xy) == 0:
        return []
    window = max(SPAN * sigma[0], 2 * CELL)
    radius = float(np.sqrt(np.square(source.xy - pivot).sum(1).max()))
    half = int(np.ceil((radius + window) / CELL)) + int(4 * BLUR) + 1
    size = int(fft.next_fast_len(2 * half + 1))
    harmonics = _HARMONICS if source.oriented and target.oriented else _TWO_FACED
    images = _target_spectra(target, pivot, half, size, harmonics)
    reach = int(np.ceil(window / CELL))
    steps = int(np.ceil(min(SPAN * sigma[1], np.pi) / TURN))
    most_possible = sum(harmonics.values()) * source.weight.sum()
    found: list[Peak] = []
    for k in range(-steps, steps + 1):
        c = _correlation(source, pivot, k * TURN, half, size, images) / most_possible
        found += _maxima(c, reach, k * TURN, sigma)
    return _apart(sorted(found, key=lambda p: -p.score), most)


def _image(xy: Float, weight: Array, half: int, size: int) -> Array:
    """Sums of complex weights on the raster, origin at (half, half); points outside are left out."""
    ij = np.rint(xy / CELL).astype(np.int64) + half
    inside = ((ij >= 0) & (ij < 2 * half + 1)).all(1)
    flat = ij[inside, 1] * size + ij[inside, 0]
    w = weight[inside]
    real, imag = np.bincount(flat, w.real, size * size), np.bincount(flat, w.imag, size * size)
    return np.asarray((real + 1j * imag).reshape(size, size))


def _target_spectra(
    target: Plan, pivot: Float, half: int, size: int, harmonics: dict[int, float]
) -> dict[int, Array]:
    xy = target.xy - pivot
    # one wall is one wall however often it is drawn: the blurred mass of a straight wall is 1
    mass = np.abs(_image(xy, target.weight + 0j, half, size))
    top = float(np.percentile(ndimage.gaussian_filter(mass, BLUR)[mass > 0], 75)) if (mass > 0).any() else 1.0
    out = {}
    for k, gain in harmonics.items():
        image = _image(xy, target.weight * np.exp(-1j * k * target.theta), half, size)
        smooth = ndimage.gaussian_filter(image.real, BLUR) + 1j * ndimage.gaussian_filter(image.imag, BLUR)
        out[k] = gain * fft.fft2(smooth / np.maximum(np.abs(smooth), top))
    return out


def _correlation(
    source: Plan, pivot: Float, turn: float, half: int, size: int, images: dict[int, Array]
) -> Float:
    """Scores (size, size) of all shifts, wrapped: shift (dx, dy) cells at [dy, dx]."""
    c, s = np.cos(turn), np.sin(turn)
    xy = (source.xy - pivot) @ np.array([[c, s], [-s, c]])
    total = np.zeros((size, size), np.complex128)
    for k, spectrum in images.items():
        w = source.weight * np.exp(-1j * k * (source.theta + turn))
        total += np.conj(fft.fft2(_image(xy, w, half, size))) * spectrum
    return np.asarray(fft.ifft2(total).real, np.float64)


def _maxima(c: Float, reach: int, turn: float, sigma: tuple[float, float]) -> list[Peak]:
    """Local maxima within `reach` cells, less what the prior holds against them."""
    shifts = np.arange(-reach, reach + 1)
    part = c[np.ix_(shifts, shifts)]
    away = CELL**2 * (shifts[:, None] ** 2 + shifts[None, :] ** 2) / sigma[0] ** 2 + (turn / sigma[1]) ** 2
    part = np.where(away < 2 * SPAN**2, part - _PRIOR * 0.5 * away, -np.inf)
    top = (part == ndimage.maximum_filter(part, 5)) & np.isfinite(part)
    rows = np.argwhere(top)
    rows = rows[np.argsort(-part[top], kind="stable")[:_PEAKS]]
    return [
        Peak(turn, (CELL * float(shifts[j]), CELL * float(shifts[i])), float(part[i, j])) for i, j in rows
    ]


def _apart(peaks: list[Peak], most: int) -> list[Peak]:
    """The best peaks, none near a better one."""
    kept: list[Peak] = []
    for p in peaks:
        near = (
            np.hypot(p.shift[0] - q.shift[0], p.shift[1] - q.shift[1]) < _APART[0]
            and abs(p.turn - q.turn) < _APART[1]
            for q in kept
        )
        if not any(near):
            kept.append(p)
        if len(kept) == most:
            break
    return kept
