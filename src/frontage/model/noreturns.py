"""Laser beams without return: directions in which a station measured and received nothing."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int, freeze
from frontage.geometry.rigid import Rigid3

_SAMPLED = 128  # rows that give the azimuth of every column, columns that give the elevation of every row
_REGULAR = 0.95  # share of the returns that must lie within half a step of their place in the raster
_FEWEST_LINES = 8  # rows and columns with returns that are needed to find the axis of a raster
_DOWN_RAD = np.radians([5.0, 30.0])  # below the horizon: such beams end on the ground, 3 to 20 m away
_MARGIN_RAD = 0.02  # around the directions of interest


@dataclass(frozen=True, eq=False)
class NoReturns:
    """The beams of one station that had no return, as a mask over its polar raster.

    A scanner turns about a single axis, so every column has one azimuth about it and every row one elevation.

    origin     row of the station in `Scan.origins`
    axes       (3, 3) float64 rotation, local from the axes of the raster (z = the axis of the scanner)
    azimuth    (w,) float64 rad of the columns; elevation (h,) float64 rad of the rows
    lost       (h, w) bool, the beams without return
    ground     share of the beams towards the ground that were lost; if it is large, points were cut out of
               the scan, or the scanner is too weak for the surfaces around it
    """

    origin: int
    axes: Float
    azimuth: Float
    elevation: Float
    lost: Bool
    ground: float

    def __post_init__(self) -> None:
        line = ((None,), np.float64)
        freeze(self, axes=((3, 3), np.float64), azimuth=line, elevation=line)
        freeze(self, lost=((len(self.elevation), len(self.azimuth)), np.bool_))

    @property
    def directions(self) -> Float:
        """Unit directions (k, 3) float64 local of the lost beams."""
        row, column = np.nonzero(self.lost)
        a, e = self.azimuth[column], self.elevation[row]
        flat = np.cos(e)
        return np.asarray(np.column_stack([flat * np.cos(a), flat * np.sin(a), np.sin(e)]) @ self.axes.T)

    def moved(self, pose: Rigid3) -> "NoReturns":
        """Returns the same beams after a motion of their station."""
        return replace(self, axes=pose.R @ self.axes)

    def towards(self, rays: Float) -> "NoReturns":
        """Returns the part of the raster that covers the directions `rays` (n, 3), local from the station."""
        a, e = _polar(rays @ self.axes)
        middle = float(np.angle(np.exp(1j * a).mean()))
        wide = float(np.abs(_wrapped(a - middle)).max()) + _MARGIN_RAD
        columns = np.abs(_wrapped(self.azimuth - middle)) <= wide
        rows = (self.elevation >= e.min() - _MARGIN_RAD) & (self.elevation <= e.max() + _MARGIN_RAD)
        return replace(
            self,
            azimuth=self.azimuth[columns],
            elevation=self.elevation[rows],
            lost=self.lost[np.ix_(rows, columns)],
        )


def no_returns(xyz: Float, eye: Float, index: Int) -> NoReturns | None:
    """Finds the beams without return of a raster.

    xyz    (n, 3) m local, the points
    eye    (3,) m local, the station
    index  (h, w) into the points; -1 = no return

    Rows and columns without any return are placed between and beyond the others at their steps. Returns None
    where the returns do not lie on a polar raster (other instruments, indices with another meaning).
    """
    if min((index >= 0).any(axis).sum() for axis in (0, 1)) < _FEWEST_LINES:
        return None
    upright, level = index[:: -(-len(index) // _SAMPLED)], index[:, :: -(-index.shape[1] // _SAMPLED)]
    axes = _axes(xyz[upright] - eye, upright >= 0)
    a, _ = _polar((xyz[upright] - eye) @ axes)
    azimuth, wide = _line(a.T, (upright >= 0).T)
    _, e = _polar((xyz[level] - eye) @ axes)
    elevation, high = _line(e, level >= 0)
    if min(wide, high) < _REGULAR:
        return None
    found = NoReturns(0, axes, azimuth, elevation, index < 0, 1.0)
    return replace(found, ground=_ground(found))


def _ground(beams: NoReturns) -> float:
    """Share of the lost beams among those that point to the ground, but not to the tripod."""
    column = slice(None, None, -(-len(beams.azimuth) // _SAMPLED))
    a, e = beams.azimuth[None, column], beams.elevation[:, None]
    x, y, z = beams.axes[2]
    down = np.cos(e) * (x * np.cos(a) + y * np.sin(a)) + z * np.sin(e)
    there = (down < -np.sin(_DOWN_RAD[0])) & (down > -np.sin(_DOWN_RAD[1]))
    return float(beams.lost[:, column][there].mean()) if there.any() else 1.0


def _axes(rays: Float, held: Bool) -> Float:
    """Estimates the axes (3, 3) of the raster from its rays (h, w, 3).

    The rays of a row form a circle about the axis of the scanner, along which they scatter least.
    """
    d = np.where(held[..., None], rays / np.linalg.norm(rays, axis=2, keepdims=True), 0.0)
    mean = d.sum(1, keepdims=True) / np.maximum(held.sum(1), 1)[:, None, None]
    apart = np.where(held[..., None], d - mean, 0.0).reshape(-1, 3)
    _, vectors = np.linalg.eigh(apart.T @ apart)
    up = vectors[:, 0] * np.sign(vectors[2, 0] or 1.0)
    x = np.cross(up, np.eye(3)[np.abs(up).argmin()])
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(up, x), up])


def _polar(rays: Float) -> tuple[Float, Float]:
    """Returns azimuth and elevation in rad of rays (..., 3)."""
    x, y, z = np.moveaxis(rays, -1, 0)
    return np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))


def _wrapped(angle: Float) -> Float:
    """Wraps angles to -pi..pi."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)


def _line(angles: Float, held: Bool) -> tuple[Float, float]:
    """Estimates one angle (n,) for each row of `angles` (n, m) from those that are `held`.

    Rows without any are interpolated. Also returns the share of angles within half a step of their row's.
    """
    known = held.any(1)
    own, mask = angles[known], held[known]
    mean = np.angle((np.exp(1j * own) * mask).sum(1))
    off = np.where(mask, _wrapped(own - mean[:, None]), np.nan)
    middle = np.nanmedian(off, axis=1)
    at, told, n = np.flatnonzero(known), np.unwrap(mean + middle), np.arange(len(angles))
    step = float(np.median(np.diff(told) / np.diff(at))) if len(at) > 1 else 0.0
    line = np.interp(n, at, told) + step * (np.minimum(n - at[0], 0) + np.maximum(n - at[-1], 0))
    on = np.abs(off - middle[:, None]) <= 0.5 * abs(step)
    return line, float(on[mask].mean())
