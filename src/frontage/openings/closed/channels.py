"""How the wall looks, channel by channel: intensity freed of range and incidence, colour, relief, photos."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int, rising
from frontage.geometry.sightlines import SightLines
from frontage.model.facade import Facade
from frontage.model.ortho import OrthoImage
from frontage.model.scan import Scan
from frontage.openings.boxes import Box
from frontage.openings.closed.steps import ChannelMap
from frontage.openings.wall.beams import Beams, sensor_positions
from frontage.openings.wall.evidence import PER_CELL
from frontage.openings.wall.raster import WallRaster

_FINEST = 0.04  # m, least side of a cell: borders are known that well before they are measured
_FLAT = 0.1  # m of depth that a line of sight must cover
_DEEPEST = 0.08  # m: what lies deeper (frames behind grilles, rooms) counts as lying there
_RELIEF = 0.04  # m that count as much as one step of brightness (a factor of e)
_STATIONS = 12  # origins: with more of them the sensor moved, and all points are one group
_PLACES = 50  # points that the fit of a station needs
_ROUNDS = 4  # rounds of the robust fit
_SOME = 20000  # points that a fit needs at most
_DARK = 4.0  # of 255: below, colours are noise
_FAINT = 0.01  # quantile of the intensities: fainter points count as that faint
_STRIP = 512  # rows of an ortho-image that are read at a time


@dataclass(frozen=True, eq=False)
class ChannelLayer:
    """Channels c of the wall, seen together, that may step at the borders of what closes an opening.

    picture  means of cells
    near     returns the places xz (n, 2) m and the values (n, c) in a box
    spacing  m between these
    sharp    m, width of a sharp step, and how far its place may be off
    """

    picture: ChannelMap
    near: Callable[[Box], tuple[Float, Float]]
    spacing: float
    sharp: float


@dataclass(frozen=True, eq=False)
class WallSamples:
    """The scan's points on or near the wall, sorted upwards.

    xz     (n, 2) m, places on the wall
    y      (n,) m, depth in the facade frame
    depth  (n,) m behind the wall
    index  rows of the scan
    """

    xz: Float
    y: Float
    depth: Float
    index: Array

    def within(self, place: Box) -> Int:
        """Returns the numbers (k,) of the points in a box."""
        first, last = np.searchsorted(self.xz[:, 1], [place[1], place[3]])
        return np.asarray(first + np.flatnonzero(within(self.xz[first:last], place)))


def within(xz: Float, place: Box) -> Bool:
    """Returns which of the places (n, 2) m lie in a box (n,)."""
    x, z = xz.T
    return np.asarray((x > place[0]) & (x < place[2]) & (z > place[1]) & (z < place[3]))


def wall_points(facade: Facade, scan: Scan, beams: Beams, reach: tuple[float, float]) -> WallSamples:
    """Returns the points within `reach` m before and behind the wall."""
    xyz = beams.points
    depth = xyz[:, 1] - beams.depth_at(xyz[:, 0], xyz[:, 2])
    near = (depth > -max(reach[0], beams.least)) & (depth < max(reach[1], beams.least))
    xyz, depth, index = xyz[near], depth[near], facade.support[near]
    xz = _crossings(xyz, depth, index, facade, scan)
    up = rising(xz[:, 1])
    return WallSamples(xz[up], xyz[up, 1], depth[up], index[up])


def _crossings(xyz: Float, depth: Float, index: Array, facade: Facade, scan: Scan) -> Float:
    """Returns the places (n, 2) m where the lines of sight of points behind the wall cross it.

    The wall lies `depth` m before the points. Points before it, as on sills, and points of unknown sensors
    stand for themselves.
    """
    eyes = sensor_positions(facade, scan)[scan.origin_index[index]]
    lines = SightLines.to_points(xyz, eyes, _FLAT)
    return np.ascontiguousarray(lines.shifted(-np.maximum(depth, 0.0)).T)


def looks_of(surface: WallSamples, facade: Facade, scan: Scan) -> Float:
    """Returns how the points of the wall look: the values (n, c) of all channels that the scan has.

    The channels are relief, intensity, lightness, red over green, and blue over green, in this order.
    """
    channels: list[Float] = [(surface.y - np.maximum(surface.depth - _DEEPEST, 0.0)) / _RELIEF]
    if scan.intensity is not None:
        channels.append(_flattened(scan.intensity[surface.index], surface.index, scan, facade))
    if scan.rgb is not None:
        channels += _colours(scan.rgb[surface.index])
    return np.column_stack(channels)


def scan_layer(surface: WallSamples, facade: Facade, scan: Scan) -> ChannelLayer:
    """Returns the channels that the scan itself has: relief, and intensity and colour if it has them."""
    values = looks_of(surface, facade, scan)
    raster = WallRaster.over(facade, max(PER_CELL * facade.spacing, _FINEST))

    def near(place: Box) -> tuple[Float, Float]:
        some = surface.within(place)
        return surface.xz[some], values[some]

    means = _Means(raster, values.shape[1])
    means.add(surface.xz, values)
    return ChannelLayer(means.picture(), near, facade.spacing, 0.0)


def photo_layer(ortho: OrthoImage, facade: Facade) -> ChannelLayer | None:
    """Returns lightness and two differences of colour of the pixels that photos saw; None where none did."""
    if ortho.photos == 0:
        return None
    means = _Means(WallRaster.over(facade, max(PER_CELL * ortho.gsd, _FINEST)), 3)
    for first in range(0, ortho.size[1], _STRIP):
        means.add(*_pixels(ortho, slice(first, first + _STRIP), slice(None)))
    if not means.number.any():
        return None

    def near(place: Box) -> tuple[Float, Float]:
        (x0, top), gsd = ortho.corner, ortho.gsd
        rows = slice(max(int((top - place[3]) / gsd), 0), max(int((top - place[1]) / gsd) + 1, 0))
        columns = slice(max(int((place[0] - x0) / gsd), 0), max(int((place[2] - x0) / gsd) + 1, 0))
        return _pixels(ortho, rows, columns)

    return ChannelLayer(means.picture(), near, ortho.gsd, float(np.nanmedian(ortho.gsd_effective)))


class _Means:
    """Means of what falls into the cells of a raster."""

    def __init__(self, raster: WallRaster, channels: int) -> None:
        size = raster.shape[0] * raster.shape[1]
        self._raster = raster
        self.number, self._total = np.zeros(size), np.zeros((channels, size))

    def add(self, xz: Float, values: Float) -> None:
        """Adds values (n, c) at places (n, 2) m."""
        at = self._raster.flat(*xz.T)
        on, size = at >= 0, len(self.number)
        self.number += np.bincount(at[on], minlength=size)
        for total, v in zip(self._total, values.T, strict=True):
            total += np.bincount(at[on], v[on], minlength=size)

    def picture(self) -> ChannelMap:
        """Returns the means of all that was added."""
        known, shape = (self.number > 0.0) & np.isfinite(self._total).all(0), self._raster.shape
        total, number = np.where(known, self._total, 0.0), np.maximum(self.number, 1.0)
        means = np.divide(total.T, number[:, None], order="C").reshape(*shape, -1)
        return ChannelMap(means, self._raster, known.reshape(shape))


def _pixels(ortho: OrthoImage, rows: slice, columns: slice) -> tuple[Float, Float]:
    """Returns the middles xz (n, 2) m and the colours (n, 3) of those pixels of a window that photos saw."""
    source = ortho.source[rows, columns]
    r, c = np.nonzero((source > 0) & (source <= ortho.photos))
    x0, top = ortho.corner
    x = x0 + (c + (columns.start or 0) + 0.5) * ortho.gsd
    z = top - (r + (rows.start or 0) + 0.5) * ortho.gsd
    return np.column_stack([x, z]), np.column_stack(_colours(ortho.pixels[rows, columns][r, c, :3]))


def _colours(rgb: Array) -> list[Float]:
    """Returns the logarithms of lightness, red over green and blue over green (n,) of colours (n, 3)."""
    red, green, blue = np.log(rgb.astype(np.float64) + _DARK).T
    return [(red + green + blue) / 3.0, red - green, blue - green]


def _flattened(intensity: Array, index: Array, scan: Scan, facade: Facade) -> Float:
    """Returns the logarithm of the intensity (n,) less what range and incidence explain, by station.

    A robust line in the logarithms of range and of the cosine of incidence (Hoefle & Pfeifer 2007), whose
    exponents the wall itself tells, for instruments compress and correct in their own ways. The range is that
    to the facade's plane: with the range to the points, both together would be the depth of the points, and
    the darkness of a shutter behind the wall would be explained by its depth.
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
        eye = facade.frame.inverse.apply(scan.sensor_of(index[group]))
        ray = facade.frame.inverse.apply(scan.xyz[index[group]]) - eye
        cosine = np.maximum(np.abs(ray[:, 1]) / np.maximum(np.linalg.norm(ray, axis=1), 1e-3), 1e-3)
        range_ = np.maximum(np.abs(eye[:, 1]), 1e-3) / cosine
        model = np.column_stack([np.ones(len(ray)), np.log(range_), np.log(cosine)])
        out[group] = v[group] - model @ _robust_line(model, v[group])
    return out


def _robust_line(model: Float, v: Float) -> Float:
    """Returns the coefficients (k,) of v (n,) by the columns of model (n, k), outliers bounded."""
    step = max(len(v) // _SOME, 1)
    a, b = model[::step], v[::step]
    weight: Float = np.ones(len(b))
    x: Float = np.zeros(a.shape[1])
    for _ in range(_ROUNDS):
        x = np.asarray(np.linalg.lstsq(a * weight[:, None], b * weight, rcond=None)[0], np.float64)
        rest = np.abs(b - a @ x)
        weight = np.asarray(np.maximum(rest / max(1.5 * float(np.median(rest)), 1e-9), 1.0) ** -0.5)
    return x
