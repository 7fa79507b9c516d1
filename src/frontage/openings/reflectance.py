"""How the wall's points look: intensity freed of range and incidence, colour; and how much that varies."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float
from frontage.model.facade import Facade
from frontage.model.scan import Scan
from frontage.openings.beams import Beams, Raster
from frontage.openings.borders import Place

_STRIP = 0.12  # m, width of the strips on either side of a border
_CLEAR = 0.03  # m on either side of a border that strips leave out: cells that it cuts, mortar, seals
_FULL = 0.4  # share of a strip's cells that must hold points: walls are sparse above
_AWAY = 0.25  # m around openings that tell nothing of the wall by itself: surrounds
_PLACES = 50  # places on the wall that its own steps must be known from
_STATIONS = 12  # with more origins the sensor moved, and all points are one group
_ROUNDS = 4  # of the robust fit
_SOME = 20000  # points that a fit needs at most
_DARK = 4.0  # of 255: below, colours are noise
_FAINT = 0.01  # quantile of the intensities: what is fainter is as faint as that


@dataclass(frozen=True, eq=False)
class Channels:
    """Points xz (n, 2) m near the wall, their y `depth` (n,) m, and logarithms of what was seen of each (n,).

    maps (c, h, w) are the means of the cells of `raster`, NaN where there is no point; `spacing` m.
    """

    xz: Float
    depth: Float
    values: tuple[Float, ...]
    maps: Float
    raster: Raster
    spacing: float

    def within(self, place: Place) -> Bool:
        """Which points lie in a box (n,)."""
        x, z = self.xz.T
        return np.asarray((x > place[0]) & (x < place[2]) & (z > place[1]) & (z < place[3]))

    def steps(self, place: Place) -> Float:
        """Steps inwards on the four sides of a box, left, bottom, right, top, (c, 4); NaN = not known."""
        g, (cx, cz) = self.raster.cell, self.raster.corner
        c0, r0, c1, r1 = (round((v - o) / g) for v, o in zip(place, (cx, cz, cx, cz), strict=True))
        width, gap = self._strip()
        reach = width + gap + 1
        top, left = max(r0 - reach, 0), max(c0 - reach, 0)
        part = self.maps[:, top : r1 + reach, left : c1 + reach]
        r0, r1, c0, c1 = r0 - top, r1 - top, c0 - left, c1 - left
        found = np.full((len(part), 4), np.nan)
        for k, values in enumerate(part):
            across, up = _jumps(values, r1 - r0, width, gap), _jumps(values.T, c1 - c0, width, gap)
            found[k, :2] = _at(across, r0, c0), _at(up, c0, r0)
            found[k, 2:] = -_at(across, r0, c1), -_at(up, c0, r1)
        return found

    def spread(self, length: float, taken: Sequence[Place]) -> Float:
        """One sigma of the steps that the wall shows by itself along `length` m, (c,), off the boxes `taken`.

        The same strips are moved over all of the wall that holds points: their scatter is what courses,
        stains and noise do to means of that size, however few of their points are independent.
        """
        free, cells = self._free(taken), int(length / self.raster.cell)
        found = []
        for values in self.maps:
            bare = np.where(free, values, np.nan)
            steps = [_jumps(m, cells, *self._strip()) for m in (bare, bare.T)]
            found.append(_spread(np.concatenate([n[np.isfinite(n)] for n in steps])))
        return np.array(found)

    def _strip(self) -> tuple[int, int]:
        """Cells that a strip is wide, and that it stays off the border."""
        return max(round(_STRIP / self.raster.cell), 2), int(np.ceil(_CLEAR / self.raster.cell))

    def _free(self, taken: Sequence[Place]) -> Bool:
        """Cells (h, w) well off all boxes."""
        g, (cx, cz) = self.raster.cell, self.raster.corner
        free = np.ones(self.raster.shape, np.bool_)
        for x0, z0, x1, z1 in taken:
            rows = slice(max(int((z0 - _AWAY - cz) / g), 0), max(int((z1 + _AWAY - cz) / g) + 1, 0))
            columns = slice(max(int((x0 - _AWAY - cx) / g), 0), max(int((x1 + _AWAY - cx) / g) + 1, 0))
            free[rows, columns] = False
        return free


def reflectances(facade: Facade, scan: Scan, beams: Beams, raster: Raster, reach: float) -> Channels:
    """The channels that the scan has, of the points within `reach` m of the wall."""
    index = facade.support
    xyz = facade.frame.inverse.apply(scan.xyz[index])
    near = np.abs(xyz[:, 1] - beams.depth_at(xyz[:, 0], xyz[:, 2])) < max(reach, beams.least)
    index, xyz = index[near], xyz[near]
    values: list[Float] = []
    if scan.intensity is not None:
        values.append(_flattened(scan.intensity[index], index, scan, facade))
    if scan.rgb is not None:
        red, green, blue = np.log(scan.rgb[index].astype(np.float64) + _DARK).T
        values += [(red + green + blue) / 3.0, red - green, blue - green]
    at = raster.flat(xyz[:, 0], xyz[:, 2])
    size = raster.shape[0] * raster.shape[1]
    on = at >= 0
    number = np.bincount(at[on], minlength=size)
    with np.errstate(invalid="ignore"):
        maps = [np.bincount(at[on], v[on], minlength=size) / number for v in values]
    shaped = np.stack(maps).reshape(len(maps), *raster.shape)
    return Channels(xyz[:, [0, 2]], xyz[:, 1], tuple(values), shaped, raster, facade.spacing)


def _flattened(intensity: Array, index: Array, scan: Scan, facade: Facade) -> Float:
    """Logarithm of the intensity (n,) less what range and incidence explain of it, station by station.

    A robust line in the logarithms of range and of the cosine of incidence (Hoefle & Pfeifer 2007), whose
    exponents the wall tells itself: instruments compress and correct in ways of their own.
    """
    raw = intensity.astype(np.float64)
    some = raw[raw > 0.0]
    v = np.log(np.maximum(raw, np.quantile(some, _FAINT) if len(some) else 1.0))
    origin = scan.origin_index[index]
    stations = np.unique(origin[origin >= 0])
    groups = [origin == s for s in stations] if len(stations) <= _STATIONS else [origin >= 0]
    out = v - np.median(v) if len(v) else v
    for group in groups:
        if group.sum() < _PLACES:
            continue
        ray = facade.frame.inverse.apply(scan.xyz[index[group]])
        ray = ray - facade.frame.inverse.apply(scan.sensor_of(index[group]))
        range_ = np.maximum(np.linalg.norm(ray, axis=1), 1e-3)
        cosine = np.maximum(np.abs(ray[:, 1]) / range_, 1e-3)
        model = np.column_stack([np.ones(len(ray)), np.log(range_), np.log(cosine)])
        out[group] = v[group] - model @ _robust_line(model, v[group])
    return out


def _robust_line(model: Float, v: Float) -> Float:
    """Coefficients (k,) of v (n,) by the columns of model (n, k), outliers (windows, fittings) bounded."""
    step = max(len(v) // _SOME, 1)
    a, b = model[::step], v[::step]
    weight: Float = np.ones(len(b))
    x: Float = np.zeros(a.shape[1])
    for _ in range(_ROUNDS):
        x = np.asarray(np.linalg.lstsq(a * weight[:, None], b * weight, rcond=None)[0], np.float64)
        rest = np.abs(b - a @ x)
        weight = np.asarray(np.maximum(rest / max(1.5 * float(np.median(rest)), 1e-9), 1.0) ** -0.5)
    return x


def _jumps(values: Float, length: int, width: int, gap: int) -> Float:
    """Mean of the strip right of a border less that left of it, [r, c]: border before column c, rows
    r..r+length, `gap` cells left out beside it; NaN where a strip is not full or runs off the map (h, w).
    """
    h, w = values.shape
    out = np.full((h + 1, w + 1), np.nan)
    if length < 1 or length > h or w < 2 * (width + gap):
        return out
    known = np.isfinite(values)
    sums = [_boxes(m, length, width) for m in (np.where(known, values, 0.0), known.astype(np.float64))]
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(sums[1] >= _FULL * length * width, sums[0] / sums[1], np.nan)
    first = width + gap
    apart = width + 2 * gap
    out[: h - length + 1, first : w - first + 1] = mean[:, apart:] - mean[:, :-apart]
    return out


def _boxes(values: Float, length: int, width: int) -> Float:
    """Sums over all windows of length x width cells (h - length + 1, w - width + 1)."""
    s = np.pad(values.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    return np.asarray(s[length:, width:] - s[:-length, width:] - s[length:, :-width] + s[:-length, :-width])


def _at(jumps: Float, r: int, c: int) -> float:
    inside = 0 <= r < jumps.shape[0] and 0 <= c < jumps.shape[1]
    return float(jumps[r, c]) if inside else np.nan


def _spread(steps: Float) -> float:
    """One sigma of steps (n,): of their middle or of their tails, whichever is wider; NaN for few."""
    if len(steps) < _PLACES:
        return np.nan
    size = np.abs(steps)
    return float(max(1.4826 * np.median(size), np.quantile(size, 0.95) / 1.96))
