"""Coarse search over heading and plan position by correlating walls with walls (4 degrees of freedom).

Both sides are upright surfaces in plan: place, direction of the outward normal, weight. For every heading,
one FFT gives the correlation ``c(t) = sum_i sum_j w_i w_j G(p_i + t - q_j) f(theta_i - theta_j)`` of all
shifts t. ``f(a) = 15 cos a + 6 cos 2a + cos 3a`` is 22 for walls that face the same way, -6 across, and -10
for walls that face opposite ways. Its harmonics are images whose correlations add in the frequency domain.
"""

from dataclasses import dataclass

import numpy as np
from scipy import fft, ndimage

from frontage.geometry.arrays import Array, Float
from frontage.registration.walls import ModelWalls
from frontage.solve.surfels import Surfels

CELL_M = 0.5  # m of the images
_BLUR_CELLS = 1.2  # cells, one sigma; with the cells, half a metre of slack
_TURN_RAD = np.radians(0.75)  # rad between headings: 0.4 m at 30 m
SPAN_SIGMAS = 3.0  # sigmas of the prior that are searched
_PEAKS = 8  # peaks that are returned
_APART = (1.5, np.radians(3.0))  # m and rad between peaks
_HARMONICS = {1: 15.0, 2: 6.0, 3: 1.0}  # gain of each harmonic of f
_TWO_FACED = {2: 15.0, 4: 6.0}  # the same where the side of a wall is unknown
_PRIOR = 0.01  # score that one squared sigma of the prior is worth; it decides only between equals


@dataclass(frozen=True, eq=False)
class Plan:
    """Upright surfaces in plan.

    xy      (n, 2) m local; `theta` (n,) rad, direction of the outward normal; `weight` (n,)
    oriented  whether the side of the walls is known
    """

    xy: Float
    theta: Float
    weight: Float
    oriented: bool = True


@dataclass(frozen=True)
class Peak:
    """A candidate: a turn of `turn` rad about the pivot, then a shift (2,) m; `score` 0..1."""

    turn: float
    shift: tuple[float, float]
    score: float


def plan_of_surfels(s: Surfels) -> Plan:
    """Gathers the upright surfels of a scan in half-metre cells; high walls count as 4 m of wall."""
    s = s.take(s.upright)
    theta = np.arctan2(s.normal[:, 1], s.normal[:, 0])
    bins = np.floor((theta + np.pi) / (2 * np.pi / 24)).astype(np.int64) % 24
    key = np.column_stack([np.floor(s.xyz[:, :2] / CELL_M).astype(np.int64), bins])
    _, number = np.unique(key, axis=0, return_inverse=True)
    number = number.ravel()
    area: Array = np.bincount(number, s.area)
    place = np.column_stack([np.bincount(number, s.area * s.xyz[:, a]) for a in (0, 1)]) / area[:, None]
    east, north = (np.bincount(number, s.area * s.normal[:, a]) for a in (0, 1))
    oriented = bool(s.oriented.mean() > 0.5) if len(s) else True
    return Plan(place, np.arctan2(north, east), np.minimum(area, 4.0 * CELL_M), oriented)


def plan_of_walls(walls: ModelWalls) -> Plan:
    """Samples the walls of a model every half cell along their exposed extent in plan."""
    xy, theta, weight = [np.zeros((0, 2))], [np.zeros(0)], [np.zeros(0)]
    for p in walls.of_kind("wall"):
        for part in getattr(p.polygon, "geoms", [p.polygon]):
            x0, _, x1, _ = part.bounds
            u = np.linspace(x0, x1, max(int(2 * (x1 - x0) / CELL_M), 1) + 1)
            xy.append((p.point + u[:, None] * p.along)[:, :2])
            theta.append(np.full(len(u), np.arctan2(p.normal[1], p.normal[0])))
            weight.append(np.full(len(u), 0.5))
    return Plan(np.concatenate(xy), np.concatenate(theta), np.concatenate(weight))


def search_motions(
    source: Plan, target: Plan, pivot: Float, sigma: tuple[float, float], most: int = _PEAKS
) -> list[Peak]:
    """Finds the best motions of `source` onto `target`, best first: turns about `pivot` (2,) m, and shifts.

    sigma  one sigma of the prior on the shift (m) and on the turn (rad); three of them are searched
    most   number of candidates
    """
    if len(source.xy) == 0 or len(target.xy) == 0:
        return []
    window = max(SPAN_SIGMAS * sigma[0], 2 * CELL_M)
    radius = float(np.sqrt(np.square(source.xy - pivot).sum(1).max()))
    half = int(np.ceil((radius + window) / CELL_M)) + int(4 * _BLUR_CELLS) + 1
    size = int(fft.next_fast_len(2 * half + 1))
    harmonics = _HARMONICS if source.oriented and target.oriented else _TWO_FACED
    raster = _Raster(pivot, half, size)
    spectra = _target_spectra(target, raster, harmonics)
    reach = int(np.ceil(window / CELL_M))
    steps = int(np.ceil(min(SPAN_SIGMAS * sigma[1], np.pi) / _TURN_RAD))
    most_possible = sum(harmonics.values()) * source.weight.sum()
    found: list[Peak] = []
    for k in range(-steps, steps + 1):
        c = _correlation(source, k * _TURN_RAD, raster, spectra) / most_possible
        found += _maxima(c, reach, k * _TURN_RAD, sigma)
    return _apart(sorted(found, key=lambda p: -p.score), most)


@dataclass(frozen=True, eq=False)
class _Raster:
    """The raster of the correlation: `size` cells to a side, with the pivot (2,) m at (half, half)."""

    pivot: Float
    half: int
    size: int

    def image(self, xy: Float, weight: Array) -> Array:
        """Sums complex weights (n,) of points (n, 2) m from the pivot; points outside are left out."""
        ij = np.rint(xy / CELL_M).astype(np.int64) + self.half
        inside = ((ij >= 0) & (ij < 2 * self.half + 1)).all(1)
        flat = ij[inside, 1] * self.size + ij[inside, 0]
        w = weight[inside]
        cells = self.size * self.size
        real, imag = np.bincount(flat, w.real, cells), np.bincount(flat, w.imag, cells)
        return np.asarray((real + 1j * imag).reshape(self.size, self.size))


def _target_spectra(target: Plan, raster: _Raster, harmonics: dict[int, float]) -> dict[int, Array]:
    """Returns the spectrum of the target's image for every harmonic."""
    xy = target.xy - raster.pivot
    # a wall counts once, however often it is drawn: the blurred mass of a straight wall is 1
    mass = np.abs(raster.image(xy, target.weight + 0j))
    blurred = ndimage.gaussian_filter(mass, _BLUR_CELLS)[mass > 0]
    top = float(np.percentile(blurred, 75)) if len(blurred) else 1.0
    out = {}
    for k, gain in harmonics.items():
        image = raster.image(xy, target.weight * np.exp(-1j * k * target.theta))
        real, imag = (ndimage.gaussian_filter(part, _BLUR_CELLS) for part in (image.real, image.imag))
        smooth = real + 1j * imag
        out[k] = gain * fft.fft2(smooth / np.maximum(np.abs(smooth), top))
    return out


def _correlation(source: Plan, turn: float, raster: _Raster, spectra: dict[int, Array]) -> Float:
    """Returns the scores (size, size) of all shifts, wrapped: the shift (dx, dy) cells is at [dy, dx]."""
    c, s = np.cos(turn), np.sin(turn)
    xy = (source.xy - raster.pivot) @ np.array([[c, s], [-s, c]])
    total = np.zeros((raster.size, raster.size), np.complex128)
    for k, spectrum in spectra.items():
        w = source.weight * np.exp(-1j * k * (source.theta + turn))
        total += np.conj(fft.fft2(raster.image(xy, w))) * spectrum
    return np.asarray(fft.ifft2(total).real, np.float64)


def _maxima(c: Float, reach: int, turn: float, sigma: tuple[float, float]) -> list[Peak]:
    """Returns the local maxima within `reach` cells, after subtracting what the prior holds against them."""
    shifts = np.arange(-reach, reach + 1)
    part = c[np.ix_(shifts, shifts)]
    away = CELL_M**2 * (shifts[:, None] ** 2 + shifts[None, :] ** 2) / sigma[0] ** 2 + (turn / sigma[1]) ** 2
    part = np.where(away < 2 * SPAN_SIGMAS**2, part - _PRIOR * 0.5 * away, -np.inf)
    top = (part == ndimage.maximum_filter(part, 5)) & np.isfinite(part)
    rows = np.argwhere(top)
    rows = rows[np.argsort(-part[top], kind="stable")[:_PEAKS]]
    return [
        Peak(turn, (CELL_M * float(shifts[j]), CELL_M * float(shifts[i])), float(part[i, j])) for i, j in rows
    ]


def _apart(peaks: list[Peak], most: int) -> list[Peak]:
    """Returns the best peaks, none of them near a better one."""
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
