"""Straight 2-D edges of a picture: Sobel edge points, thinned and split (paper B, section 3.3.1)."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from frontage.geometry.arrays import Array, Bool, Float, Int

_SIGMAS = 4.0  # of the gradients of noise and texture that an edge point's gradient exceeds
_LEAST_GRADIENT = 0.13  # grey levels per px: that of rounding to whole levels
_ALIKE = np.cos(np.radians(22.5))  # of the angle between the gradients of linked edge points
_STRAIGHT_PX = 1.0  # largest distance of an edge point from its straight segment
_SHORTEST_PX = 6  # number of edge points of the shortest segment
_POINT_SIGMA_PX = 0.3  # of one edge point across the edge, the least
_SYSTEMATIC_PX = 0.1  # of a segment across, which more edge points do not average out
_AHEAD = ((1, 0), (1, 1), (0, 1), (-1, 1))
"""Steps (column, row) across the four directions of a gradient, and to the four neighbours not yet linked."""


@dataclass(frozen=True, eq=False)
class Segments:
    """Straight edges of a picture.

    ends   (n, 2, 2) px, both ends (column, row) of each, first pixel centre at 0.5
    sigma  (n,) px, standard error across the edge
    """

    ends: Float
    sigma: Float

    def __len__(self) -> int:
        return len(self.sigma)


def straight_edges(grey: Array, region: Bool) -> Segments:
    """Returns the straight edges within a region (h, w) of a grey picture (h, w) float32."""
    points, gradients = edge_points(grey, region)
    pieces = [piece for chain in _chains(points, gradients) for piece in split(points[chain])]
    if not pieces:
        return Segments(np.empty((0, 2, 2)), np.empty(0))
    fitted = [_fit(piece) for piece in pieces]
    return Segments(np.array([ends for ends, _ in fitted]), np.array([sigma for _, sigma in fitted]))


def edge_points(grey: Array, region: Bool) -> tuple[Float, Float]:
    """Returns the thinned edge points (n, 2) px of the Sobel filter and their gradients (n, 2).

    Thinning keeps the points whose gradient is the largest along its own direction, one of four; their place
    on it is the vertex of the parabola through the point and its two neighbours.
    """
    gx, gy = (cv2.Sobel(grey, cv2.CV_32F, *order, ksize=3, scale=1 / 8) for order in ((1, 0), (0, 1)))
    size = cv2.magnitude(gx, gy)
    # Gradients of noise have a Rayleigh distribution, whose median is 1.18 standard errors of a component.
    noise = float(np.median(size[region])) / 1.1774 if region.any() else 0.0
    strong = region & (size > _SIGMAS * max(noise, _LEAST_GRADIENT))
    strong[[0, -1]] = strong[:, [0, -1]] = False
    row, column = np.nonzero(strong)
    x, y, here = gx[row, column], gy[row, column], size[row, column]
    direction = np.round(np.arctan2(y, x) / (np.pi / 4)).astype(np.int64) % 4
    step = np.array(_AHEAD)[direction]
    before, after = (size[row + s * step[:, 1], column + s * step[:, 0]] for s in (-1, 1))
    top = (here > before) & (here >= after)
    bend = (2 * here - before - after)[top]
    offset = 0.5 * (after - before)[top] / bend
    points = np.column_stack([column, row])[top] + 0.5 + offset[:, None] * step[top]
    return points, np.column_stack([x, y])[top].astype(np.float64)


def _chains(points: Float, gradients: Float) -> list[Int]:
    """Links edge points to neighbouring ones with a gradient alike; returns the numbers of each chain."""
    if len(points) == 0:
        return []
    cell = np.floor(points).astype(np.int64)
    cell -= cell.min(0) - 2
    number = np.full(cell.max(0) + 3, -1)
    number[cell[:, 0], cell[:, 1]] = np.arange(len(points))  # of two in one pixel, one is linked
    unit = gradients / np.linalg.norm(gradients, axis=1, keepdims=True)
    pairs = []
    for dx, dy in _AHEAD:
        other = number[cell[:, 0] + dx, cell[:, 1] + dy]
        linked = (other >= 0) & ((unit * unit[other]).sum(1) > _ALIKE)
        pairs.append(np.stack([np.flatnonzero(linked), other[linked]]))
    a, b = np.concatenate(pairs, axis=1)
    n = len(points)
    _, label = connected_components(coo_array((np.ones(len(a), np.int8), (a, b)), (n, n)), directed=False)
    order = np.argsort(label, kind="stable")
    chains = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    return [c for c in chains if len(c) >= _SHORTEST_PX]


def split(chain: Float) -> list[Float]:
    """Splits a chain of edge points (n, 2) px into straight pieces.

    A chain is cut at the point farthest from the line through its ends, until none is farther than a pixel;
    pieces of fewer than six points are dropped.
    """
    pieces, left = [], [chain]
    while left:
        points = left.pop()
        if len(points) < _SHORTEST_PX:
            continue
        along, _ = _along(points)
        points = points[np.argsort(along, kind="stable")]
        way = points[-1] - points[0]
        length = float(np.hypot(*way))
        off = points - points[0]
        away = np.abs(off[:, 0] * way[1] - off[:, 1] * way[0]) / length if length > 0 else np.zeros(len(off))
        k = int(np.argmax(away))
        if away[k] <= _STRAIGHT_PX:
            pieces.append(points)
        else:
            left += [points[:k], points[k:]]
    return pieces


def _along(points: Float) -> tuple[Float, Float]:
    """Returns places (n,) of points (n, 2) along their main direction, from their mean, and its unit (2,)."""
    centred = points - points.mean(0)
    (xx, xy), (_, yy) = centred.T @ centred
    angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    unit = np.array([np.cos(angle), np.sin(angle)])
    return centred @ unit, unit


def _fit(points: Float) -> tuple[Float, float]:
    """Returns the ends (2, 2) of the line fitted to points (n, 2) px, and its standard error across."""
    along, unit = _along(points)
    middle = points.mean(0)
    across = (points - middle) @ np.array([-unit[1], unit[0]])
    spread = max(float(across.std()), _POINT_SIGMA_PX)
    ends = middle + np.array([[along.min()], [along.max()]]) * unit
    # Neighbouring edge points share pixels of the filter: every third counts.
    return ends, float(np.hypot(_SYSTEMATIC_PX, spread / np.sqrt(max(len(points) / 3, 1.0))))
