"""Evidence of single edges: colour profiles across a window, strip by strip, and what their steps say.

The window is cut into strips of a few centimetres across the bars that are looked for. Within a strip the
colours are averaged along the bars, which are straight there, so that noise and texture shrink. A step of
such a profile is due to the edge of a bar, or to anything else: noise, folds, reflections, leaves. Its
log-likelihood ratio is bounded from both sides, because bars can be hidden, and because clutter has sharp
edges, too.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import uniform_filter

from frontage.crossbars.rectify import Grid, PlaneView
from frontage.geometry.arrays import Array

STRIP_M = 0.03
_MISSING = 0.12  # probability that the edge of a bar does not show: hidden, or of its background's colour
_CLUTTER = 0.3  # least probability that a step is that of something else
_AROUND_M, _STRIPS = 0.24, 5  # across and along the bars, over which such steps are equally frequent
_MOST_CLUTTER = 0.95
_NOISE_LEVELS = 0.6  # of 255: least Laplace scale of a step, noise and compression of the photo
_STRONG = 0.985  # quantile of the steps in a window that are those of its frame and bars
_BRIGHTER = 1.3  # a step may be so many times as strong as those
_EDGE_PX = 0.75  # px of the photo on either side of an edge over which its step extends
_LEAST_INSIDE = 0.6  # share of a strip's pixel that must show the window


@dataclass(frozen=True, eq=False)
class Profiles:
    """Strips of a window in one view, for the bars across one axis.

    axis    0: upright bars, positions along x, strips along z; 1: the other way round
    known   (s, n) bool, where the view shows strip s at position n
    rise, fall  (s, n) float32 nats: an edge there, brighter or darker towards higher positions
    """

    axis: int
    known: Array
    rise: Array
    fall: Array


def strip_count(grid: Grid, axis: int) -> int:
    """Returns the number of strips for the bars across an axis."""
    return max(2, round(grid.shape[axis] * grid.px / STRIP_M))


def view_profiles(grid: Grid, view: PlaneView, axis: int) -> Profiles:
    """Returns the strips of a view on the plane of the frame."""
    grey, inside = _turned(view.grey, axis), _turned(view.inside, axis)
    size = (grey.shape[1], strip_count(grid, axis))
    share = cv2.resize(inside, size, interpolation=cv2.INTER_AREA)
    mean = cv2.resize(grey * inside, size, interpolation=cv2.INTER_AREA)
    known = share > _LEAST_INSIDE
    mean = np.where(known, mean / np.maximum(share, 1e-3), 0.0)
    reach = max(1, round(_EDGE_PX * view.gsd[axis] / grid.px))
    rise, fall = _edge_evidence(mean, known, reach, grid.px)
    return Profiles(axis, known, rise, fall)


def likeness_profiles(grid: Grid, likeness: Array, axis: int) -> Array:
    """Returns the mean likeness (s, n) with the frame in every strip, of a picture (h, w) of it."""
    turned = _turned(likeness, axis)
    size = (turned.shape[1], strip_count(grid, axis))
    return np.asarray(cv2.resize(turned, size, interpolation=cv2.INTER_AREA))


def _turned(layer: Array, axis: int) -> Array:
    """Returns a layer with the direction across the bars as its columns."""
    return np.ascontiguousarray(layer if axis == 0 else layer.swapaxes(0, 1))


def _edge_evidence(grey: Array, known: Array, reach: int, px: float) -> tuple[Array, Array]:
    """Returns the log-likelihood ratios (s, n) of edges between pixels n - 1 and n, rising and falling."""
    step, seen = np.zeros_like(grey), np.zeros_like(known)
    n = grey.shape[1]
    if n > 2 * reach + 2:
        left = sum(grey[:, k : n - 2 * reach + 1 + k] for k in range(reach)) / reach
        right = sum(grey[:, reach + k : n - reach + 1 + k] for k in range(reach)) / reach
        both = known[:, : n - 2 * reach + 1] & known[:, 2 * reach - 1 :]
        step[:, reach : n - reach + 1] = np.where(both, right - left, 0.0)
        seen[:, reach : n - reach + 1] = both
    used = np.abs(step[seen])
    if len(used) < 10:
        return np.zeros_like(step), np.zeros_like(step)
    noise = max(float(np.median(used)) / np.log(2), _NOISE_LEVELS)
    strong = max(_BRIGHTER * float(np.quantile(used, _STRONG)), 4 * noise)
    laplace = np.exp(-np.abs(step) / noise) / (2 * noise)
    broad = _broad(step, strong)
    clutter = _clutter(laplace, broad, seen, px)
    other = 1e-12 + (1 - clutter) * laplace + clutter * 0.5 * broad
    rise, fall = (
        np.log((_edge(sign * step, noise, laplace, broad) + 1e-12) / other).astype(np.float32) * seen
        for sign in (1, -1)
    )
    return rise, fall


def _broad(step: Array, strong: float) -> Array:
    """Returns the density of steps of bars and of clutter, which are uniform up to `strong`."""
    return np.asarray(np.exp(-np.maximum(np.abs(step) - strong, 0.0) / (0.3 * strong)) / strong)


def _edge(step: Array, noise: float, laplace: Array, broad: Array) -> Array:
    """Returns the density of steps at the edge of a bar that is brighter towards higher positions."""
    own = broad * np.where(step > 0, 1.0, np.exp(np.minimum(step, 0.0) / noise))
    return np.asarray((1 - _MISSING) * own + _MISSING * laplace)


def _clutter(laplace: Array, broad: Array, seen: Array, px: float) -> Array:
    """Returns the probability, around each place, that a step is not the edge of a bar.

    Bars are far apart. Where strong steps follow each other closely, they are those of slats or folds.
    """
    strong = _CLUTTER * 0.5 * broad
    share = np.where(seen, strong / (strong + (1 - _CLUTTER) * laplace), 0.0).astype(np.float32)
    size = (min(_STRIPS, len(share)), round(_AROUND_M / px))
    shown = uniform_filter(seen.astype(np.float32), size, mode="constant")
    mean = uniform_filter(share, size, mode="constant") / np.maximum(shown, 1e-3)
    return np.asarray(np.clip(mean, _CLUTTER, _MOST_CLUTTER))
