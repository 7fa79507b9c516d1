"""Sorts the beams at a wall: those that ended on it, those that went through it, those stopped before it."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, freeze
from frontage.geometry.sightlines import SightLines
from frontage.model.canonical import steady
from frontage.model.facade import Facade
from frontage.model.masonry import TOLERANCES
from frontage.model.scan import Scan
from frontage.openings.wall.fields import FieldOfView, fields_of_view
from frontage.openings.wall.raster import FITTING, TILE, WallRaster
from frontage.openings.wall.roofs import roof_level
from frontage.openings.wall.surface import value_at, wall_depth

_APART = 2.0  # spacings between a fitting's point and its shadow from which they lie in different cells
_REACH = 60.0  # m behind the wall that a beam through it may reach
_FLAT = 1e-3  # m of depth that a beam must cover on its way


@dataclass(frozen=True, eq=False)
class WallCrossings(SightLines):
    """Lines of sight (n,) that cross the wall, with their places at its local depth.

    y      (n,) m, depth of their points in the facade frame
    range  (n,) m, distance from the sensor to the wall along the line
    """

    y: Float
    range: Float


@dataclass(frozen=True, eq=False)
class Beams:
    """The beams at a wall, sorted by what they say.

    solid        (n, 2) x, z m of the points on the wall or on what is fitted to it
    solid_depth  (n,) m of these points behind the wall (negative = in front of it)
    open         (m, 2) x, z m where the beams of the points behind the wall crossed it
    open_depth   (m,) m of these points behind the wall
    blocked      (k, 2) x, z m where beams would have met the wall that something before it stopped
    front        (p, 3) x, z m and depth m (negative) of the points before the wall, without fittings
    wall         (h, w) depth y m of the wall on `raster`
    sigma        m, one sigma of the wall's own points about its depth
    least        m, distance from the wall beyond which a point is not on it
    lines        the lines of sight that are known, where they cross the wall
    rays         whether most lines of sight are known
    points       (s, 3) m, points of the facade's support in its frame
    fields       fields of view of the stations
    roof         m, height z from which points of unknown sensors behind the wall were seen from a roof
    """

    solid: Float
    solid_depth: Float
    open: Float
    open_depth: Float
    blocked: Float
    front: Float
    wall: Float
    raster: WallRaster
    sigma: float
    least: float
    lines: WallCrossings
    rays: bool
    points: Float
    fields: tuple[FieldOfView, ...] = ()
    roof: float = np.inf

    def __post_init__(self) -> None:
        pair = ((None, 2), np.float64)
        freeze(self, solid=pair, open=pair, blocked=pair, front=((None, 3), np.float64))

    def depth_at(self, x: Float, z: Float) -> Float:
        """Returns the depth y (n,) m of the wall at places (n,); outside, that of the nearest cell."""
        return value_at(self.wall, self.raster, x, z)


def sort_beams(facade: Facade, scan: Scan, wall: Float | None = None) -> Beams:
    """Sorts every beam of the working cloud that has to do with the facade's wall.

    `wall` (h, w) m is its depth in tiles over the facade where that is known, else it is measured.

    With known sensors, a beam counts where it crosses the wall at its local depth (found on the plane first,
    then once more at the depth there). Without them, a point stands for the place on the wall right before
    it, unless it lies on or above a flat roof.
    """
    to_facade = facade.frame.inverse
    points = to_facade.apply(np.take(scan.xyz, facade.support, axis=0))
    near = steady(points)
    raster = WallRaster.over(facade, TILE)
    known = scan.origin_index >= 0
    alone = ~known[facade.support]
    rays = bool(alone.mean() < 0.5) if len(alone) else False
    wall = wall_depth(near, raster, facade.roughness, rays) if wall is None else wall
    residual = near[:, 1] - value_at(wall, raster, near[:, 0], near[:, 2])
    close = np.abs(residual) < max(3.0 * facade.roughness, TOLERANCES.least_on_wall)
    sigma = 1.4826 * float(np.median(np.abs(residual[close]))) if close.any() else facade.roughness
    least = max(3.0 * sigma, TOLERANCES.least_on_wall)
    lines = _lines(facade, scan, wall, raster)
    place, depth = lines.place.T, lines.y - value_at(wall, raster, *lines.place)
    d, own = residual, residual[alone]
    on = (d <= least) & (d >= -FITTING)
    aside = np.hypot(*lines.slope) * -depth  # m between a fitting's point and its shadow on the wall
    through = depth > least
    stopped = (depth < -FITTING) | ((depth < -least) & (aside > _APART * facade.spacing))
    ahead, lone = d < -FITTING, near[alone]
    roof = roof_level(lone, own, float(facade.outline[:, 1].max()))
    behind = (own > least) & (lone[:, 2] < roof)
    lone = lone[behind]
    return Beams(
        near[on][:, [0, 2]],
        d[on],
        np.vstack([place[through], lone[:, [0, 2]]]),
        np.concatenate([depth[through], own[behind]]),
        place[stopped],
        np.column_stack([near[ahead][:, [0, 2]], d[ahead]]),
        wall,
        raster,
        sigma,
        least,
        lines,
        rays,
        points,
        fields_of_view(facade, scan),
        roof,
    )


def _lines(facade: Facade, scan: Scan, wall: Float, raster: WallRaster) -> WallCrossings:
    """Returns the lines of sight that cross the wall, from in front of it, within the facade's bounding box.

    They are crossed with the plane first, then with the depth that the wall (h, w) has there.
    """
    to_facade = facade.frame.inverse
    eyes = sensor_positions(facade, scan)
    known = scan.origin_index >= 0
    some = slice(None) if known.all() else np.flatnonzero(known)
    points, origin = steady(to_facade.apply(scan.xyz[some])), scan.origin_index[some]
    ahead = np.where(eyes[:, 1] < -FITTING, eyes[:, 1], np.nan)[origin]
    ok = np.flatnonzero((points[:, 1] - ahead > _FLAT) & (points[:, 1] < _REACH))
    points, origin, y = points[ok], origin[ok], points[ok, 1]
    lines = SightLines.to_points(points, eyes[origin], _FLAT)
    on_plane = lines.moved_to(np.zeros(len(y)))
    crossed = on_plane.moved_to(value_at(wall, raster, *on_plane.place))
    ok = np.flatnonzero(raster.flat(*crossed.place) >= 0)
    own = crossed.take(ok)
    run = (y - eyes[origin, 1])[ok]
    distance = (run + own.level - y[ok]) * np.sqrt(1.0 + (own.slope**2).sum(0))
    return WallCrossings(own.place, own.slope, own.level, y[ok], distance)


def sensor_positions(facade: Facade, scan: Scan) -> Float:
    """Returns the positions (k + 1, 3) m of the scan's sensors in the facade frame.

    They are indexed by `Scan.origin_index`; the last row is NaN, for -1 stands for an unknown sensor.
    """
    return np.vstack([facade.frame.inverse.apply(scan.origins).reshape(-1, 3), np.full(3, np.nan)])
