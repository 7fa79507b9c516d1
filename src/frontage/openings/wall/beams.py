"""Sorts the beams at a wall: those that ended on it, those that went through it, those stopped before it."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Array, Bool, Float, Int, distinct, freeze
from frontage.geometry.sightlines import SightLines
from frontage.model.facade import Facade
from frontage.model.masonry import TOLERANCES
from frontage.model.scan import Scan

_TILE = 0.25  # m, side of the tiles that hold the depth of the wall
_FINE = 8  # cells of a tile, along and across, in which its area is counted
_KERNEL = 0.8  # m, one sigma of the surroundings that determine the depth of a tile: wider than half a window
_PEAK = 0.25  # share of the largest area that a surface needs to be the wall: glass fronts hold little wall
_FINEST = 0.01  # m, least bin of depths
_RECESS = 6.0  # m: shop fronts and gates are smaller; parts that are wider or higher and set back are walls
# m: the wall that a pier belongs to is that near; a recess smaller than that is no bay of the wall
_BESIDE = 1.5
_PIER = 0.4  # share of a tile that a pier fills
# m: sills, surrounds, open shutters and cut stone stand out no further, and close what they cover
_FITTING = 0.3
_APART = 2.0  # spacings between a fitting's point and its shadow from which they lie in different cells
_REACH = 60.0  # m behind the wall that a beam through it may reach
_FLAT = 1e-3  # m of depth that a beam must cover on its way


@dataclass(frozen=True)
class Raster:
    """Cells over the facade plane.

    corner  x, z m of the lower left corner
    cell    m, side of a cell
    shape   number of rows (upwards) and columns
    """

    corner: tuple[float, float]
    cell: float
    shape: tuple[int, int]

    @classmethod
    def over(cls, facade: Facade, cell: float) -> "Raster":
        """Returns the raster with cells of `cell` m over the facade's bounding box."""
        x0, z0, x1, z1 = facade.extent
        return cls((x0, z0), cell, (int((z1 - z0) / cell) + 1, int((x1 - x0) / cell) + 1))

    def flat(self, x: Float, z: Float) -> Int:
        """Returns the number of the cell of every place (n,), row by row; -1 outside or for NaN."""
        with np.errstate(invalid="ignore"):
            c = np.floor((x - self.corner[0]) / self.cell)
            r = np.floor((z - self.corner[1]) / self.cell)
            inside = (c >= 0) & (r >= 0) & (c < self.shape[1]) & (r < self.shape[0])
            return np.where(inside, r * self.shape[1] + c, -1.0).astype(np.int64)

    def box(self, r0: int, c0: int, r1: int, c1: int) -> tuple[float, float, float, float]:
        """Returns the box x0, z0, x1, z1 m of the cells in the rows [r0, r1) and columns [c0, c1)."""
        x, z = self.corner
        return x + c0 * self.cell, z + r0 * self.cell, x + c1 * self.cell, z + r1 * self.cell

    def middles(self, which: Bool) -> Float:
        """Returns the middles (n, 2) x, z m of the cells that are set in `which` (h, w), row by row."""
        rows, columns = np.nonzero(which)
        return np.column_stack([columns + 0.5, rows + 0.5]) * self.cell + self.corner

    def count(self, x: Float, z: Float, weight: Float | None = None) -> Float:
        """Counts the places (n,) in each cell (h, w), or sums their weights (n,)."""
        at = self.flat(x, z)
        on, size = at >= 0, self.shape[0] * self.shape[1]
        sums = np.bincount(at[on], None if weight is None else weight[on], size)
        return sums.reshape(self.shape).astype(np.float64)


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
    """

    solid: Float
    solid_depth: Float
    open: Float
    open_depth: Float
    blocked: Float
    front: Float
    wall: Float
    raster: Raster
    sigma: float
    least: float
    lines: WallCrossings
    rays: bool

    def __post_init__(self) -> None:
        pair = ((None, 2), np.float64)
        freeze(self, solid=pair, open=pair, blocked=pair, front=((None, 3), np.float64))

    def depth_at(self, x: Float, z: Float) -> Float:
        """Returns the depth y (n,) m of the wall at places (n,); outside, that of the nearest cell."""
        return _at(self.wall, self.raster, x, z)


def sort_beams(facade: Facade, scan: Scan) -> Beams:
    """Sorts every beam of the working cloud that has to do with the facade's wall.

    With known sensors, a beam counts where it crosses the wall at its local depth (found on the plane first,
    then once more at the depth there). Without them, a point stands for the place on the wall right before
    it.
    """
    to_facade = facade.frame.inverse
    near = to_facade.apply(scan.xyz[facade.support])
    raster = Raster.over(facade, _TILE)
    wall = _wall_depth(near, raster, facade.roughness)
    residual = near[:, 1] - _at(wall, raster, near[:, 0], near[:, 2])
    close = np.abs(residual) < max(3.0 * facade.roughness, TOLERANCES.least_on_wall)
    sigma = 1.4826 * float(np.median(np.abs(residual[close]))) if close.any() else facade.roughness
    least = max(3.0 * sigma, TOLERANCES.least_on_wall)
    known = scan.origin_index >= 0
    lone = facade.support[~known[facade.support]]
    lines = _lines(facade, scan, wall, raster)
    place, depth = lines.place.T, lines.y - _at(wall, raster, *lines.place)
    point = to_facade.apply(scan.xyz[lone])
    own = point[:, 1] - _at(wall, raster, point[:, 0], point[:, 2])
    d = residual
    on = (d <= least) & (d >= -_FITTING)
    aside = np.hypot(*lines.slope) * -depth  # m between a fitting's point and its shadow on the wall
    through = depth > least
    stopped = (depth < -_FITTING) | ((depth < -least) & (aside > _APART * facade.spacing))
    behind, ahead = own > least, d < -_FITTING
    return Beams(
        near[on][:, [0, 2]],
        d[on],
        np.vstack([place[through], point[behind][:, [0, 2]]]),
        np.concatenate([depth[through], own[behind]]),
        place[stopped],
        np.column_stack([near[ahead][:, [0, 2]], d[ahead]]),
        wall,
        raster,
        sigma,
        least,
        lines,
        bool(known[facade.support].mean() > 0.5) if len(facade.support) else False,
    )


def _lines(facade: Facade, scan: Scan, wall: Float, raster: Raster) -> WallCrossings:
    """Returns the lines of sight that cross the wall, from in front of it, within the facade's bounding box.

    They are crossed with the plane first, then with the depth that the wall (h, w) has there.
    """
    to_facade = facade.frame.inverse
    eyes = np.vstack([to_facade.apply(scan.origins).reshape(-1, 3), np.full(3, np.nan)])  # -1 is unknown
    points = to_facade.apply(scan.xyz)
    ahead = np.where(eyes[:, 1] < -_FITTING, eyes[:, 1], np.nan)[scan.origin_index]
    ok = np.flatnonzero((points[:, 1] - ahead > _FLAT) & (points[:, 1] < _REACH))
    points, origin, y = points[ok], scan.origin_index[ok], points[ok, 1]
    lines = SightLines.to_points(points, eyes[origin], _FLAT)
    on_plane = lines.moved_to(np.zeros(len(y)))
    crossed = on_plane.moved_to(_at(wall, raster, *on_plane.place))
    ok = np.flatnonzero(raster.flat(*crossed.place) >= 0)
    own = crossed.take(ok)
    run = (y - eyes[origin, 1])[ok]
    distance = (run + own.level - y[ok]) * np.sqrt(1.0 + (own.slope**2).sum(0))
    return WallCrossings(own.place, own.slope, own.level, y[ok], distance)


def _wall_depth(xyz: Float, raster: Raster, roughness: float) -> Float:
    """Returns the depth (h, w) y m of the surface that fills much of the area around each tile.

    Of several surfaces it is the one on the facade plane or nearest before it, else the first behind it:
    frames and panes lie behind the wall they belong to, balconies and bays well before it.
    """
    step = max(roughness, _FINEST)
    low, high = float(xyz[:, 1].min()), float(xyz[:, 1].max())
    bins = int((high - low) / step) + 2
    level = ((xyz[:, 1] - low) / step).astype(np.int64)
    flat = raster.flat(xyz[:, 0], xyz[:, 2])
    fine = Raster(raster.corner, _TILE / _FINE, (raster.shape[0] * _FINE, raster.shape[1] * _FINE))
    kept = flat >= 0
    key = fine.flat(xyz[kept, 0], xyz[kept, 2]) * bins + level[kept]
    cell, offset = np.divmod(distinct(key), bins)  # area, not points: every cell counts once per offset
    row, column = np.divmod(cell, fine.shape[1])
    tile = row // _FINE * raster.shape[1] + column // _FINE
    held = np.bincount(tile * bins + offset, minlength=raster.shape[0] * raster.shape[1] * bins)
    own = held.reshape(*raster.shape, bins).astype(np.float32)
    wide = (_KERNEL / _TILE, _KERNEL / _TILE, 1.0)
    area = ndimage.gaussian_filter(own, wide, mode="constant", truncate=3.0)
    y = np.asarray(low + (np.arange(bins) + 0.5) * step, np.float64)
    wall = _without_recesses(_chosen(area, y, 3.0 * step), own, y, 3.0 * step)
    return _refined(wall, xyz, raster, 3.0 * step)


def _chosen(area: Array, y: Float, slack: float) -> Float:
    """Returns the depth (h, w) m of the wall among the peaks of `area` (h, w, bins) at y (bins,) m."""
    peak = (area >= _PEAK * area.max(2, keepdims=True)) & (area > 0)
    peak[..., 1:-1] &= (area[..., 1:-1] >= area[..., :-2]) & (area[..., 1:-1] > area[..., 2:])
    # surfaces before the plane rank by how far they stand out; those behind it come after all of them
    rank = np.where(y <= slack, np.abs(y), 10.0 + y)
    best = np.where(peak, rank, np.inf).argmin(2)
    empty = ~peak.any(2)
    if empty.all():
        return np.zeros(empty.shape)
    return _filled(y[best], empty)


def _without_recesses(wall: Float, own: Array, y: Float, slack: float) -> Float:
    """Corrects the depth (h, w) m where it follows panes, gates and rooms of wide openings.

    These may be the surface with most area around, but they are neither as wide nor as high as a set-back
    part of the building. Piers between them are wall: tiles that mostly hold (`own` (h, w, bins)) the wall
    beside.
    """
    bay = int(_BESIDE / _TILE)
    panel = (ndimage.grey_closing(wall, (bay, bay)) > wall + slack) & (wall < -_FITTING)
    wall = _filled(wall, panel)
    beside = ndimage.minimum_filter(wall, bay)
    level = np.abs(y - beside[..., None]) <= slack
    pier = np.einsum("rcb,rcb->rc", own, level) > _PIER * own.sum(2)
    high, wide = _opened(wall)
    wall = np.where(pier & (wall > np.minimum(high, wide) + slack), beside, wall)
    return _filled(wall, wall > np.maximum(*_opened(wall)) + slack)


def _opened(wall: Float) -> tuple[Float, Float]:
    """Removes from the map (h, w) what is lower, and what is narrower, than a set-back part of a building."""
    size = int(_RECESS / _TILE)
    return ndimage.grey_opening(wall, (size, 1)), ndimage.grey_opening(wall, (1, size))


def _filled(values: Float, gap: Bool) -> Float:
    """Fills the gaps in the values (h, w) with the nearest others."""
    near = ndimage.distance_transform_edt(gap, return_distances=False, return_indices=True)
    return np.asarray(values[tuple(near)])


def _refined(wall: Float, xyz: Float, raster: Raster, slack: float) -> Float:
    """Refines the depth (h, w) m to the mean of the wall's own points around each tile.

    Tiles with few of these points belong to openings: they take the depth of the wall beside, not that of
    their mullions and frames.
    """
    flat = raster.flat(xyz[:, 0], xyz[:, 2])
    d = xyz[:, 1] - _at(wall, raster, xyz[:, 0], xyz[:, 2])
    on = (flat >= 0) & (np.abs(d) <= slack)
    size = raster.shape[0] * raster.shape[1]
    number = np.bincount(flat[on], minlength=size).reshape(raster.shape).astype(np.float64)
    total = np.bincount(flat[on], d[on], minlength=size).reshape(raster.shape)
    weight = ndimage.uniform_filter(number, 3, mode="constant")
    mean = ndimage.uniform_filter(total, 3, mode="constant") / np.maximum(weight, 1e-9)
    own = wall + np.where(weight > 1e-9, mean, 0.0)
    most = ndimage.maximum_filter(weight, 2 * int(_BESIDE / _TILE) + 1)
    beside = _between(own, weight >= _PIER * most)
    return np.where(np.abs(beside - own) <= slack, beside, own)


def _between(values: Float, held: Bool) -> Float:
    """Interpolates the values (h, w) that are not `held` between the next held ones of their row."""
    w = values.shape[1]
    at = np.broadcast_to(np.arange(w), values.shape)
    left = np.maximum.accumulate(np.where(held, at, -1), axis=1)
    right = np.minimum.accumulate(np.where(held, at, w)[:, ::-1], axis=1)[:, ::-1]
    before, after = (np.take_along_axis(values, np.clip(k, 0, w - 1), 1) for k in (left, right))
    line = before + (after - before) * (at - left) / np.maximum(right - left, 1)
    return np.where((left < 0) | (right >= w), values, line)


def _at(values: Float, raster: Raster, x: Float, z: Float) -> Float:
    """Returns the value (n,) of the cell of each place, or of the nearest cell."""
    h, w = raster.shape
    c = np.clip((x - raster.corner[0]) / raster.cell, 0, w - 1).astype(np.int64)
    r = np.clip((z - raster.corner[1]) / raster.cell, 0, h - 1).astype(np.int64)
    return np.asarray(values.ravel()[r * w + c])
