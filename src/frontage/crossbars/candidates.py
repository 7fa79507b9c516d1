"""Where bars of a window may lie: the lines of the evidence that any pane may want."""

from dataclasses import dataclass

import numpy as np

from frontage.crossbars.lines import MULLIONS_M, Bars
from frontage.geometry.arrays import Array, Float

COST = 9.0  # nats of a bar: its position and width, the direction of the split, the choice among candidates
EQUAL = 3.0  # nats less for a bar whose position follows from equal panes
MULLION = 6.0  # nats more for a bar as wide as a mullion between coupled windows
MOST_LINES = 11  # candidates per axis
ENDS_M = 0.01  # at both ends of a bar, where other bars cross
MOVE_M = 0.02  # by which a line may move when it is estimated again within one pane
_MEETING = (0.3, 0.7)  # share of a window's height at which its sashes meet
_RAIL_M = 0.02  # half a meeting rail
_MOST_RAILS = 2  # that are tried, the strongest


Box = tuple[float, float, float, float]
"""x0, z0, x1, z1 m of a pane."""


def candidates(box: Box, bars: Bars, least: tuple[float, float], cost: float) -> Float:
    """Returns the positions (k,) m of the lines that any pane may want, the strongest first.

    A line counts by its best piece among the whole length and its parts.

    least  m, least width and height of a pane
    """
    low, high = box[1 - bars.axis], box[3 - bars.axis]
    best = np.full(bars.total.shape[1:], -np.inf, np.float32)
    for parts in (1, 2, 3, 4, 6):
        size = (high - low) / parts
        if parts > 1 and size < least[1 - bars.axis]:
            break
        for first in np.arange(low, high - size + 1e-6, size / 2):
            best = np.maximum(best, bars.over(first + ENDS_M, first + size - ENDS_M))
    best = best - _mullion_cost(bars)
    strength = best.max(1)
    centre = bars.centre(np.arange(len(strength)), best.argmax(1))
    edge = least[bars.axis] / 2
    inside = (centre > box[bars.axis] + edge) & (centre < box[2 + bars.axis] - edge)
    strength = np.where(inside, strength, -np.inf)
    places: list[float] = []
    for k in np.argsort(-strength, kind="stable"):
        if strength[k] < cost - EQUAL or len(places) == MOST_LINES:
            break
        if all(abs(centre[k] - p) > 2.2 * MOVE_M for p in places):
            places.append(float(centre[k]))
    return np.array(places)


def _mullion_cost(bars: Bars) -> Array:
    return np.where(bars.widths * bars.px > MULLIONS_M[0], MULLION, 0.0).astype(np.float32)


@dataclass(frozen=True, eq=False)
class Place:
    """Where a candidate may lie: rows of the evidence, with centres and costs (r, w) of bars there."""

    rows: slice
    centre: Array
    cost: Array

    @staticmethod
    def near(bars: Bars, place: float) -> "Place":
        """The rows about a place m; bars that lie farther from it cost too much."""
        first, last = bars.rows(place, MOVE_M)
        centre = bars.centres(first, last)
        cost = np.where(np.abs(centre - place) <= MOVE_M, _mullion_cost(bars), np.inf)
        return Place(slice(first, last), centre, cost)


def meeting_places(box: Box, rail: Bars, least: float) -> Float:
    """Returns the heights (k,) m, in the middle of a window, below which a lower sash may hang.

    rail  the evidence of transoms that reach from the plane of one sash to that of the other
    """
    places = candidates(box, rail, (least, least), COST)
    share = (places - box[1]) / (box[3] - box[1])
    return np.asarray(places[(share > _MEETING[0]) & (share < _MEETING[1])][:_MOST_RAILS] - _RAIL_M)
