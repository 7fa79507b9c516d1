"""Panels: recesses that are shallower than any reveal and return as much as the wall does."""

from dataclasses import replace

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float
from frontage.model.masonry import MASONRY
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.evidence import Evidence, local_rate, log_likelihood_ratio
from frontage.openings.wall.raster import averaged, closed, opened

_FULL = 0.6  # share of the wall's beams that come back from a panel: glass returns less
_NARROWEST = 0.25  # m, least width of a panel: frames and posts between casements are narrower
_ABOVE = 0.5  # m above the ground, where thresholds lie and the share is not asked for
_SLIT = 0.1  # m: shutters that leave less of the opening free than that are closed
_EDGE = 2  # cells at the border of a shutter that may be either
_WIDE = 0.8  # share of its box that a shutter fills, and of its width that is open below it
_DOOR = 1.5  # m: a piece that high that stands on the ground may be the leaf of a door


def without_panels(evidence: Evidence, beams: Beams, ground: float) -> Evidence:
    """Returns the evidence with panels as wall; `ground` is the height z m of the ground.

    A panel is full of points of one surface right behind the wall, and wider than a frame. Leaves of doors
    and partly lowered shutters are no panels.
    """
    raster = evidence.raster
    shallow = beams.open_depth <= MASONRY.panel
    full = full_and_even(evidence, beams.open[shallow], beams.open_depth[shallow], beams.least)
    foot = max(int((ground + _ABOVE - raster.corner[1]) / raster.cell), 0)
    is_open = evidence.llr > 0.0
    leaves = _doors(full, is_open, foot, raster.cell) | _shutters(full, is_open, raster.cell)
    panel = ndimage.maximum_filter(full & ~leaves, 3)
    return as_wall(evidence, np.where(panel, raster.count(*beams.open[shallow].T), 0.0), panel)


def full_and_even(evidence: Evidence, place: Float, depth: Float, least: float) -> Bool:
    """Returns the cells (h, w) of surfaces, wider than a frame, that are as full of points as wall.

    place, depth  (n, 2) m, (n,) m of the points behind the wall
    least         m from a surface beyond which a point is not on it
    """
    raster = evidence.raster
    x, z = place.T
    held, first, second = (raster.count(x, z, depth**power) for power in range(3))
    come, first, second = (averaged(m) for m in (held, first, second))
    spread = second / np.maximum(come, 1e-9) - (first / np.maximum(come, 1e-9)) ** 2
    full = local_rate(held, evidence.expected, 1.0) >= _FULL
    full &= (evidence.expected > 0.0) & (spread < (least / 2.0) ** 2)
    narrowest = max(int(np.ceil(_NARROWEST / raster.cell)), 2)
    full = closed(full, (3, 3))  # counts scatter, so small gaps are closed first
    return opened(full, (narrowest, narrowest))


def as_wall(evidence: Evidence, held: Float, where: Bool) -> Evidence:
    """Returns the evidence with cells `where` (h, w) as wall, and with points (h, w) from behind it on it."""
    if not held.any():
        return evidence
    solid, open_ = evidence.solid + held, evidence.open - held
    told = log_likelihood_ratio(evidence.expected, solid, 0.0 * open_)
    llr = np.where(where & evidence.inside, told, evidence.llr)
    return replace(evidence, llr=llr, solid=solid, open=open_)


def _doors(full: Bool, open_: Bool, foot: int, cell: float) -> Bool:
    """Returns the cells (h, w) of `full` that are leaves: high as a door, and open or full to row `foot`."""
    out = np.zeros(full.shape, np.bool_)
    labels, _ = ndimage.label(full)
    for rows, columns in ndimage.find_objects(labels):
        below = slice(min(foot, rows.start), rows.start)
        stands = open_[below, columns].mean(axis=1) > _FULL  # no wall between it and the ground
        if stands.all() and (rows.stop - below.start) * cell > _DOOR:
            out[rows, columns] = True
    return out


def _shutters(full: Bool, open_: Bool, cell: float) -> Bool:
    """Returns the cells (h, w) of `full` that are partly lowered shutters or blinds.

    They fill the upper part of an opening from jamb to jamb: what is open below them is as wide, and above
    them is wall. Panels between the windows of one column have a window above as well. Gaps narrower than a
    pier do not part a shutter.
    """
    out = np.zeros(full.shape, np.bool_)
    bridged = closed(full, (1, int(MASONRY.half_brick / cell) | 1))
    labels, _ = ndimage.label(bridged)
    reach = max(int(np.ceil(_SLIT / cell)), 2)
    for number, (rows, columns) in enumerate(ndimage.find_objects(labels), 1):
        top, foot = rows.stop + _EDGE, max(rows.start - _EDGE, 0)
        left, right = max(columns.start - _EDGE, 0), columns.stop + _EDGE
        below = slice(max(foot - reach, 0), foot)
        beside = slice(max(left - reach, 0), left), slice(right, right + reach)
        held = [open_[top : top + reach, columns], *(open_[below, side] for side in beside)]
        is_rectangle = (labels[rows, columns] == number).mean() >= _WIDE
        ends = is_rectangle and all(part.size > 0 and part.mean() < 1.0 - _FULL for part in held)
        if ends and open_[below, columns].mean() > _WIDE:
            out[rows, columns] = True
    return out & bridged
