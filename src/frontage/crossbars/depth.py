"""The depth of a window's frame behind the wall, where the straight edges of all views coincide (plane
sweep).

Frames and bars consist of long edges along x and z. At the depth of the frame these fall together in all
views; edges of curtains, of things in the room and of reflections do so at other depths, or nowhere. The
views are compared by the mean correlation r of their edges over all pairs; n independent edges then have
the log-likelihood ``-n/2 ln(1 - r)``. Repeated bars agree again when a view is displaced by their pitch,
but never all views at once, and the scan's own depth of the frame, a prior, decides between the rest.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from frontage.crossbars.rectify import Grid, WallView
from frontage.geometry.arrays import Array, Float
from frontage.model import Estimate, Provenance

DEEPEST_M = 0.6  # behind the wall; no frame lies deeper
_SHALLOWEST_M = -0.03  # frames flush with the wall, and noise
_SWEEP_PX_M = 0.004
_BAND_M = 0.04
_ALONG_M = 0.2  # length over which an edge must run straight
_STEP_M = 0.0125
_FREE_SIGMA_M = 0.25  # of a depth of which nothing is known
_USUAL_M = 0.15  # depth of frames behind walls
_LEAST_PRIOR_SIGMA_M = 0.015  # the scan sees sashes, blinds and frames as one surface
_OUTLIER = 0.02  # probability that the scan's depth is that of something else
_EDGES = 12.0  # independent straight edges that a window shows per axis
_LEAST_SIGMA_M = 0.002  # of any depth: frames are not flat


@dataclass(frozen=True, eq=False)
class StraightEdges:
    """Straight edges of a view on the wall, across x and across z, with where it shows the window.

    The layers (2, m, n) float32 hold edges and mask; they are coarse along the edges and fine across them.
    """

    view: WallView
    layers: tuple[Array, Array]


def frame_depth(
    grid: Grid, edges: Sequence[StraightEdges], prior: Estimate[float] | None
) -> Estimate[float] | None:
    """Returns the depth m of the frame behind the wall; None where neither views nor the scan tell it.

    edges  of the views on the wall, see `edges_of`
    prior  the depth that the scan measured
    """
    tilts = [e.view.tilt for e in edges]
    if len(edges) < 2 or float(np.ptp(tilts, axis=0).max()) * DEEPEST_M < 3 * grid.px:
        return prior
    depths = np.arange(_SHALLOWEST_M, DEEPEST_M, _STEP_M)
    score = np.array([likelihood(grid, edges, d) for d in depths]) + _prior(depths, prior)
    best = depths[int(np.argmax(score))]
    fine = best + np.arange(-1.6, 1.61, 0.2) * _STEP_M
    values = np.array([likelihood(grid, edges, d) for d in fine]) + _prior(fine, prior)
    return _estimate(depths, score, fine, values)


def _estimate(depths: Float, score: Float, fine: Float, values: Float) -> Estimate[float]:
    """Returns the depth at the vertex of a parabola through the highest values, and its standard error.

    The variance is that of the whole posterior, so that rival depths widen it.
    """
    k = int(np.clip(np.argmax(values), 1, len(fine) - 2))
    a, b, c = values[k - 1 : k + 2]
    bend = a - 2 * b + c
    step = fine[1] - fine[0]
    value = float(fine[k] + (0.5 * step * (a - c) / bend if bend < 0 else 0.0))
    weight = np.exp(values - values.max())
    near = float(weight @ (fine - value) ** 2 / weight.sum())
    weight = np.exp(score - score.max())
    rivals = np.abs(depths - value) > 2.5 * _STEP_M
    far = float((weight * (depths - value) ** 2)[rivals].sum() / weight.sum())
    variance = near + far + _LEAST_SIGMA_M**2
    return Estimate(value, np.array([[variance]]), float(len(fine)), Provenance.MEASURED)


def _prior(depths: Float, prior: Estimate[float] | None) -> Float:
    """Returns the log-density of depths as far as the scan knows it."""
    free = np.exp(-0.5 * ((depths - _USUAL_M) / _FREE_SIGMA_M) ** 2) / _FREE_SIGMA_M
    if prior is None:
        return np.log(free)
    sigma = max(float(prior.sigma[0]), _LEAST_PRIOR_SIGMA_M)
    known = np.exp(-0.5 * ((depths - prior.value) / sigma) ** 2) / sigma
    return np.asarray(np.log((1 - _OUTLIER) * known + _OUTLIER * free))


def edges_of(grid: Grid, views: Sequence[WallView]) -> list[StraightEdges]:
    """Returns the straight edges of all views."""
    found = []
    for view in views:
        grey = view.grey
        solid = cv2.erode((view.inside > 0.99).astype(np.float32), np.ones((5, 5)), borderValue=0.0)
        along = _straight(grey.T, solid.T, grid.px)
        found.append(
            StraightEdges(
                view, (_straight(grey, solid, grid.px), np.ascontiguousarray(along.transpose(1, 0, 2)))
            )
        )
    return found


def _straight(grey: Array, inside: Array, px: float) -> Array:
    """Returns the edges across columns that run straight along the rows, and the mask, as (m, n, 2)."""
    rows, columns = grey.shape
    wide = max(4, round(columns * px / _SWEEP_PX_M)) if px < _SWEEP_PX_M else columns
    size = (wide, max(2, round(rows * px / _BAND_M)))
    mask = cv2.resize(inside, size, interpolation=cv2.INTER_AREA)
    mean = cv2.resize(grey * inside, size, interpolation=cv2.INTER_AREA) / np.maximum(mask, 1e-3)
    mask = (mask > 0.5).astype(np.float32)
    step = np.zeros_like(mean)
    step[:, 1:-1] = (mean[:, 2:] - mean[:, :-2]) * mask[:, 2:] * mask[:, :-2]
    used = np.abs(step[mask > 0])
    step = np.clip(step / (6 * (0.5 + np.median(used) if len(used) else 1.0)), -1.0, 1.0)
    bands = 2 * int(0.5 * _ALONG_M / _BAND_M) + 1
    total = np.abs(cv2.blur(step, (1, bands))) / np.maximum(cv2.blur(mask, (1, bands)), 0.25)
    return np.ascontiguousarray(np.stack([total, mask], 2), np.float32)


def likelihood(grid: Grid, edges: Sequence[StraightEdges], depth: float) -> float:
    """Returns the log-likelihood of a depth, from the correlation of the views' edges there."""
    return float(likelihoods(grid, edges, depth, (grid.extent,))[0])


def likelihoods(
    grid: Grid, edges: Sequence[StraightEdges], depth: float, parts: Sequence[tuple[float, ...]]
) -> Float:
    """Returns the log-likelihoods (k,) of a depth from what parts x0, z0, x1, z1 m of the plane show."""
    total = np.zeros(len(parts))
    for axis in (0, 1):
        moved = np.stack([e.view.at(grid, depth, e.layers[axis]) for e in edges])
        for k, part in enumerate(parts):
            rows, columns = _pixels(grid, part, moved.shape[1:3])
            own = moved[:, rows, columns].reshape(len(edges), -1, 2)
            r = _correlation(own[..., 0], own[..., 1] > 0.9)
            total[k] -= 0.5 * _EDGES * np.log(1.0 - np.clip(r, 0.0, 0.98))
    return total


def _pixels(grid: Grid, part: tuple[float, ...], shape: tuple[int, ...]) -> tuple[slice, slice]:
    """Returns the rows and columns of a part of the plane in a layer (h, w), which may be coarser."""
    x0, z0, x1, z1 = grid.extent
    columns = (round((x - x0) / (x1 - x0) * shape[1]) for x in (part[0], part[2]))
    rows = (round((z - z0) / (z1 - z0) * shape[0]) for z in (part[1], part[3]))
    return slice(*(max(r, 0) for r in rows)), slice(*(max(c, 0) for c in columns))


def _correlation(layers: Array, inside: Array) -> float:
    """Returns the mean correlation of views (v, n) over all pairs, where both show the window."""
    known = inside.astype(np.float32)
    shown = known.sum(0)
    known *= shown > 1.5
    mean = (layers * known).sum(1) / np.maximum(known.sum(1), 1.0)
    away = (layers - mean[:, None]) * known
    energy = np.einsum("vn,vn->n", away, away)
    together = away.sum(0)
    pairs = float(together @ together) - float(energy.sum())
    return pairs / max(float(energy @ np.maximum(shown - 1.0, 0.0)), 1e-9)
