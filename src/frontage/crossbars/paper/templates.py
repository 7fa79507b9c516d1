"""Templates of crossbars: recursive division of the window, tested against 3-D edges (B, section 3.3.2)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from frontage.crossbars.paper.triangulate import Edges3D
from frontage.geometry.arrays import Bool, Float
from frontage.geometry.ring import ring_contains

Box = tuple[float, float, float, float]
"""Left, lower, right and upper border m."""

HALF = 0.5
"""Share of a dividing line's length that carries edges, from which on the line is accepted."""

_STEP_M = 0.01  # between the dividing lines that are tried
_SAMPLES = 100  # places along a dividing line at which edges are looked for
_MOST = 8  # dividing lines tried per pane and direction, the best


@dataclass(frozen=True)
class Line:
    """A dividing line: axis 0 vertical, 1 horizontal; position m, from where to where m, share with edges."""

    axis: int
    position: float
    extent: tuple[float, float]
    support: float


@dataclass(frozen=True, eq=False)
class Support:
    """What speaks for dividing lines along one axis, at any place of the window.

    position  (m,) m of lines that may be tried
    along     (k,) m, places along them
    inside    (m, k) whether the window reaches there (arched heads end)
    edges     (m, k) share of the windows that have a 3-D edge there, within the buffer, 0..1
    close     (m, k) how close these edges lie to the line: largest in the middle of a bar's two edges
    """

    position: Float
    along: Float
    inside: Bool
    edges: Float
    close: Float

    def shares(self, low: float, high: float) -> tuple[Float, Float]:
        """Returns the share (m,) of each line with edges between two places m along, and their closeness."""
        part = self.inside & (self.along > low) & (self.along < high)
        count = np.maximum(part.sum(1), 1)
        share, close = (np.where(part, values, 0).sum(1) / count for values in (self.edges, self.close))
        return share, close


def support(windows: Sequence[Edges3D], ring: Float, axis: int, buffer: float) -> Support:
    """Returns what the 3-D edges of windows of one kind say of dividing lines along one axis.

    windows  the edges of each, relative to its own middle
    ring     (k, 2) m, their common outline about the middle
    buffer   m on both sides of a dividing line: bars are two edges, and scan and photos are slightly shifted
    """
    low, high = ring.min(0), ring.max(0)
    position = np.arange(low[axis] + _STEP_M / 2, high[axis], _STEP_M)
    edge = np.linspace(low[1 - axis], high[1 - axis], _SAMPLES + 1)
    along = (edge[1:] + edge[:-1]) / 2
    places = np.stack(np.meshgrid(position, along, indexing="ij"), -1).reshape(-1, 2)
    inside = ring_contains(ring, places if axis == 0 else places[:, ::-1]).reshape(len(position), -1)
    edges, close = np.zeros(inside.shape), np.zeros(inside.shape)
    for e in windows:
        away = np.abs(position[:, None] - e.across) / buffer
        there = ((e.along[:, :1] <= along) & (e.along[:, 1:] >= along)).astype(np.float32)
        edges += ((away <= 1).astype(np.float32) @ there) > 0
        close += np.clip(1 - away**2, 0, None).astype(np.float32) @ there
    count = max(sum(len(e) > 0 for e in windows), 1)
    return Support(position, along, inside, edges / count, close / count)


@dataclass(frozen=True)
class Division:
    """The dividing lines of a window, and the share with edges of the best one that was refused."""

    lines: tuple[Line, ...]
    refused: float


def divide(pane: Box, by: tuple[Support, Support], least: float, bar: float) -> Division:
    """Divides a pane and, recursively, its parts.

    Each step tries to divide the pane into two or three parts across and upwards, and accepts the template
    whose weakest dividing line carries the most edges, if these cover half of it. The recursion stops where a
    part would be narrower or lower than `least` m.

    bar  m, width of the bars that dividing lines stand for
    """
    lines = [line for axis in (0, 1) for line in _lines(pane, by, axis, least, bar)]
    best = max(_templates(lines, least, bar), key=_fit, default=None)
    if best is None:
        return Division((), max((line.support for line in lines), default=0.0))
    parts = [divide(part, by, least, bar) for part in _parts(pane, best, bar)]
    deeper = tuple(line for part in parts for line in part.lines)
    return Division(best + deeper, max(part.refused for part in parts))


def _fit(template: tuple[Line, ...]) -> tuple[float, int, float]:
    """Ranks templates: by the share of the weakest line to a tenth, the number of parts, the share."""
    weakest = min(line.support for line in template)
    return round(weakest, 1), len(template), weakest


def _templates(lines: Sequence[Line], least: float, bar: float) -> Iterator[tuple[Line, ...]]:
    """Yields the acceptable divisions into two and three parts by the dividing lines of one pane."""
    good = sorted((line for line in lines if line.support >= HALF), key=lambda o: (o.axis, o.position))
    yield from ((line,) for line in good)
    for a, b in combinations(good, 2):
        if a.axis == b.axis and b.position - a.position >= least + bar:
            yield a, b


def _lines(pane: Box, by: tuple[Support, Support], axis: int, least: float, bar: float) -> list[Line]:
    """Returns the best dividing lines of a pane along an axis; of lines too close together the better."""
    room = least + bar / 2
    low, high = pane[axis] + room, pane[axis + 2] - room
    extent = (pane[1 - axis], pane[3 - axis])
    if low > high:
        return []
    position = by[axis].position
    share, close = by[axis].shares(*extent)
    share = np.where((position >= low) & (position <= high), share, 0.0)
    order = np.lexsort((-close, -np.round(share, 1)))
    found: list[Line] = []
    for k in order[: np.count_nonzero(share > 0)]:
        if all(abs(position[k] - line.position) >= least + bar for line in found):
            found.append(Line(axis, float(position[k]), extent, float(share[k])))
        if len(found) == _MOST:
            break
    return found


def _parts(pane: Box, template: tuple[Line, ...], bar: float) -> list[Box]:
    """Returns the panes that dividing lines, ascending and along one axis, leave of a pane."""
    axis = template[0].axis
    lows = [pane[axis], *(line.position + bar / 2 for line in template)]
    highs = [*(line.position - bar / 2 for line in template), pane[axis + 2]]
    if axis == 0:
        return [(a, pane[1], b, pane[3]) for a, b in zip(lows, highs, strict=True)]
    return [(pane[0], a, pane[2], b) for a, b in zip(lows, highs, strict=True)]


def joined(lines: Sequence[Line], gap: float) -> list[Line]:
    """Joins dividing lines that go on in the next pane: at most `gap` m apart along and half of it across."""
    out: list[Line] = []
    for line in sorted(lines, key=lambda o: (o.axis, o.extent)):
        before = next((o for o in out if _continues(o, line, gap)), None)
        if before is None:
            out.append(line)
            continue
        a, b = (o.extent[1] - o.extent[0] for o in (before, line))
        middle = (a * before.position + b * line.position) / (a + b)
        share = (a * before.support + b * line.support) / (a + b)
        out[out.index(before)] = Line(line.axis, middle, (before.extent[0], line.extent[1]), share)
    return out


def _continues(a: Line, b: Line, gap: float) -> bool:
    near = a.axis == b.axis and abs(a.position - b.position) <= gap / 2
    return near and -1e-9 <= b.extent[0] - a.extent[1] <= gap
