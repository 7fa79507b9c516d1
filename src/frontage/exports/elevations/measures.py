"""The levels and dimensions of an elevation."""

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from frontage.exports.survey import SurveyedBuilding, heights
from frontage.geometry.arrays import Float
from frontage.geometry.ring import box_sigmas
from frontage.io.drawings.elevation import Dimension, Level, Sheet
from frontage.model import Elements, Facade, Opening

_FIRST_MM, _NEXT_MM = 9.0, 8.0  # on paper, from the facade to the first dimension line and between lines
_LEVEL_SIGMA_M = 0.025  # a border known worse says nothing of a level that is given to the centimetre


def levels(building: SurveyedBuilding, facade: Facade, found: Elements) -> tuple[Level, ...]:
    """Return the levels, from below: the ground, thresholds, sills and heads of every floor, the top.

    Floors themselves cannot be seen from the street. A sill or head is the median of those on its floor whose
    borders are known to 2.5 cm.
    """
    marks = [] if building.ground is None else [Level("ground", building.ground)]
    for floor in sorted({o.floor for o in found.openings}):
        own = [o for o in found.openings if o.floor == floor]
        doors, windows = [o for o in own if o.kind.at_ground], [o for o in own if not o.kind.at_ground]
        marks += _level(f"threshold, floor {floor}", facade, found, doors, 1)
        marks += _level(f"sill, floor {floor}", facade, found, windows, 1)
        marks += _level(f"head, floor {floor}", facade, found, windows or doors, 3)
    marks.append(Level("top of wall", float(heights(facade, facade.outline).max())))
    return tuple(sorted(marks, key=lambda level: level.height))


def _level(name: str, facade: Facade, found: Elements, openings: Iterable[Opening], side: int) -> list[Level]:
    """Return the median height of one side (1 = lower, 3 = upper) of openings, if any knows it well."""
    known = [o for o in openings if box_sigmas(o.ring, o.ring_covariance)[side] <= _LEVEL_SIGMA_M]
    if not known:
        return []
    extreme = np.min if side == 1 else np.max
    return [Level(name, float(np.median([extreme(heights(facade, o.ring, found.wall_y(o))) for o in known])))]


def dimensions(
    facade: Facade, found: Elements, zero: float, bounds: tuple[float, float, float, float], sheet: Sheet
) -> tuple[Dimension, ...]:
    """Return chains below (lowest floor, and the fullest other one) and on the left, and overall sizes.

    zero    m, height of z = 0 of the facade frame
    bounds  x0, h0, x1, h1 m of what is drawn
    """
    x0, h0, _, _ = bounds
    left, low, right, high = facade.extent
    low, high = low + zero, high + zero
    across = [_across(floor) for floor in _floors(found.openings)]
    made: list[Dimension] = []
    for k, ends in enumerate([*across, []]):
        at = h0 - sheet.metres(_FIRST_MM + k * _NEXT_MM)
        stops = _stops([left, *ends, right])
        made += [Dimension("x", (a, low), (b, low), at) for a, b in pairwise(stops)]
    column = _column(found.openings)
    ups = [[v + zero for o in column for v in (o.ring[:, 1].min(), o.ring[:, 1].max())], []]
    for k, ends in enumerate(ups if column else ups[1:]):
        at = x0 - sheet.metres(_FIRST_MM + k * _NEXT_MM)
        stops = _stops([low, *ends, high])
        made += [Dimension("h", (left, a), (left, b), at) for a, b in pairwise(stops)]
    return tuple(made)


def _floors(openings: Sequence[Opening]) -> list[list[Opening]]:
    """Return the openings of the lowest floor, and of the other one that has most of them."""
    floors = {
        floor: [o for o in openings if o.floor == floor] for floor in sorted({o.floor for o in openings})
    }
    if len(floors) < 2:
        return list(floors.values())
    lowest, *others = floors.values()
    return [lowest, max(others, key=len)]


def _across(openings: Sequence[Opening]) -> list[float]:
    return [float(v) for o in openings for v in (o.ring[:, 0].min(), o.ring[:, 0].max())]


def _column(openings: Sequence[Opening]) -> list[Opening]:
    """Return the leftmost of the bays that have most openings."""
    bays = sorted({o.bay for o in openings})
    counts = {bay: [o for o in openings if o.bay == bay] for bay in bays}
    return max(counts.values(), key=len, default=[])


def _stops(values: Sequence[float] | Float) -> list[float]:
    """Return where a chain stops: sorted, without stops closer than 1 mm."""
    stops: list[float] = []
    for value in sorted(float(v) for v in values):
        if not stops or value - stops[-1] > 1e-3:
            stops.append(value)
    return stops
