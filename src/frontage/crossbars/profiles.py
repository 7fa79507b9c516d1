"""Evidence of single edges: colour profiles across a window, strip by strip, and what their steps say.

The window is cut into strips of a few centimetres across the bars that are looked for. Within a strip the
colours are averaged along the bars, which are straight there, so that noise and texture shrink. A step of
such a profile is due to the edge of a bar, or to anything else: noise, folds, reflections, leaves. Its
log-likelihood ratio is bounded from both sides, because bars can be hidden, and because clutter has sharp
edges, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from frontage.crossbars.rectify import Grid, WallView
from frontage.geometry.arrays import Array

STRIP_M = 0.03
_MISSING = 0.12  # probability that the edge of a bar does not show: hidden, or of its background's colour
_CLUTTER = 0.15  # probability that a step is that of something else
_NOISE_LEVELS = 0.6  # of 255: least Laplace scale of a step, noise and compression of the photo
_STRONG = 0.985  # quantile of the steps in a window that are those of its frame and bars
_BRIGHTER = 1.3  # a step may be so many times as strong as those
_EDGE_PX = 0.75  # px of the photo on either side of an edge over which its step extends
_LEAST_INSIDE = 0.6  # share of a strip's pixel that must show the window


@dataclass(frozen=True, eq=False)
class Profiles:
    """Strips of a window in one view, for the bars across one axis.

    axis    0: upright bars, positions along x, strips along z; 1: the other way round
    colour  (s, n, 3) float32, mean colour of strip s at position n
    known   (s, n) bool, where the view shows the window
    rise, fall  (s, n) float32 nats: an edge there, brighter or darker towards higher positions
    """

    axis: int
    colour: Array
    known: Array
    rise: Array
    fall: Array


def strip_count(grid: Grid, axis: int) -> int:
    """Returns the number of strips for the bars across an axis."""
    return max(2, round(grid.shape[axis] * grid.px / STRIP_M))


def view_profiles(grid: Grid, view: WallView, depth: float, ring: Array, axis: int) -> Profiles:
    """Returns the strips of a view at the frame's depth; `ring` (h, w) is the mask of the outline."""
    image = view.at(grid, depth, view.image)
    inside = view.at(grid, depth, view.inside) * ring
    if axis == 1:
        image, inside = image.transpose(1, 0, 2), inside.T
    size = (image.shape[1], strip_count(grid, axis))
    share = cv2.resize(np.ascontiguousarray(inside), size, interpolation=cv2.INTER_AREA)
    colour = cv2.resize(np.ascontiguousarray(image * inside[..., None]), size, interpolation=cv2.INTER_AREA)
    known = share > _LEAST_INSIDE
    colour = np.where(known[..., None], colour / np.maximum(share, 1e-3)[..., None], 0.0)
    rise, fall = _edge_evidence(colour, known, max(1, round(_EDGE_PX * view.gsd[axis] / grid.px)))
    return Profiles(axis, colour.astype(np.float32), known, rise, fall)


def _edge_evidence(colour: Array, known: Array, reach: int) -> tuple[Array, Array]:
    """Returns the log-likelihood ratios (s, n) of edges between pixels n - 1 and n, rising and falling."""
    grey = colour.mean(2)
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
    return _ratio(step, noise, strong) * seen, _ratio(-step, noise, strong) * seen


def _ratio(step: Array, noise: float, strong: float) -> Array:
    """Returns log p(step | edge of a bar) - log p(step | none), nats."""
    laplace = np.exp(-np.abs(step) / noise) / (2 * noise)
    # a step of a bar is uniform up to the strongest one, and blurred by the noise
    broad = np.where(step > 0, 1.0, np.exp(np.minimum(step, 0.0) / noise)) / strong
    broad = np.where(step > strong, np.exp(-(step - strong) / noise) / strong, broad)
    clutter = np.where(np.abs(step) < strong, 0.5 / strong, 0.0)
    edge = (1 - _MISSING) * broad + _MISSING * laplace
    other = (1 - _CLUTTER) * laplace + _CLUTTER * clutter + 1e-9
    return np.asarray(np.log((edge + 1e-9) / other), np.float32)


def all_profiles(
    grid: Grid, views: Sequence[WallView], depth: float, ring: Array, axis: int
) -> list[Profiles]:
    """Returns the strips of all views."""
    return [view_profiles(grid, view, depth, ring, axis) for view in views]
