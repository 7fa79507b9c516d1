"""The frame of a window: how far it reaches in from the outline of the opening.

Its inner edge is the first straight edge from the outline inwards that runs along a whole side. The
outline comes from the scan and may be displaced against the photos by a few centimetres, so that every
side is looked for on its own, near a width that all sides share.
"""

from collections.abc import Sequence

import numpy as np

from frontage.crossbars.profiles import STRIP_M, Profiles
from frontage.crossbars.rectify import Grid
from frontage.geometry.arrays import Float
from frontage.model import Estimate

_USUAL_M = 0.065  # width of frames; half and twice as wide ones are rare
_SPREAD = 0.4  # of its logarithm
_RANGE_M = (0.02, 0.22)
_SIDE_M = 0.015  # by which the sides differ: sashes, displaced outlines
_INDEPENDENT_M = 0.1
_PLAIN = 1.0  # nats of every strip of a plain edge
_SURE = 3.0  # independent strips that make an edge sure
_MOST_NATS = 10.0  # of one side
_LEAST_GAIN = 3.0  # nats without which a side's edge is not seen
_CELL_M = 0.01  # across a side of a frame, in which points are counted
_STRAY = 0.05  # least share of the points of a frame that panes have
_FLOOR_M = 0.003  # standard error of a side's inner edge


def frame_sides(
    grid: Grid, profiles: Sequence[Sequence[Profiles]], weights: Float, ring: Float, arched: bool
) -> tuple[tuple[float, float, float, float], Estimate[float] | None]:
    """Returns the box x0, z0, x1, z1 m inside the frame, and the width of the frame, None if it is not seen.

    profiles  of all views, across x and across z
    arched    whether the top has no straight side
    """
    low, high = ring.min(0), ring.max(0)
    inset = np.arange(_RANGE_M[0], min(_RANGE_M[1], 0.3 * float((high - low).min())), grid.px)
    prior = -0.5 * (np.log(inset / _USUAL_M) / _SPREAD) ** 2
    sides = []
    for axis, start, sign in ((0, low[0], 1), (1, low[1], 1), (0, high[0], -1), (1, high[1], -1)):
        edge = _edges(profiles[axis], weights)
        at = (start + sign * inset - grid.start(axis)) / grid.px
        sides.append(np.interp(at, np.arange(len(edge)), edge))
    if arched:
        sides[3] = np.zeros_like(inset)
    scores = np.stack(sides)
    apart = np.abs(inset[:, None] - inset[None, :])
    soft = scores[:, None, :] - 0.5 * (apart[None] / _SIDE_M) ** 2  # of side, common width, own width
    common = int((soft.max(2).sum(0) + prior).argmax())
    own = soft[:, common].argmax(1)
    seen = scores[np.arange(4), own] > _LEAST_GAIN
    wide = np.where(seen, inset[own], inset[common])
    x0, z0 = low + wide[:2]
    x1, z1 = high - wide[2:]
    box = (float(x0), float(z0), float(x1), float(z1))
    if not seen.any():
        return box, None
    width = float(inset[own][seen].mean())
    sigma = np.hypot(_FLOOR_M, _SIDE_M / 2) / np.sqrt(seen.sum())
    return box, Estimate(width, np.array([[sigma**2]]), float(seen.sum()))


def _edges(profiles: Sequence[Profiles], weights: Float) -> Float:
    """Returns the evidence (n,) nats of straight edges over the whole length, of either sign in each view.

    Sashes have many edges, all of them plain; which one bounds the panes is not told by the plainest.
    """
    total = np.zeros(profiles[0].rise.shape[1])
    shown = np.zeros_like(total)
    for view, weight in zip(profiles, weights, strict=True):
        total += weight * np.where(view.known, np.maximum(view.rise, view.fall), 0.0).sum(0)
        shown += weight * view.known.sum(0)
    mean = total / np.maximum(shown, 1e-6)
    sure = np.minimum(shown * STRIP_M / _INDEPENDENT_M / _SURE, 1.0)
    return np.asarray(_MOST_NATS * sure * np.clip(mean / _PLAIN, -1.0, 1.0))


def scanned_sides(
    ring: Float, exposed: Float, points: Float, dense: float, arched: bool = False
) -> tuple[tuple[float, float, float, float], Estimate[float] | None]:
    """Returns the same from a scan, whose points fill the sides of the frame and leave its panes open.

    exposed  (4,) m, the box x0, z0, x1, z1 that beams reach
    points   (n, 3) m, facade frame: those near the plane of the frame
    dense    points per m2 that a surface there returns
    arched   whether the top has no straight side: the frame is as wide there as at the other sides
    """
    low, high = ring.min(0), ring.max(0)
    wide, seen = np.zeros(4), np.zeros(4, bool)
    for axis in (0, 1):
        at = points[:, 2 * axis]
        full = dense * _CELL_M * max(float(exposed[3 - axis] - exposed[1 - axis]), _CELL_M)
        cells = max(3, round(float(high[axis] - low[axis]) / _CELL_M))
        count = np.histogram(at, cells, (low[axis], high[axis]))[0]
        pane = max(float(np.median(count)), _STRAY * full)
        gain = count * np.log(max(full / pane, 1.0)) - max(full - pane, 0.0)
        most = min(int(_RANGE_M[1] / _CELL_M), int(0.3 * cells))
        for k, side in ((axis, gain), (2 + axis, gain[::-1])):
            total = np.cumsum(side[:most])
            best = int(total.argmax())
            wide[k], seen[k] = (best + 1) * _CELL_M, total[best] > _LEAST_GAIN
    seen[3] &= not arched
    usual = float(np.median(wide[seen])) if seen.any() else _USUAL_M
    wide = np.where(seen, wide, _RANGE_M[0])  # hidden by the reveal
    wide[3] = usual if arched else wide[3]
    x0, z0 = low + wide[:2]
    x1, z1 = high - wide[2:]
    box = (float(x0), float(z0), float(x1), float(z1))
    if not seen.any():
        return box, None
    sigma = np.hypot(_CELL_M, _SIDE_M / 2) / np.sqrt(seen.sum())
    return box, Estimate(usual, np.array([[sigma**2]]), float(seen.sum()))


def usual_sides(ring: Float) -> tuple[float, float, float, float]:
    """Returns the box x0, z0, x1, z1 m inside a frame of the usual width."""
    (x0, z0), (x1, z1) = ring.min(0) + _USUAL_M, ring.max(0) - _USUAL_M
    return float(x0), float(z0), float(x1), float(z1)
