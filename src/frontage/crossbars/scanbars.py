"""Evidence of bars from the scan: beams end on bars near the plane of the frame, and pass beside them.

Points on a bar lie in a layer parallel to the wall, as dense as on the wall; a pane holds few points of
that layer, from dirt and from mixed pixels at edges, and its beams return from the room or not at all.
Both are Poisson processes, so that a bar of given place and width has a likelihood ratio that adds up
point by point. A window has several such layers: frame, both sashes of a sash window, a mullion in front
of them. Where a blind or a curtain fills a layer, panes and bars are equally dense there, and nothing is
concluded.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter, uniform_filter1d
from scipy.special import expit, logit

from frontage.crossbars.candidates import Box
from frontage.crossbars.exposure import exposed_box
from frontage.crossbars.lines import WIDTHS_M
from frontage.crossbars.profiles import strip_count
from frontage.crossbars.rectify import Grid
from frontage.crossbars.window import Window
from frontage.geometry.arrays import Array, Float
from frontage.model import Estimate

_HALF_M = 0.02  # half thickness of a layer: noise of ranges, profiles of bars
_APART_M = 0.03  # between layers
_DEEPEST_M = 0.4
_SHALLOWEST_M = 0.015  # below, points belong to the wall
_MOST_LAYERS = 4
_LEAST_SHARE = 0.12  # of the points of the strongest layer that a layer has
_STEP_M = 0.005
_NEAR_M = 0.08  # of the frame's depth: sashes behind it, posts before it; curtains and blinds lie deeper
_EDGE_M = 0.06  # beside what is hidden, where bars are not told from what hides it
_SILL_SHARE = 0.3  # of the height of a window that its sill hides at most
_STRAY = 0.05  # least share of the density of bars that panes hold
_FEW = 25  # points of a window that tell anything
_CELL_M = 0.04  # of the raster in which the points of panes are counted
_PANE_CELLS = 11  # of it across that surely hold a piece of pane
_BAR_SHARE = 0.25  # of them that are bars
_ROUNDS = 8
_FILLED_M = 0.025  # greatest width of the pieces of a bar in which points are counted
_HITS = 2.0  # points that a piece of a bar holds in one strip, if the scan is dense enough
_BROAD_M = 0.06  # width of a bar from which it must be filled in all its thirds
_LONG_STRIPS = 9  # over which they tell whether a broad bar is filled
_STRIPS = 3  # over which points are counted, because single strips hold few
_BOUNDS = (-1.0, 2.5)  # nats of one piece of one strip: scans have drifts and shadows, too
_CHOICE = 0.5  # nats that the choice among layers costs a strip


@dataclass(frozen=True, eq=False)
class _Layer:
    """A layer of points (n, 3) m, and the points per m2 of its panes."""

    own: Float
    pane: Array


@dataclass(frozen=True, eq=False)
class ScanHits:
    """The scan points of a window, by layers.

    points   (n, 3) m, those of all layers
    dense    points per m2 that bars get
    exposed  x0, z0, x1, z1 m, the part of the frame's plane that beams reach
    inside   (h, w) bool, where the raster lies inside a frame that is not a rectangle; None = it is one
    """

    layers: tuple[_Layer, ...]
    points: Float
    dense: float
    exposed: Box
    inside: Array | None = None

    @property
    def contrast(self) -> float:
        """Median logarithm of how much denser bars are than panes, in the clearest layer."""
        return max(float(np.median(np.log(self.dense / one.pane))) for one in self.layers)

    def exposed_share(self, ring: Float) -> float:
        """Returns how much of a window with an outline (k, 2) m beams reach, 0..1."""
        x0, z0, x1, z1 = self.exposed
        return float(max(x1 - x0, 0.0) * max(z1 - z0, 0.0) / np.ptp(ring, axis=0).prod())

    def evidence(self, grid: Grid, axis: int, widths: Array) -> Array:
        """Returns the log-likelihood ratios (s, n + 1, w) nats of bars across an axis."""
        parts = [self._of_layer(grid, layer, axis, widths) for layer in self.layers]
        return np.asarray(np.max(parts, axis=0) - _CHOICE * (len(parts) > 1), np.float32)

    def known(self, grid: Grid, axis: int) -> Array:
        """Returns which strips (s,) across the bars of an axis beams reach, bool."""
        strips = strip_count(grid, axis)
        middle = grid.start(1 - axis) + (np.arange(strips) + 0.5) * grid.shape[axis] * grid.px / strips
        return np.asarray((middle > self.exposed[1 - axis]) & (middle < self.exposed[3 - axis]))

    def _reached(self, grid: Grid, axis: int) -> Array:
        """Returns where (s, n) beams reach the raster."""
        at = grid.centres(axis)
        low, high = self.exposed[axis], self.exposed[2 + axis]
        first, last = grid.extent[axis] + _EDGE_M, grid.extent[2 + axis] - _EDGE_M
        low, high = low + _EDGE_M * (low > first), high - _EDGE_M * (high < last)
        reached = self.known(grid, axis)[:, None] & (at > low) & (at < high)
        if self.inside is None:
            return np.asarray(reached)
        turned = self.inside if axis == 0 else self.inside.T
        rows = (np.arange(len(reached)) + 0.5) * turned.shape[0] / len(reached)
        return np.asarray(reached & turned[rows.astype(np.int64)])

    def _of_layer(self, grid: Grid, layer: _Layer, axis: int, widths: Array) -> Array:
        piece = self._pieces(grid, layer, axis)
        strips, n = piece.shape
        before = np.pad(np.cumsum(piece, axis=1), ((0, 0), (1, 0)))
        smooth = uniform_filter1d(before, min(_LONG_STRIPS, strips), axis=0, mode="nearest")
        out = np.zeros((strips, n + 1, len(widths)), np.float32)
        for k, width in enumerate(widths):
            if width < n and (axis == 0 or width * grid.px < WIDTHS_M[1]):
                broad = width * grid.px > _BROAD_M
                out[:, : n + 1 - width, k] = _filled(smooth if broad else before, int(width), broad)
        return out

    def _pieces(self, grid: Grid, layer: _Layer, axis: int) -> Array:
        strips = strip_count(grid, axis)
        strip = grid.shape[axis] * grid.px / strips
        piece = float(np.clip(_HITS / (self.dense * strip), grid.px, _FILLED_M))
        size = max(1, round(piece / grid.px))
        area = size * grid.px * strip
        window = (min(_STRIPS, strips), size)
        hits = uniform_filter(_counted(grid, layer.own, axis, strips), window, mode="nearest") * size
        pane = _sampled(layer.pane, grid, axis, strips)
        ratio = hits * np.log(self.dense / pane) - (self.dense - pane) * area
        return np.asarray(np.clip(ratio, *_BOUNDS) * self._reached(grid, axis) * grid.px / _FILLED_M)


def scan_depth(window: Window) -> Estimate[float] | None:
    """Returns the depth m of the frame from the points alone: the strongest layer behind the wall."""
    depths = _layer_depths(window)
    if not depths:
        return None
    return Estimate(depths[0], np.array([[(2 * _STEP_M) ** 2]]), float(len(window.points)))


def scan_hits(grid: Grid, window: Window) -> ScanHits | None:
    """Returns the points of a window by layers; None where there are too few."""
    depths = _layer_depths(window)
    if not depths or not np.isfinite(window.spacing):
        return None
    y = window.points[:, 1] - window.wall_y
    dense = 1.0 / window.spacing**2
    frame = window.opening.depth
    if frame is not None:
        near = max(_NEAR_M, 3 * float(frame.sigma[0]))
        depths = [d for d in depths if abs(d - float(frame.value)) < near]
    if not depths:
        return None
    reach = [(d - _HALF_M, d + _HALF_M) for d in depths]
    if len(depths) > 1:  # all together: bars may lie between two layers
        reach.append((min(depths) - _HALF_M, max(depths) + _HALF_M))
    layers = []
    for low, high in reach:
        own = window.points[(y > low) & (y < high)]
        layers.append(_Layer(own, _pane_density(_cells(grid, own), dense)))
    points = layers[-1].own
    return ScanHits(tuple(layers), points, dense, _exposed(window, [one.own for one in layers], dense))


def _exposed(window: Window, layers: Sequence[Float], dense: float) -> Box:
    """Returns the part x0, z0, x1, z1 m of the frame that beams reach; the last layer holds all the others.

    A sill hides more of what lies deeper. A layer that begins higher up is that of an upper sash.
    """
    ring = window.ring
    x0, z0, x1, z1 = exposed_box(ring, layers[-1], dense)
    start, height = float(ring[:, 1].min()), float(np.ptp(ring[:, 1]))
    below = [exposed_box(ring, own, dense)[1] for own in layers]
    return x0, max([z0, *(z for z in below if z - start < _SILL_SHARE * height)]), x1, z1


def _layer_depths(window: Window) -> list[float]:
    """Returns the depths m behind the wall at which points gather, the strongest first."""
    depth = window.points[:, 1] - window.wall_y
    behind = depth[(depth > _SHALLOWEST_M) & (depth < _DEEPEST_M)]
    if len(behind) < _FEW:
        return []
    edges = np.arange(_SHALLOWEST_M, _DEEPEST_M + _STEP_M, _STEP_M)
    count = uniform_filter(np.histogram(behind, edges)[0].astype(np.float64), 5, mode="constant")
    middle = (edges[1:] + edges[:-1]) / 2
    found: list[float] = []
    for k in np.argsort(-count, kind="stable"):
        if count[k] < _LEAST_SHARE * count.max() or len(found) == _MOST_LAYERS:
            break
        if all(abs(middle[k] - d) > _APART_M for d in found):
            found.append(float(middle[k]))
    return found


def _filled(before: Array, width: int, broad: bool) -> Array:
    """Returns the evidence (s, n + 1 - width) of bars from cumulative sums (s, n + 1) across them.

    A broad bar must be filled with points all over: two bars with a pane between them are not one.
    """
    last = before.shape[1] - width
    if not broad:
        return np.asarray(before[:, width:] - before[:, :last])
    cuts = [0, width // 3, width - width // 3, width]
    parts = [
        (before[:, high : last + high] - before[:, low : last + low]) / (high - low)
        for low, high in itertools.pairwise(cuts)
    ]
    return np.asarray(width * np.min(parts, axis=0))


def _cells(grid: Grid, points: Float) -> Array:
    """Returns the numbers of points in the cells (x, z) over the raster."""
    x0, z0, x1, z1 = grid.extent
    shape = (max(3, round((x1 - x0) / _CELL_M)), max(3, round((z1 - z0) / _CELL_M)))
    return np.histogram2d(points[:, 0], points[:, 2], bins=shape, range=((x0, x1), (z0, z1)))[0]


def _pane_density(count: Array, dense: float) -> Array:
    """Returns the points per m2 of a layer in the panes about every cell (x, z).

    Bars and panes are a mixture of two Poisson processes, of which that of bars is known.
    """
    bars = dense * _CELL_M**2
    pane = np.full(count.shape, 0.3 * bars)
    for _ in range(_ROUNDS):
        log_odds = logit(_BAR_SHARE) + count * np.log(bars / pane) - (bars - pane)
        open_share = expit(-log_odds)  # the odds themselves are too large a number in dense scans
        mean = uniform_filter(open_share * count, _PANE_CELLS, mode="nearest")
        pane = mean / np.maximum(uniform_filter(open_share, _PANE_CELLS, mode="nearest"), 1e-3)
        pane = np.clip(pane, _STRAY * bars, 0.95 * bars)
    return np.asarray(pane / _CELL_M**2)


def _sampled(pane: Array, grid: Grid, axis: int, strips: int) -> Array:
    """Returns densities of cells (x, z) at strips and positions (s, n) across an axis."""
    turned = pane.T if axis == 0 else pane
    n = grid.shape[1 - axis]
    rows = (np.arange(strips) * turned.shape[0]) // strips
    columns = (np.arange(n) * turned.shape[1]) // n
    return np.asarray(turned[np.ix_(rows, columns)])


def _counted(grid: Grid, points: Float, axis: int, strips: int) -> Array:
    """Returns the numbers of points (s, n) in every strip at every position."""
    across, along = (0, 2) if axis == 0 else (2, 0)
    n = grid.shape[1 - axis]
    strip = grid.shape[axis] * grid.px / strips
    k = ((points[:, across] - grid.start(axis)) / grid.px).astype(np.int64)
    s = ((points[:, along] - grid.start(1 - axis)) / strip).astype(np.int64)
    inside = (k >= 0) & (k < n) & (s >= 0) & (s < strips)
    count = np.bincount(s[inside] * n + k[inside], minlength=strips * n)
    return count.reshape(strips, n).astype(np.float64)
