"""How the wall looks, channel by channel: intensity freed of range and incidence, colour, relief, photos."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float
from frontage.model.facade import Facade
from frontage.model.ortho import OrthoImage
from frontage.model.scan import Scan
from frontage.openings.beams import Beams, Raster
from frontage.openings.borders import Place
from frontage.openings.steps import Picture

_FINEST = 0.04  # m, least side of a cell: borders are known that well before they are measured
_PER_CELL = 2.0  # spacings a cell is wide
_RELIEF = 0.04  # m that count as one step of brightness does (factor e)
_STATIONS = 12  # with more origins the sensor moved, and all points are one group
_PLACES = 50  # points that a station's fit needs
_ROUNDS = 4  # of the robust fit
_SOME = 20000  # points that a fit needs at most
_DARK = 4.0  # of 255: below, colours are noise
_FAINT = 0.01  # quantile of the intensities: what is fainter is as faint as that
_STRIP = 512  # rows of an ortho-image at a time


@dataclass(frozen=True, eq=False)
class Channel:
    """One property of the wall that may step at the borders of what closes an opening.

    picture  means of cells; near: places xz (n, 2) m and values (n,) of what lies in a box
    spacing  m between these; sharp: m that a sharp step is wide, and its place off
    """

    picture: Picture
    near: Callable[[Place], tuple[Float, Float]]
    spacing: float
    sharp: float


@dataclass(frozen=True, eq=False)
class Surface:
    """The scan's points on the wall, or nearly: places xz (n, 2), depth y (n,) m, rows of the scan."""

    xz: Float
    depth: Float
    index: Array

    def within(self, place: Place) -> Bool:
        """Which points lie in a box (n,)."""
        return within(self.xz, place)


def within(xz: Float, place: Place) -> Bool:
    """Which of the places (n, 2) lie in a box (n,)."""
    x, z = xz.T
    return np.asarray((x > place[0]) & (x < place[2]) & (z > place[1]) & (z < place[3]))


def surface_of(facade: Facade, scan: Scan, beams: Beams, reach: tuple[float, float]) -> Surface:
    """The points within `reach` m before and behind the wall."""
    xyz = facade.frame.inverse.apply(scan.xyz[facade.support])
    depth = xyz[:, 1] - beams.depth_at(xyz[:, 0], xyz[:, 2])
    near = (depth > -max(reach[0], beams.least)) & (depth < max(reach[1], beams.least))
    return Surface(xyz[near][:, [0, 2]], xyz[near, 1], facade.support[near])


def scan_channels(surface: Surface, facade: Facade, scan: Scan) -> list[Channel]:
    """Relief, and intensity and colour as far as the scan has them."""
    values: list[Float] = [surface.depth / _RELIEF]
    if scan.intensity is not None:
        values.append(_flattened(scan.intensity[surface.index], surface.index, scan, facade))
    if scan.rgb is not None:
        values += _colours(scan.rgb[surface.index])
    raster = Raster.over(facade, max(_PER_CELL * facade.spacing, _FINEST))
    size = raster.shape[0] * raster.shape[1]
    at = raster.flat(*surface.xz.T)
    on = at >= 0
    number = np.bincount(at[on], minlength=size)

    def channel(v: Float) -> Channel:
        with np.errstate(invalid="ignore"):
            means = np.bincount(at[on], v[on], minlength=size) / number

        def near(place: Place) -> tuple[Float, Float]:
            some = surface.within(place)
            return surface.xz[some], v[some]

        return Channel(Picture(means.reshape(raster.shape), raster), near, facade.spacing, 0.0)

    return [channel(v) for v in values]


def photo_channels(ortho: OrthoImage, facade: Facade) -> list[Channel]:
    """Lightness and two differences of colour of the pixels that photos saw; none where none did."""
    if ortho.photos == 0:
        return []
    raster = Raster.over(facade, max(_PER_CELL * ortho.gsd, _FINEST))
    size = raster.shape[0] * raster.shape[1]
    number, total = np.zeros(size), np.zeros((3, size))
    for first in range(0, ortho.size[1], _STRIP):
        xz, values = _pixels(ortho, slice(first, first + _STRIP), slice(None))
        at = raster.flat(*xz.T)
        on = at >= 0
        number += np.bincount(at[on], minlength=size)
        for k, v in enumerate(values):
            total[k] += np.bincount(at[on], v[on], minlength=size)
    if not number.any():
        return []
    sharp = float(np.nanmedian(ortho.gsd_effective))

    def channel(k: int) -> Channel:
        with np.errstate(invalid="ignore", divide="ignore"):
            means = (total[k] / number).reshape(raster.shape)

        def near(place: Place) -> tuple[Float, Float]:
            (x0, top), gsd = ortho.corner, ortho.gsd
            rows = slice(max(int((top - place[3]) / gsd), 0), max(int((top - place[1]) / gsd) + 1, 0))
            columns = slice(max(int((place[0] - x0) / gsd), 0), max(int((place[2] - x0) / gsd) + 1, 0))
            xz, values = _pixels(ortho, rows, columns)
            return xz, values[k]

        return Channel(Picture(means, raster), near, ortho.gsd, sharp)

    return [channel(k) for k in range(3)]


def _pixels(ortho: OrthoImage, rows: slice, columns: slice) -> tuple[Float, list[Float]]:
    """Middles xz (n, 2) m and colours of those pixels of a window that photos saw."""
    source = ortho.source[rows, columns]
    r, c = np.nonzero((source > 0) & (source <= ortho.photos))
    x0, top = ortho.corner
    x = x0 + (c + (columns.start or 0) + 0.5) * ortho.gsd
    z = top - (r + (rows.start or 0) + 0.5) * ortho.gsd
    return np.column_stack([x, z]), _colours(ortho.pixels[rows, columns][r, c, :3])


def _colours(rgb: Array) -> list[Float]:
    """Logarithms of lightness, red over green and blue over green (n,) of colours (n, 3) uint8."""
    red, green, blue = np.log(rgb.astype(np.float64) + _DARK).T
    return [(red + green + blue) / 3.0, red - green, blue - green]


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
