"""Finds the storeys of a building from its openings: the floor lines that explain their rows best.

A floor line crosses few openings; two openings above each other lie in two storeys; storeys have similar
heights; and a storey without openings is possible but rare. Each of these expectations has a cost, which
stands for a negative log-likelihood. Dynamic programming over the heights finds the cheapest lines for every
usual height of a storey. A gap of two storeys is therefore counted as two, and the windows of a staircase,
which every choice of lines crosses, do not move the lines.
"""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int

_STEP_M = 0.1  # grid of the floor lines
_HEIGHTS = np.arange(23, 76) * _STEP_M  # m, heights of a storey, from a low mezzanine to a hall with shops
_PITCHES = np.arange(24, 61) * _STEP_M  # m, candidates for the usual height of the storeys of a building
_USUAL_M = 3.1  # of a storey, over all buildings
# Standard deviations of the logarithm of a height: upper storeys, ground floor, usual height among buildings.
_SPREAD = (0.12, 0.25, 0.20)
_TALLER = 1.2  # height of the ground floor, with its shops and steps, over that of the upper storeys
_EMPTY = (1.5, 3.0, 4.5)  # costs of the first, the second and every further storey without openings
_CROSSED = 2.0  # cost of a line through an opening
_STACKED = 1.5  # cost of two openings above each other in one storey
_MARGIN_M = 0.1  # for errors of the borders and for sloping floors


@dataclass(frozen=True)
class Storeys:
    """Floor lines in ascending order: floor f lies between lines[f] and lines[f + 1] m.

    pitch  m, usual height of a storey
    """

    lines: tuple[float, ...]
    pitch: float

    def floor_of(self, z: Float) -> Int:
        """Returns the storeys (n,) int64 of heights z (n,) m; -1, -2, ... below the ground."""
        lines = np.array(self.lines)
        above = np.searchsorted(lines, z, "right") - 1
        over = np.floor((z - lines[-1]) / self.pitch).clip(0)
        under = -1 - np.floor((lines[0] - z) / self.pitch).clip(0)
        floor = np.where(z < lines[0], under, np.where(z >= lines[-1], len(lines) - 1 + over, above))
        return floor.astype(np.int64)

    def crossed(self, boxes: Float) -> Bool:
        """Which boxes (n, 4) are cut more than 0.3 m inside their edge by a line above the ground, (n,)."""
        cut: Bool = _depth_of_cuts(np.array(self.lines[1:]), boxes).max(0, initial=0.0) > 0.3
        return cut


def find_storeys(boxes: Float, sheet: Int, ground: float) -> Storeys:
    """Finds the storeys from openings without basement windows.

    boxes   (n, 4) m, x0, z0, x1, z1; n may be 0
    sheet   (n,) int64, numbers of the facades that hold them
    ground  m, height of the ground in the same z
    """
    above = boxes[:, 1::2].mean(1) > ground
    boxes, sheet = boxes[above], sheet[above]
    if not len(boxes):
        return Storeys((ground, ground + _TALLER * _USUAL_M), _USUAL_M)
    top = float(boxes[:, 3].max())
    steps = int(np.ceil((top - ground + _HEIGHTS[-1]) / _STEP_M))
    lines: Float = ground + _STEP_M * np.arange(steps + 1, dtype=np.float64)
    cost, chosen, before = _cheapest(*_interval_costs(lines, boxes, sheet))
    cost[:, :, lines < top - _MARGIN_M] = np.inf
    e, p, k = (int(i) for i in np.unravel_index(int(np.argmin(cost)), cost.shape))
    path = [k]
    while k > 0:
        e, k = int(before[e, p, k]), k - int(chosen[e, p, k])
        path.append(k)
    return Storeys(tuple(float(lines[k]) for k in reversed(path)), float(_PITCHES[p]))


def _depth_of_cuts(lines: Float, boxes: Float) -> Float:
    """Distance (k, n) m of each line from the nearer end of each box; negative outside the box."""
    depth: Float = np.minimum(lines[:, None] - boxes[:, 1], boxes[:, 3] - lines[:, None])
    return depth


def _interval_costs(lines: Float, boxes: Float, sheet: Int) -> tuple[Float, Bool]:
    """Returns the cost (h, k) of a storey of height _HEIGHTS[h] that ends at line k, and where it is empty.

    The cost is infinite where the storey would begin below the ground.
    """
    widths = np.rint(_HEIGHTS / _STEP_M).astype(np.int64)
    foot, head = boxes[:, 1], boxes[:, 3]
    middle = (foot + head) / 2
    crossed = _CROSSED * ((_depth_of_cuts(lines, boxes) - _MARGIN_M) / 0.3).clip(0, 1).sum(1)
    below, above, weight = _stacked(boxes, sheet)
    costs = np.full((len(widths), len(lines)), np.inf)
    empty = np.zeros(costs.shape, bool)
    for h, width in enumerate(widths):
        z0, z1 = lines[:-width, None], lines[width:, None]
        inside = (middle >= z0) & (middle < z1)
        lowest = np.where(inside, foot, np.inf).min(1) - lines[:-width]
        highest = lines[width:] - np.where(inside, head, -np.inf).max(1)
        # The floor lies at most 1.2 m below the windows; a lintel and a slab lie above them.
        apart = np.where(inside, foot, -np.inf).max(1) - np.where(inside, head, np.inf).min(1)
        seat = (lowest - 1.2).clip(0) + (0.3 - highest).clip(0) + (highest - 1.2).clip(0)
        seat += _STACKED * ((apart - 0.6) / 0.6).clip(0, 1)
        double = ((below >= z0) & (above < z1)) @ weight
        empty[h, width:] = ~inside.any(1)
        costs[h, width:] = crossed[width:] + np.where(empty[h, width:], 0.0, seat) + double
    return costs, empty


def _stacked(boxes: Float, sheet: Int) -> tuple[Float, Float, Float]:
    """Finds pairs of openings above each other that a floor should separate.

    Returns the middles of the lower and of the upper ones (m,) m and the cost (m,) of having both in one
    storey. A fanlight is close above its door; openings that are a person's height apart need a floor between
    them.
    """
    overlap = np.minimum(boxes[:, None, 2], boxes[:, 2]) - np.maximum(boxes[:, None, 0], boxes[:, 0])
    width = np.minimum(*np.meshgrid(*2 * [np.ptp(boxes[:, ::2], axis=1)]))
    middle = boxes[:, 1::2].mean(1)
    rise = middle[None, :] - middle[:, None]
    pair = (overlap > 0.5 * width) & (sheet[:, None] == sheet) & (rise > 1.8) & (rise < _HEIGHTS[-1])
    low, high = np.nonzero(pair)
    return middle[low], middle[high], _STACKED * ((rise[pair] - 1.8) / 0.6).clip(0, 1)


def _cheapest(costs: Float, empty: Bool) -> tuple[Float, Int, Int]:
    """Finds the cheapest storeys up to every line by dynamic programming.

    Returns three arrays (e, p, n), by the number of empty storeys so far (the last one: that many or more),
    the usual height and the line: the cost, the height of the last storey in steps, and the number of empty
    storeys before it.
    """
    shape = (len(_EMPTY), len(_PITCHES), costs.shape[1])
    widths = np.rint(_HEIGHTS / _STEP_M).astype(np.int64)
    upper = _prior(np.log(_HEIGHTS / _PITCHES[:, None]) / _SPREAD[0])
    first = _prior(np.log(_HEIGHTS / (_TALLER * _PITCHES[:, None])) / _SPREAD[1])
    best = np.full(shape, np.inf)
    chosen, before = np.zeros(shape, np.int64), np.zeros(shape, np.int64)
    best[0, :, 0] = _prior(np.log(_PITCHES / _USUAL_M) / _SPREAD[2])
    for k in range(int(widths[0]), shape[2]):
        h = np.flatnonzero(widths <= k)
        start = k - widths[h]
        total = best[:, :, start] + (costs[h, k] + np.where(start == 0, first[:, h], upper[:, h]))
        filled = np.where(empty[h, k], np.inf, total)
        bare = np.where(empty[h, k], total, np.inf) + np.array(_EMPTY)[:, None, None]
        for e in range(shape[0]):
            sources = [e, e - 1, e] if e == shape[0] - 1 else [e, e - 1]
            ways = np.concatenate([filled[e], *(bare[f] for f in sources[1:] if f >= 0)], axis=1)
            pick = np.argmin(ways, axis=1)
            best[e, :, k] = ways[np.arange(shape[1]), pick]
            chosen[e, :, k] = widths[h[pick % len(h)]]
            before[e, :, k] = np.array(sources)[pick // len(h)]
    return best, chosen, before


def _prior(normalised: Float) -> Float:
    """Huber's loss of deviations in sigmas, so that one odd storey does not distort the others."""
    size = np.abs(normalised)
    return np.where(size < 2, size**2 / 2, 2 * size - 2)
