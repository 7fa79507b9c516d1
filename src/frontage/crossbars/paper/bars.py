"""Crossbars from accepted dividing lines and the 3-D edges beside them (paper B, end of section 3.3.2)."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from frontage.crossbars.paper.templates import Line
from frontage.crossbars.paper.triangulate import Edges3D
from frontage.model.estimate import Provenance
from frontage.model.glazing import AXES, Bar

BAR_WIDTH_M = 0.045
"""Usual width of a window bar, where only one of its edges was found."""

WIDEST_M = 0.15
"""Width of the widest bar: the stiles of two casements that meet."""

_WIDTH_SIGMA_M = 0.02  # of the usual width
_GAP_M = 0.005  # between edges of one place: more than the error of triangulated edges


@dataclass(frozen=True)
class _Place:
    """Where a window has a bar: position and width m with their standard errors."""

    position: float
    sigma: float
    width: float
    sigma_width: float


@dataclass(frozen=True)
class _Peak:
    """Edges that lie at one place: m, standard error of one of them, sum of contrast times length.

    side  +1 where the picture gets brighter in positive direction, else -1
    """

    at: float
    sigma: float
    strength: float
    side: int


@dataclass(frozen=True)
class _Pair:
    """Two edges that may be those of a bar: where the picture gets darker, and where it gets brighter."""

    darker: _Peak
    brighter: _Peak

    @property
    def strength(self) -> float:
        """Contrast times length of the weaker edge."""
        return min(self.darker.strength, self.brighter.strength)

    @property
    def lightness(self) -> float:
        """The strength, positive for a bar lighter than what is behind it, negative for a darker one."""
        return float(np.copysign(self.strength, self.darker.at - self.brighter.at))

    @property
    def place(self) -> _Place:
        """The bar between the edges."""
        a, b = self.darker, self.brighter
        error = float(np.hypot(a.sigma, b.sigma))
        return _Place((a.at + b.at) / 2, error / 2, abs(b.at - a.at), error)


def bars_of_group(
    lines: Sequence[Line], windows: Sequence[tuple[Edges3D, Edges3D]], buffer: float
) -> list[list[Bar]]:
    """Returns the bars of each window of a group, relative to its own middle.

    windows  vertical and horizontal 3-D edges of each, relative to its own middle
    buffer   m on both sides of a dividing line

    The bars of a group are all lighter or all darker than what is behind them, so that the shaded underside
    of a light bar is not taken for a bar. A window whose own edges do not show a bar gets it from the others
    of its group, with the provenance "pooled".
    """
    peaks = [[_peaks(line, edges[line.axis]) for edges in windows] for line in lines]
    pairs = [[_pairs(line, own, buffer) for own in row] for line, row in zip(lines, peaks, strict=True)]
    lightness = sum(max(own, key=lambda p: p.strength).lightness for row in pairs for own in row if own)
    out: list[list[Bar]] = [[] for _ in windows]
    for line, row, own_pairs in zip(lines, peaks, pairs, strict=True):
        places = _places(line, row, own_pairs, lightness, buffer)
        common = _pooled(line, [place for place in places if place is not None])
        for bars, place in zip(out, places, strict=True):
            p = common if place is None else place
            provenance = Provenance.POOLED if place is None else Provenance.MEASURED
            axis = AXES[line.axis]
            bars.append(Bar(axis, p.position, line.extent, p.width, p.sigma, p.sigma_width, provenance))
    for bars in out:
        bars.sort(key=lambda bar: (AXES.index(bar.axis), bar.position))
    return out


def _peaks(line: Line, edges: Edges3D) -> list[_Peak]:
    """Returns the places where 3-D edges of one sign lie beside a line: runs without a gap of 5 mm.

    Edges of several pairs of photos share their photos: the error is that of one edge, not of their mean.
    """
    low, high = line.extent
    beside = np.minimum(edges.along[:, 1], high) - np.maximum(edges.along[:, 0], low)
    strength = np.clip(beside, 0, None) * np.abs(edges.contrast)
    near = (strength > 0) & (np.abs(edges.across - line.position) <= WIDEST_M)
    found: list[_Peak] = []
    for side in (-1, 1):
        order = np.flatnonzero(near & (side * edges.contrast > 0))
        order = order[np.argsort(edges.across[order], kind="stable")]
        for run in np.split(order, np.flatnonzero(np.diff(edges.across[order]) > _GAP_M) + 1):
            if len(run):
                at = float(np.average(edges.across[run], weights=strength[run]))
                found.append(
                    _Peak(at, float(np.median(edges.sigma[run, 0])), float(strength[run].sum()), side)
                )
    return found


def _pairs(line: Line, peaks: Sequence[_Peak], buffer: float) -> list[_Pair]:
    """Returns the pairs of edges of opposite contrast about a dividing line, one of them in its buffer."""
    pairs = [_Pair(a, b) for a in peaks for b in peaks if a.side < b.side]
    return [
        pair
        for pair in pairs
        if pair.place.width <= WIDEST_M
        and min(abs(peak.at - line.position) for peak in (pair.darker, pair.brighter)) <= buffer
        and abs(pair.place.position - line.position) <= WIDEST_M / 2
    ]


def _places(
    line: Line, peaks: Sequence[list[_Peak]], pairs: Sequence[list[_Pair]], lightness: float, buffer: float
) -> list[_Place | None]:
    """Returns where each window shows a line: between two edges, or beside one; None where it has no edge."""
    out: list[_Place | None] = []
    for own in pairs:
        alike = [pair for pair in own if pair.lightness * lightness > 0]
        out.append(max(alike, key=lambda pair: pair.strength).place if alike else None)
    width, sigma = _width([place for place in out if place is not None])
    for k, own_peaks in enumerate(peaks):
        near = [peak for peak in own_peaks if abs(peak.at - line.position) <= buffer]
        if out[k] is None and near:
            best = max(near, key=lambda peak: peak.strength)
            # At the lower edge of a light bar the picture gets brighter: the bar lies beyond the edge.
            inwards = best.side * float(np.sign(lightness)) * width / 2
            error = sigma / 2 if lightness else width / 2
            out[k] = _Place(best.at + inwards, float(np.hypot(best.sigma, error)), width, sigma)
    return out


def _width(places: Sequence[_Place]) -> tuple[float, float]:
    """Returns the width of a bar whose second edge is missing: that of its group, else the usual one."""
    if not places:
        return BAR_WIDTH_M, _WIDTH_SIGMA_M
    widths = np.array([place.width for place in places])
    return float(np.median(widths)), float(np.hypot(widths.std(), places[0].sigma_width))


def _pooled(line: Line, places: Sequence[_Place]) -> _Place:
    """Returns what the windows of a group say of a line together, for those that do not show it."""
    if not places:
        return _Place(line.position, inf, *_width(places))
    at = np.array([place.position for place in places])
    scatter = float(np.hypot(at.std(), np.median([place.sigma for place in places])))
    return _Place(float(np.median(at)), scatter, *_width(places))
