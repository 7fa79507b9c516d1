"""Evidence of open against solid, cell by cell."""

from dataclasses import dataclass

import numpy as np
import shapely
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float, freeze
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY
from frontage.openings.wall.beams import Beams, Raster
from frontage.openings.wall.expected import blurred, expected_beams

_FINEST = 0.02  # m, least side of a cell
_COARSEST = MASONRY.half_brick  # m, largest side of a cell: the least pier
_PER_CELL = 2.0  # spacings a cell is wide: four beams on average
_HIT = np.log(0.97 / 0.12)  # nats: bars and frames level with the wall return 12 % of a window's beams
_LOST = 0.85  # nats per expected beam that did not come: 0.97 - 0.12 of the Poisson means
_MOST_LOST = 1.0  # nats a cell: no more, for shadows leave cells empty as well
_THROUGH = np.log(0.88 / 0.03)  # nats: 3 % of the beams on a wall seem to end behind it
_BEHIND = 1.0  # nats: a point behind the wall whose line of sight is not known
_CAP = 6.0  # nats a cell: neighbouring beams err together
_RELIEF = 0.05  # m: panels and courses of a wall are less deep
_SCALES = 4  # times that the surroundings of a cell are doubled
_BLUR = 0.1  # m, one sigma to tell empty areas
_EMPTY = 0.1  # share of the expected beams below which an area is empty
_LARGE = 4.0  # m: openings without any return are smaller
ENOUGH = 10.0
"""Beams that a decision needs: it is wrong once in a thousand then."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """Maps (h, w) on `raster`, row 0 the lowest.

    llr       nats, open against solid; 0 = nothing known
    solid     beams that ended on the wall; open: that went through; deep: well behind the relief of a wall
    expected  beams of a wall, from around; due: were nothing before it
    seen      cells that some beam tells of
    inside    cells within the outline
    rays      whether the lines of sight are known
    """

    raster: Raster
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


def weigh(facade: Facade, beams: Beams) -> Evidence:
    """The evidence of every cell: hits against it, beams through it for it, missing beams for it.

    Hits of a wall are Poisson with the mean that the surroundings show, those of an opening with 12 % of it.
    Cells that a fitting or an occluder hides expect nothing. A beam through counts wherever it is known to be
    one; a mere point behind the wall only where the wall itself is missing (rooms are scanned too).
    """
    raster = Raster.over(facade, min(max(_PER_CELL * facade.spacing, _FINEST), _COARSEST))
    solid, open_ = raster.count(*beams.solid.T), raster.count(*beams.open.T)
    inside = _inside(facade, raster)
    due = expected_beams(beams.solid, raster)
    expected = due * _unhidden(beams, raster, solid + open_)
    expected = np.where(_unwatched(solid + open_, expected, inside, raster.cell), 0.0, expected)
    through = (_THROUGH if beams.rays else _BEHIND) * open_
    if not beams.rays:
        through *= ndimage.uniform_filter(solid, 3) < np.maximum(0.3 * expected, 1e-9)
    llr = np.where(inside, balance(expected, solid, through), 0.0)
    seen = solid + open_ > 0
    deep = raster.count(*beams.open[beams.open_depth > max(_RELIEF, 2.0 * beams.least)].T)
    return Evidence(raster, llr, solid, open_, deep, expected, due, seen, inside, beams.rays)


def balance(expected: Float, solid: Float, through: Float) -> Float:
    """Nats (h, w) for open: of beams missing and those on the wall, and `through` of those beyond it."""
    lost = np.minimum(_LOST * expected, _MOST_LOST)
    return np.asarray(np.clip(lost - _HIT * solid + through, -_CAP, _CAP))


def _inside(facade: Facade, raster: Raster) -> Bool:
    h, w = raster.shape
    x = raster.corner[0] + (np.arange(w) + 0.5) * raster.cell
    z = raster.corner[1] + (np.arange(h) + 0.5) * raster.cell
    polygon = shapely.make_valid(shapely.Polygon(facade.outline))
    gx, gz = np.meshgrid(x, z)
    return np.asarray(shapely.contains_xy(polygon, gx.ravel(), gz.ravel())).reshape(h, w)


def _unwatched(seen: Float, expected: Float, inside: Bool, cell: float) -> Bool:
    """Cells (h, w) beyond the end of what was scanned: empty areas too large for an opening."""
    out = np.zeros(seen.shape, np.bool_)
    labels, _ = ndimage.label(inside & (enough(seen, expected, _BLUR / cell) < _EMPTY))
    for number, place in enumerate(ndimage.find_objects(labels), 1):
        if max(p.stop - p.start for p in place) * cell > _LARGE:
            out[place] |= labels[place] == number
    return out


def enough(values: Float, due: Float, finest: float) -> Float:
    """Sum of the values (h, w) around every cell per beam due there: from as near as ten beams are due."""
    out, left = np.zeros(values.shape), np.ones(values.shape, np.bool_)
    for wide in finest * 2.0 ** np.arange(_SCALES):
        near = left & (4.0 * np.pi * wide**2 * due >= ENOUGH) if wide < finest * 2 ** (_SCALES - 1) else left
        if near.any():
            come, asked = (blurred(m, wide) for m in (values, due))
            out = np.where(near, come / np.maximum(asked, 1e-9), out)
        left &= ~near
    return out


def _unhidden(beams: Beams, raster: Raster, seen: Float) -> Float:
    """Share (h, w) of a cell's beams that nothing before the wall stops.

    With rays: blocked beams against the others. Without: nothing is expected within a fitting's own
    projection of it, for it throws its shadow there, whatever the sensor's place below 45 degrees.
    """
    if beams.rays:
        stopped = ndimage.uniform_filter(raster.count(*beams.blocked.T), 3)
        come = ndimage.uniform_filter(seen, 3)
        return np.asarray(np.clip(1.0 - stopped / np.maximum(stopped + come, 1e-9), 0.0, 1.0))
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
