"""Evidence of open against solid, cell by cell."""

from dataclasses import dataclass

import numpy as np
import shapely
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float, freeze
from frontage.model.facade import Facade
from frontage.openings.beams import Beams, Raster

_FINEST = 0.02  # m, least side of a cell
_PER_CELL = 2.0  # spacings a cell is wide: four beams on average
_AROUND = 0.5  # m, one sigma of the surroundings that tell how many beams to expect
_HIT = np.log(0.97 / 0.12)  # nats: bars and frames level with the wall return 12 % of a window's beams
_LOST = 0.85  # nats per expected beam that did not come: 0.97 - 0.12 of the Poisson means
_MOST_LOST = 1.0  # nats a cell: no more, for shadows leave cells empty as well
_THROUGH = np.log(0.88 / 0.03)  # nats: 3 % of the beams on a wall seem to end behind it
_BEHIND = 1.0  # nats: a point behind the wall whose line of sight is not known
_CAP = 6.0  # nats a cell: neighbouring beams err together
_BLUR = 0.1  # m, one sigma to tell empty areas
_EMPTY = 0.1  # share of the expected beams below which an area is empty
_LARGE = 4.0  # m: openings without any return are smaller
_CUT = 0.05  # share of the solid density around, below which nothing is expected


@dataclass(frozen=True, eq=False)
class Evidence:
    """Maps (h, w) on `raster`, row 0 the lowest.

    llr       nats, open against solid; 0 = nothing known
    solid     beams that ended on the wall; open: that went through; expected: of a wall, from around;
              due: were nothing before it
    seen      cells that some beam tells of
    inside    cells within the outline
    """

    raster: Raster
    llr: Float
    solid: Float
    open: Float
    expected: Float
    due: Float
    seen: Bool
    inside: Bool

    def __post_init__(self) -> None:
        freeze(self, llr=((None, None), np.float64), inside=((None, None), np.bool_))


def weigh(facade: Facade, beams: Beams) -> Evidence:
    """The evidence of every cell: hits against it, beams through it for it, missing beams for it.

    Hits of a wall are Poisson with the mean that the surroundings show, those of an opening with 12 % of it.
    Cells that a fitting or an occluder hides expect nothing. A beam through counts wherever it is known to be
    one; a mere point behind the wall only where the wall itself is missing (rooms are scanned too).
    """
    raster = Raster.over(facade, max(_PER_CELL * facade.spacing, _FINEST))
    solid, open_ = raster.count(*beams.solid.T), raster.count(*beams.open.T)
    inside = _inside(facade, raster)
    due = _expected(solid, raster.cell)
    expected = due * _unhidden(beams, raster, solid + open_)
    expected = np.where(_unwatched(solid + open_, expected, inside, raster.cell), 0.0, expected)
    lost = np.minimum(_LOST * expected, _MOST_LOST)
    through = (_THROUGH if beams.rays else _BEHIND) * open_
    if not beams.rays:
        through *= ndimage.uniform_filter(solid, 3) < np.maximum(0.3 * expected, 1e-9)
    llr = np.clip(lost - _HIT * solid + through, -_CAP, _CAP)
    return Evidence(
        raster, np.where(inside, llr, 0.0), solid, open_, expected, due, solid + open_ > 0, inside
    )


def _inside(facade: Facade, raster: Raster) -> Bool:
    h, w = raster.shape
    x = raster.corner[0] + (np.arange(w) + 0.5) * raster.cell
    z = raster.corner[1] + (np.arange(h) + 0.5) * raster.cell
    polygon = shapely.make_valid(shapely.Polygon(facade.outline))
    gx, gz = np.meshgrid(x, z)
    return np.asarray(shapely.contains_xy(polygon, gx.ravel(), gz.ravel())).reshape(h, w)


def _expected(solid: Float, cell: float) -> Float:
    """Beams (h, w) that a piece of wall would catch: Poisson mean of the cells with hits around it."""
    wide = _AROUND / cell
    held = ndimage.gaussian_filter((solid > 0).astype(np.float64), wide, mode="constant", truncate=3.0)
    mean = ndimage.gaussian_filter(solid, wide, mode="constant", truncate=3.0) / np.maximum(held, 1e-9)
    # the mean of cells with a hit is lam / (1 - exp(-lam)): inverted
    lam = np.geomspace(1e-3, 1e4, 400)
    found = np.interp(mean, lam / -np.expm1(-lam), lam)
    return np.where(held > _CUT, found, 0.0)


def _unwatched(seen: Float, expected: Float, inside: Bool, cell: float) -> Bool:
    """Cells (h, w) beyond the end of what was scanned: empty areas too large for an opening."""
    blur = _BLUR / cell
    come, due = ndimage.gaussian_filter(seen, blur), ndimage.gaussian_filter(expected, blur)
    empty = inside & (come < _EMPTY * np.maximum(due, 1e-9))
    labels, _ = ndimage.label(empty)
    out = np.zeros(seen.shape, np.bool_)
    for number, place in enumerate(ndimage.find_objects(labels), 1):
        if max(p.stop - p.start for p in place) * cell > _LARGE:
            out[place] |= labels[place] == number
    return out


def _unhidden(beams: Beams, raster: Raster, seen: Float) -> Float:
    """Share (h, w) of a cell's beams that nothing before the wall stops.

    With rays: blocked beams against the others. Without: nothing is expected within a fitting's own
    projection of it, for it throws its shadow there, whatever the sensor's place below 45 degrees.
    """
    if beams.rays:
        stopped = ndimage.uniform_filter(raster.count(*beams.blocked.T), 3)
        come = ndimage.uniform_filter(seen, 3)
        return np.asarray(1.0 - stopped / np.maximum(stopped + come, 1e-9))
    return 1.0 - _shadow(beams, raster)


def _shadow(beams: Beams, raster: Raster) -> Float:
    """1 where something before the wall, at most 1.5 m, may throw a shadow: above and below it, as far as it
    stands out.
    """
    out = np.zeros(raster.shape)
    depth = -beams.front[:, 2]
    for near in (0.3, 0.6, 1.0):
        some = (depth >= near) & (depth < near + 0.5)
        held = raster.count(*beams.front[some, :2].T) > 0
        held = ndimage.binary_opening(held, np.ones((1, 3), np.bool_))
        reach = max(int((near + 0.2) / raster.cell), 1)
        out = np.maximum(out, ndimage.maximum_filter1d(held.astype(np.float64), 2 * reach + 1, axis=0))
    return out
