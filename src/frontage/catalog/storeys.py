"""Storeys of a building from its openings: the floor lines that explain their rows best.

A floor line crosses few openings, two openings above each other lie in two storeys, storeys have much the
same height, and one without openings is possible but rare. These costs are log-likelihoods of a plain kind;
dynamic programming over heights finds the cheapest lines for every storey height at once, so that a gap of
two storeys counts as two, and windows of a staircase, which every line crosses, do not move the lines.
"""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int

_STEP = 0.1  # m, grid of the floor lines
_HEIGHTS = np.arange(23, 76) * _STEP  # m, of a storey: the lowest mezzanine to a hall with shops
_PITCHES = np.arange(24, 61) * _STEP  # m, usual height of the building's storeys
_USUAL = 3.1  # m
_SPREAD = (0.12, 0.25, 0.20)  # of the logarithm: upper storeys, ground floor, usual height among buildings
_TALLER = 1.2  # ground floor to upper storeys: shops, and the steps up to it
_EMPTY = (1.5, 3.0, 4.5)  # cost of the first storey without openings, the second, and each that follows
_CROSSED = 2.0  # cost of a line through an opening
_STACKED = 1.5  # cost of two openings above each other in one storey
_MARGIN = 0.1  # m, borders err and floors lean


@dataclass(frozen=True)
class Storeys:
    """Floor lines, rising: floor f lies between lines[f] and lines[f + 1] (m); pitch = usual height, m."""

    lines: tuple[float, ...]
    pitch: float

    def floor_of(self, z: Float) -> Int:
        """The storeys (n,) that hold heights z (n,) m; -1, -2, ... below the ground."""
        lines = np.array(self.lines)
        above = np.searchsorted(lines, z, "right") - 1
        over = np.floor((z - lines[-1]) / self.pitch).clip(0)
        under = -1 - np.floor((lines[0] - z) / self.pitch).clip(0)
        floor = np.where(z < lines[0], under, np.where(z >= lines[-1], len(lines) - 1 + over, above))
        return floor.astype(np.int64)

    def crossed(self, boxes: Float) -> Bool:
        """Which boxes (n, 4) a line above the ground cuts well inside (n,)."""
        cut: Bool = _depth_of_cuts(np.array(self.lines[1:]), boxes).max(0, initial=0.0) > 0.3
        return cut


def find_storeys(boxes: Float, sheet: Int, ground: float) -> Storeys:
    """The storeys of openings with boxes (n, 4) m (x0, z0, x1, z1) on facades `sheet` (n,).

    ground is the height of the ground in the same z, m. Basement windows are to be left out. n may be 0.
    """
    above = boxes[:, 1::2].mean(1) > ground
    boxes, sheet = boxes[above], sheet[above]
    if not len(boxes):
        return Storeys((ground, ground + _TALLER * _USUAL), _USUAL)
    top = float(boxes[:, 3].max())
    steps = int(np.ceil((top - ground + _HEIGHTS[-1]) / _STEP))
    lines: Float = ground + _STEP * np.arange(steps + 1, dtype=np.float64)
    cost, chosen, before = _cheapest(*_interval_costs(lines, boxes, sheet))
    cost[:, :, lines < top - _MARGIN] = np.inf
    e, p, k = (int(i) for i in np.unravel_index(int(np.argmin(cost)), cost.shape))
    path = [k]
    while k > 0:
        e, k = int(before[e, p, k]), k - int(chosen[e, p, k])
        path.append(k)
    return Storeys(tuple(float(lines[k]) for k in reversed(path)), float(_PITCHES[p]))


def _depth_of_cuts(lines: Float, boxes: Float) -> Float:
    """How far inside a box each line runs (k, n), m; negative outside."""
    depth: Float = np.minimum(lines[:, None] - boxes[:, 1], boxes[:, 3] - lines[:, None])
    return depth


def _interval_costs(lines: Float, boxes: Float, sheet: Int) -> tuple[Float, Bool]:
    """Cost (h, k) of a storey of height _HEIGHTS[h] that ends at line k, and whether it has no opening.

    inf where it would begin below the ground.
    """
    widths = np.rint(_HEIGHTS / _STEP).astype(np.int64)
    foot, head = boxes[:, 1], boxes[:, 3]
    middle = (foot + head) / 2
    crossed = _CROSSED * ((_depth_of_cuts(lines, boxes) - _MARGIN) / 0.3).clip(0, 1).sum(1)
    below, above, weight = _stacked(boxes, sheet)
    costs = np.full((len(widths), len(lines)), np.inf)
    empty = np.zeros(costs.shape, bool)
    for h, width in enumerate(widths):
        z0, z1 = lines[:-width, None], lines[width:, None]
        inside = (middle >= z0) & (middle < z1)
        lowest = np.where(inside, foot, np.inf).min(1) - lines[:-width]
        highest = lines[width:] - np.where(inside, head, -np.inf).max(1)
        # A floor lies within arm's reach below the windows, a lintel and a slab above them.
        apart = np.where(inside, foot, -np.inf).max(1) - np.where(inside, head, np.inf).min(1)
        seat = (lowest - 1.2).clip(0) + (0.3 - highest).clip(0) + (highest - 1.2).clip(0)
        seat += _STACKED * ((apart - 0.6) / 0.6).clip(0, 1)
        double = ((below >= z0) & (above < z1)) @ weight
        empty[h, width:] = ~inside.any(1)
        costs[h, width:] = crossed[width:] + np.where(empty[h, width:], 0.0, seat) + double
    return costs, empty


def _stacked(boxes: Float, sheet: Int) -> tuple[Float, Float, Float]:
    """Pairs of openings above each other: middle of the lower and the upper (m,) m, cost (m,) of one storey.

    A fanlight over its door is near; what is a person's height apart needs a floor.
    """
    overlap = np.minimum(boxes[:, None, 2], boxes[:, 2]) - np.maximum(boxes[:, None, 0], boxes[:, 0])
    width = np.minimum(*np.meshgrid(*2 * [np.ptp(boxes[:, ::2], axis=1)]))
    middle = boxes[:, 1::2].mean(1)
    rise = middle[None, :] - middle[:, None]
    pair = (overlap > 0.5 * width) & (sheet[:, None] == sheet) & (rise > 1.8) & (rise < _HEIGHTS[-1])
    low, high = np.nonzero(pair)
    return middle[low], middle[high], _STACKED * ((rise[pair] - 1.8) / 0.6).clip(0, 1)


def _cheapest(costs: Float, empty: Bool) -> tuple[Float, Int, Int]:
    """Per number of empty storeys so far (its last: that many or more), usual height and line (e, p, n): the
    cost of the cheapest storeys up to it, the steps of the last one, and the number before it.
    """
    shape = (len(_EMPTY), len(_PITCHES), costs.shape[1])
    widths = np.rint(_HEIGHTS / _STEP).astype(np.int64)
    upper = _prior(np.log(_HEIGHTS / _PITCHES[:, None]) / _SPREAD[0])
    first = _prior(np.log(_HEIGHTS / (_TALLER * _PITCHES[:, None])) / _SPREAD[1])
    best = np.full(shape, np.inf)
    chosen, before = np.zeros(shape, np.int64), np.zeros(shape, np.int64)
    best[0, :, 0] = _prior(np.log(_PITCHES / _USUAL) / _SPREAD[2])
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
    """Huber's cost of deviations in sigmas: one odd storey must not bend the others."""
    size = np.abs(normalised)
    return np.where(size < 2, size**2 / 2, 2 * size - 2)
