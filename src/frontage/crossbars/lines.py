"""Evidence of bars: pairs of opposite edges, or hits of the scan, summed over the views strip by strip.

What speaks for a bar at one place and of one width is added up over any piece of its length from
cumulative sums, so that the search over layouts can ask for every pane without touching a pixel.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.ndimage import maximum_filter1d

from frontage.crossbars.profiles import STRIP_M, Profiles, strip_count
from frontage.crossbars.rectify import Grid
from frontage.geometry.arrays import Array, Float

WIDTHS_M = (0.015, 0.13)
MULLIONS_M = (0.13, 0.36)
_WIDTH_STEP_M = 0.005
_MULLION_STEP_M = 0.02
_RAIL_M = 0.03  # about the lower edge of a meeting rail
_TOLERANCE_M = 0.004  # by which edges may lie apart in two views: poses, and profiles that are not sharp
_SETTLED = 3.0  # nats within which bars of neighbouring places and widths are alike
# Nats of edges that run straight along a bar, either sign, but are those of other things.
_LINES = np.log(2.0) + 0.8
# Share of bars that are lighter than what is behind them on one side and darker on the other: sides show.
_MIXED = 0.15
_ALIKE_M = 0.05  # width of a bar within which its colours have their errors in common
_MOST_ALIKE = 4.0  # of such pieces that count
_INDEPENDENT_M = 0.1  # length of a bar over which clutter is one and the same thing


@dataclass(frozen=True, eq=False)
class Bars:
    """Evidence of the bars across one axis.

    axis    0: upright bars, 1: transoms
    start   m, coordinate of the lower edge of position 0 across the bars; px m per position
    along   m, coordinate of the lower edge of strip 0; strip m per strip
    widths  (w,) int, px
    total   (s + 1, n, w) float32 nats: cumulative over strips; n is the lower edge of a bar
    known   (s + 1,) cumulative share of strips that anything shows
    """

    axis: int
    start: float
    px: float
    along: float
    strip: float
    widths: Array
    total: Array = field(repr=False)
    known: Float = field(repr=False)

    def over(self, low: float, high: float, rows: slice = slice(None)) -> Array:
        """Returns the evidence (n, w) nats of bars that run from `low` to `high` m, of some positions."""
        return np.asarray(self._until(high, rows) - self._until(low, rows))

    def rows(self, place: float, reach: float) -> tuple[int, int]:
        """Returns the first and last position of bars of any width with their centre near a place m."""
        first = (place - reach - self.start) / self.px - 0.5 * float(self.widths.max())
        last = (place + reach - self.start) / self.px + 1
        n = self.total.shape[1]
        low = int(np.clip(np.floor(first), 0, n - 1))
        return low, int(np.clip(np.ceil(last), low + 1, n))

    def shown(self, low: float, high: float) -> float:
        """Returns which share of a piece of length anything shows."""
        first, last = (min(max((z - self.along) / self.strip, 0.0), len(self.known) - 1) for z in (low, high))
        below = np.interp((first, last), np.arange(len(self.known)), self.known)
        return float((below[1] - below[0]) / max(last - first, 1e-6))

    def with_sash(self, behind: "Bars", rail: "Bars", z: float) -> "Bars":
        """Returns this evidence above a height z m, and that of the plane of a lower sash below it.

        rail  of bars that reach from one plane to the other: of the transom whose lower edge is near z
        """
        if self.axis == 1:
            ends = np.rint((z + np.array([-_RAIL_M, _RAIL_M]) - self.start) / self.px).astype(int)
            a, b = np.clip(ends, 0, self.total.shape[1]).tolist()
            parts = behind.total[:, :a], rail.total[:, a:b], self.total[:, b:]
            return replace(self, total=np.concatenate(parts, axis=1))
        s = int(np.clip(round((z - self.along) / self.strip), 0, len(self.total) - 1))
        total = self.total + (behind.total[s] - self.total[s])
        total[:s] = behind.total[:s]
        return replace(self, total=total)

    def _until(self, place: float, rows: slice) -> Array:
        at = min(max((place - self.along) / self.strip, 0.0), len(self.total) - 1)
        k = min(int(at), len(self.total) - 2)
        below, above = self.total[k, rows], self.total[k + 1, rows]
        return np.asarray(below + (at - k) * (above - below))

    def settled(self, value: Array, centre: Array) -> tuple[float, float, float]:
        """Returns centre m, width m and evidence nats of the best bar of values (k, w) with centres (k, w) m.

        Edges are found within a tolerance, so that bars of neighbouring places and widths have nearly the
        same evidence: the best bar is their mean.
        """
        n, w = divmod(int(value.argmax()), value.shape[1])
        best = float(value[n, w])
        width = self.widths * self.px
        near = np.abs(centre - centre[n, w]) + 0.5 * np.abs(width - width[w]) <= 3 * _TOLERANCE_M
        weight = np.where(near, np.exp(np.maximum(value - best, -700.0) / _SETTLED), 0.0)
        weight /= weight.sum()
        return float((weight * centre).sum()), float((weight * width).sum()), best

    def centres(self, first: int, last: int) -> Array:
        """Returns the coordinates (k, w) m of the centre lines of bars from `first` to before `last`."""
        return self.centre(np.arange(first, last)[:, None], np.arange(len(self.widths))[None, :])

    def centre(self, position: Array, width: Array) -> Array:
        """Returns the coordinates m of the centre lines of bars with a lower edge and a number of a width."""
        return np.asarray(self.start + (position + 0.5 * self.widths[width]) * self.px)


def bar_widths(px: float, finest: float) -> Array:
    """Returns the widths (w,) in px that are tried; none narrower than one px of the finest photo."""
    low, high = max(WIDTHS_M[0], finest), WIDTHS_M[1]
    narrow = np.arange(max(2, round(low / px)), round(high / px) + 1, max(1, round(_WIDTH_STEP_M / px)))
    wide = np.arange(MULLIONS_M[0], MULLIONS_M[1], _MULLION_STEP_M) / px
    return np.unique(np.concatenate([narrow, np.rint(wide).astype(int)]))


def bars_of_views(
    grid: Grid,
    profiles: Sequence[Profiles],
    likeness: Sequence[Array],
    weights: Float,
    widths: Array,
    upper: Sequence[Profiles] | None = None,
) -> Bars:
    """Returns the evidence of bars in several views, each of them weighted.

    likeness  (s, n) nats of every view, how much a place looks like the frame
    upper     the profiles of another plane, on which the higher edges lie: where two sashes meet, seen from
              the street, the lower edge is that of the lower sash and the upper one that of the upper sash
    """
    axis = profiles[0].axis
    strips, n = profiles[0].rise.shape
    total = np.zeros((len(widths), strips, n), np.float32)
    shown = np.zeros(strips)
    rows = zip(profiles, upper or profiles, likeness, weights.tolist(), strict=True)
    for view, above, like, weight in rows:
        total += (weight * STRIP_M / _INDEPENDENT_M) * _pairs(view, above, like, widths, grid.px)
        shown += view.known.mean(1)
    cumulated = np.zeros((strips + 1, n + 1, len(widths)), np.float32)
    cumulated[1:, :n] = np.cumsum(total, axis=1, out=total).transpose(1, 2, 0)
    known = np.concatenate([[0.0], np.cumsum(np.minimum(shown, 1.0))])
    strip = grid.shape[axis] * grid.px / strips
    return Bars(axis, grid.start(axis), grid.px, grid.start(1 - axis), strip, widths, cumulated, known)


def with_scan(bars: Bars, evidence: Array, known: Array) -> Bars:
    """Returns the evidence of the photos with that of the scan, (s, n + 1, w) nats, added.

    known  (s,) bool, the strips that the scan tells about
    """
    total = bars.total.copy()
    total[1:] += np.cumsum(evidence, axis=0)
    known = np.concatenate([[0.0], np.cumsum(np.maximum(np.diff(bars.known), known))])
    return Bars(bars.axis, bars.start, bars.px, bars.along, bars.strip, bars.widths, total, known)


def no_views(grid: Grid, axis: int, widths: Array) -> Bars:
    """Returns bars without any evidence, to which that of the scan is added."""
    strips, n = strip_count(grid, axis), grid.shape[1 - axis]
    strip = grid.shape[axis] * grid.px / strips
    total = np.zeros((strips + 1, n + 1, len(widths)), np.float32)
    known = np.zeros(strips + 1)
    return Bars(axis, grid.start(axis), grid.px, grid.start(1 - axis), strip, widths, total, known)


def _pairs(view: Profiles, above: Profiles, likeness: Array, widths: Array, px: float) -> Array:
    """Returns the log-likelihood ratios (w, s, n) of bars, from both edges and from what is between them.

    view, above  profiles of the lower and of the higher edge
    """
    rise, fall = (_near(e, px) for e in (view.rise, view.fall))
    end_rise, end_fall = (rise, fall) if above is view else (_near(e, px) for e in (above.rise, above.fall))
    n = rise.shape[1]
    out = np.zeros((len(widths), *rise.shape), np.float32)
    before = np.pad(np.cumsum(likeness, axis=1, dtype=np.float32), ((0, 0), (1, 0)))
    for k, width in enumerate(widths.tolist()):
        if width >= n:
            continue
        low_rise, low_fall = rise[:, : n - width], fall[:, : n - width]
        alike = low_rise * end_fall[:, width:] + low_fall * end_rise[:, width:]
        mixed = low_rise * end_rise[:, width:] + low_fall * end_fall[:, width:]
        edges = (1 - _MIXED) * alike + _MIXED * mixed
        colour = min(width * px / _ALIKE_M, _MOST_ALIKE)
        both = view.known[:, : n - width] & above.known[:, width:]
        between = (before[:, width:n] - before[:, : n - width]) / width
        out[k, :, : n - width] = (np.log(edges) + (colour * between - np.float32(_LINES))) * both
    return out


def _near(edges: Array, px: float) -> Array:
    """Returns the likelihood ratios (s, n) of edges within the tolerance."""
    size = 2 * round(_TOLERANCE_M / px) + 1
    return np.asarray(np.exp(maximum_filter1d(edges, size, axis=1) if size > 1 else edges))
