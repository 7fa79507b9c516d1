"""The evidence of open against solid, cell by cell."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float, distinct, freeze
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.expected import blurred, expected_beams
from frontage.openings.wall.fields import zones
from frontage.openings.wall.raster import FITTING, WallRaster, averaged
from frontage.openings.wall.shadow import shadows_of_fittings

BARS = 0.12
"""Share of the expected beams that bars and frames level with the wall return."""

_FINEST = 0.02  # m, least side of a cell
COARSEST = MASONRY.half_brick  # m, largest side of a cell: the least pier
# nats against open per hit: bars and frames level with the wall return 12 % of the beams into a window
_HIT = np.log(0.97 / BARS)
# nats for open per expected beam that did not come: the difference of the Poisson means, 0.97 - 0.12
_LOST = 0.85
_MOST_LOST = 1.0  # nats of a cell from missing beams at most, for shadows leave cells empty as well
_THROUGH = np.log(0.88 / 0.03)  # nats for open per beam that ended behind: 3 % of the beams on a wall seem to
_BEHIND = 1.0  # nats for open per point behind the wall whose line of sight is not known
_CAP = 6.0  # nats of a cell at most: neighbouring beams err together
_SCALES = 4  # how often the surroundings of a cell are doubled
_BLUR = 0.1  # m, one sigma of the surroundings that determine empty areas
_ROOM = 0.3  # m, one sigma of the surroundings that tell a room's points: frames and reveals are narrower
_EMPTY = 0.1  # share of the expected beams below which an area is empty
_LAYERS = 6  # layers of depth in which fittings lie
_FILLED = 4  # layers that a surface seen edge on fills at least
_RELIEF = 0.05  # m: panels and courses of a wall are less deep

PER_CELL = 2.0
"""Spacings that a cell is wide: four beams on average."""

BEAMS_TO_DECIDE = 10.0
"""Beams that a decision needs to be wrong once in a thousand cases."""

LARGEST = 4.0
"""Size m that openings without any return do not exceed, unless they are ribbons."""

VISIBLE = 0.5
"""Share of the beams expected without obstacles that must reach the wall for it to be visible."""

WALL = 0.4
"""Share of the expected beams that masonry returns at least."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """What the beams say, as maps (h, w) on `raster`, row 0 the lowest.

    llr            nats, log-likelihood ratio of open against solid; 0 = nothing is known
    solid          beams that ended on the wall
    open           beams that went through it
    deep           beams that ended well behind the relief of a wall
    expected       beams that a wall would return there
    expected_free  the same if nothing stood before the wall
    seen           cells that some beam tells of
    inside         cells within the facade's outline
    rays           whether the lines of sight are known
    """

    raster: WallRaster
    llr: Float
    solid: Float
    open: Float
    deep: Float
    expected: Float
    expected_free: Float
    seen: Bool
    inside: Bool
    rays: bool

    def __post_init__(self) -> None:
        freeze(self, llr=((None, None), np.float64), inside=((None, None), np.bool_))

    @cached_property
    def is_open(self) -> Bool:
        """The cells (h, w) that are open as seen with the least surroundings that tell."""
        return np.asarray(local_rate(self.llr, self.expected_free, 1.0) > 0)


def weigh(facade: Facade, beams: Beams, inside: Bool | None = None, scale: float = 1.0) -> Evidence:
    """Weighs the evidence of every cell: hits speak against open, beams through it and missing beams for it.

    Hits of a wall are Poisson with the mean that the surroundings predict, those of an opening with 12 % of
    it. Nothing is expected in cells that a fitting or an occluder hides. A beam through the wall counts
    wherever its line of sight is known; a mere point behind the wall counts only where the wall itself is
    missing, for rooms are scanned too. `inside` (h, w) are the cells within the facade's outline where they
    are known; cells are `scale` times as wide as the spacing of the points asks for.
    """
    raster = WallRaster.over(facade, scale * min(max(PER_CELL * facade.spacing, _FINEST), COARSEST))
    solid, open_ = raster.count(*beams.solid.T), raster.count(*beams.open.T)
    inside = _inside(facade, raster) if inside is None else inside
    due = _expected_by_zone(beams, raster)
    back = solid + open_
    expected = due * _unhidden(beams, raster, back, due)
    shut = back if beams.rays else solid  # a front of glass that returns a few beams tells nothing
    expected = np.where(_unwatched(back, shut, expected, inside, raster.cell), 0.0, expected)
    through = _THROUGH * open_
    if not beams.rays:
        missing = averaged(solid) < np.maximum(0.3 * expected, 1e-9)
        # where more points lie behind the wall than it would return, rooms were scanned from inside
        through = _BEHIND * open_ / np.maximum(local_rate(open_, due, _ROOM / raster.cell), 1.0) * missing
    llr = np.where(inside, log_likelihood_ratio(expected, solid, through), 0.0)
    seen = back > 0
    deep = raster.count(*beams.open[beams.open_depth > max(_RELIEF, 2.0 * beams.least)].T)
    return Evidence(raster, llr, solid, open_, deep, expected, due, seen, inside, beams.rays)


def _expected_by_zone(beams: Beams, raster: WallRaster) -> Float:
    """Returns the beams (h, w) that a wall would return, predicted only from what the same stations see.

    Where a station's highest beam runs over the wall, the density falls at once.
    """
    zone = zones(beams.fields, raster)
    numbers = distinct(zone.ravel())
    wall = beams.solid[~_edge_on(beams, raster)]
    if len(numbers) == 1:
        return expected_beams(wall, raster)
    out = np.zeros(raster.shape)
    at = raster.flat(*wall.T)
    own = np.where(at >= 0, zone.ravel()[at], -1)
    for number in numbers:
        out = np.where(zone == number, expected_beams(wall[own == number], raster), out)
    return out


def _edge_on(beams: Beams, raster: WallRaster) -> Bool:
    """Returns which points (n,) lie before the wall in cells that show a surface edge on.

    Such a surface, as the next wall round an inner corner, fills all depths before the wall, and a cell of it
    holds many times as many points as one of the wall.
    """
    cell = raster.flat(*beams.solid.T)
    before = np.flatnonzero((beams.solid_depth < -beams.least) & (cell >= 0))
    layer = np.floor(-beams.solid_depth[before] * (_LAYERS / FITTING)).astype(np.int64)
    shown = distinct(cell[before] * _LAYERS + np.minimum(layer, _LAYERS - 1))
    filled = np.bincount(shown // _LAYERS, minlength=raster.shape[0] * raster.shape[1])
    out = np.zeros(len(beams.solid), np.bool_)
    out[before] = filled[cell[before]] >= _FILLED
    return out


def log_likelihood_ratio(expected: Float, solid: Float, through: Float) -> Float:
    """Returns the nats (h, w) for open: of missing beams, of hits, and `through` of beams beyond the wall."""
    lost = np.minimum(_LOST * expected, _MOST_LOST)
    return np.asarray(np.clip(lost - _HIT * solid + through, -_CAP, _CAP))


def _inside(facade: Facade, raster: WallRaster) -> Bool:
    """Returns which cells (h, w) have their middles within the facade's outline."""
    h, w = raster.shape
    x = raster.corner[0] + (np.arange(w) + 0.5) * raster.cell
    z = raster.corner[1] + (np.arange(h) + 0.5) * raster.cell
    polygon = shapely.make_valid(shapely.Polygon(facade.outline))
    shapely.prepare(polygon)
    gx, gz = np.meshgrid(x, z)
    return np.asarray(shapely.contains_xy(polygon, gx.ravel(), gz.ravel())).reshape(h, w)


def _unwatched(seen: Float, shut: Float, expected: Float, inside: Bool, cell: float) -> Bool:
    """Returns the cells (h, w) beyond the end of the scan: empty areas too large for an opening.

    Ribbon windows are longer than other openings, but there is wall above, below, and on one side at least.
    The empty area of a gate may continue in that of a car that hides the foot of the wall. The gate is the
    part that is a rectangle with wall above it and on both sides, where hardly any beams are `shut` (h, w):
    a mullion behind the wall parts what returns nothing.
    """
    out = np.zeros(seen.shape, np.bool_)
    rate, largest = local_rate(seen, expected, _BLUR / cell), int(LARGEST / cell)
    labels, _ = ndimage.label(inside & (rate < _EMPTY))
    places = enumerate(ndimage.find_objects(labels), 1)
    large = [(number, place) for number, place in places if max(p.stop - p.start for p in place) > largest]
    if not large:
        return out
    ribbon, gate = _between_walls(inside & (rate >= WALL), inside, largest)
    bare = inside & (local_rate(shut, expected, _BLUR / cell) < _EMPTY)
    for number, place in large:
        own = labels[place] == number
        if ribbon[place][own].mean() < 1.0 - BARS:
            out[place] |= own & ~_rectangles(bare[place] & gate[place])
    return out


def _between_walls(wall: Bool, inside: Bool, apart: int) -> tuple[Bool, Bool]:
    """Returns which cells (h, w) may belong to a ribbon window, and which to a gate.

    A ribbon has wall above and below, at most `apart` rows apart, and on one side. A gate has wall on both
    sides, at most `apart` columns apart, and above.
    """
    below, above = _to_wall(wall, inside), _to_wall(wall[::-1], inside[::-1])[::-1]
    left, right = _to_wall(wall.T, inside.T).T, _to_wall(wall.T[::-1], inside.T[::-1])[::-1].T
    ribbon = (below + above <= apart) & (np.minimum(left, right) < np.inf)
    return np.asarray(ribbon), np.asarray((left + right <= apart) & (above < np.inf))


def _rectangles(cells: Bool) -> Bool:
    """Returns the connected parts of the cells (h, w) that are rectangles, of which only bars may be missing.

    Columns that are less than half as high as the highest one do not belong to the rectangle.
    """
    labels, _ = ndimage.label(cells)
    out = np.zeros(cells.shape, np.bool_)
    for number, place in enumerate(ndimage.find_objects(labels), 1):
        own = labels[place] == number
        high = own.sum(0)
        column = np.flatnonzero(2 * high >= high.max())
        part = own[:, column[0] : column[-1] + 1]
        if part.mean() >= 1.0 - BARS:
            out[place][:, column[0] : column[-1] + 1] |= part
    return out


def _to_wall(wall: Bool, inside: Bool) -> Float:
    """Returns how many rows below each cell (h, w) the next wall is; infinity where the facade ends first."""
    row = np.arange(len(wall))[:, None]
    last, end = (np.maximum.accumulate(np.where(kind, row, -1), axis=0) for kind in (wall, ~inside))
    return np.where(last > end, row - last, np.inf)


def equal_share(low: float, high: float) -> float:
    """Returns the share of the expected beams at which Poisson counts with two means are equally likely.

    The means are the shares `low` and `high` of the expected beams.
    """
    return float((high - low) / np.log(high / low))


SHADED = equal_share(BARS, WALL)
"""Share of the expected beams from which wall in the shade is likelier than bars before an opening."""


def local_rate(values: Float, due: Float, finest: float) -> Float:
    """Returns the sum of the values (h, w) around every cell per expected beam (`due`).

    The surroundings are as small as ten expected beams allow, from `finest` cells on.
    """
    out, left = np.zeros(values.shape), np.ones(values.shape, np.bool_)
    for wide in finest * 2.0 ** np.arange(_SCALES):
        near = (
            left & (4.0 * np.pi * wide**2 * due >= BEAMS_TO_DECIDE)
            if wide < finest * 2 ** (_SCALES - 1)
            else left
        )
        if near.any():
            come, asked = (blurred(m, wide) for m in (values, due))
            come /= np.maximum(asked, 1e-9, out=asked)
            np.copyto(out, come, where=near)
        left &= ~near
    return out


def _unhidden(beams: Beams, raster: WallRaster, seen: Float, due: Float) -> Float:
    """Returns the share (h, w) of a cell's beams that nothing before the wall stops.

    With rays, the blocked beams and the others tell it. Without rays, nothing is expected in the shadows of
    fittings.
    """
    if beams.rays:
        stopped = averaged(raster.count(*beams.blocked.T))
        come = averaged(seen)
        return np.asarray(np.clip(1.0 - stopped / np.maximum(stopped + come, 1e-9), 0.0, 1.0))
    return np.asarray(1.0 - shadows_of_fittings(beams, raster, WALL * due))
