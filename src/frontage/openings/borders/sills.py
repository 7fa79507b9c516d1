"""Finds weathered sills: masonry that rises from the face of the wall to the pane, as below Gothic windows.

The wall goes on along such a slope, so that the opening begins where the slope meets the pane. Sills of other
windows are slabs that are hardly higher where they end than where they begin.
"""

from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.masonry import MASONRY, TOLERANCES
from frontage.openings.borders.depth import AROUND, density_beside, find_depth
from frontage.openings.borders.outline import Outline
from frontage.openings.wall.crossings import CrossingBeams
from frontage.openings.wall.evidence import WALL

_MIDDLE = 0.2  # share of the width at each side that is left out, for reveals slope as well
_LOWEST = 0.3  # m: slabs and the rails of frames on them are lower
_HIGHEST = 0.5  # share of the height that a slope has at most
_ROWS = 6  # of equal height, in each of which masonry shows
_STEP = 0.02  # m between the tops of slopes that are tried
_UNEVEN = 2.0  # three sigmas of a wall by which the stones of a slope lie off its plane
_RISE = 4.0  # times that much a slope leads into the wall: less is as well a step
_ON = 0.9  # share of the points that lie on the slope; profiles of frames and slabs have steps
_BEHIND = 0.8  # share of the points above the slope that lie on the pane
_FEW = 20  # points that a slope needs


def with_sill(outline: Outline, beams: CrossingBeams) -> Outline:
    """Returns the outline with its foot where its sill ends; the outline itself where no sill rises.

    `beams` are those of the wall around it, or more.
    """
    x0, z0, x1, z1 = outline.place
    wide = beams.around(outline.place, AROUND)
    near = wide if outline.wall is None else wide.behind(outline.wall)
    x, z = near.points
    inset = _MIDDLE * (x1 - x0)
    some = (x > x0 + inset) & (x < x1 - inset) & (z > z0) & (z < z1) & (near.depth > -near.wall)
    z, depth = z[some] - z0, near.depth[some]
    least, off = WALL * density_beside(near, outline.place) * (x1 - x0 - 2.0 * inset), _UNEVEN * near.wall
    found = [
        slope
        for top in np.arange(_LOWEST, _HIGHEST * (z1 - z0), _STEP)
        if (slope := _slope(z, depth, float(top), off, max(least * top, _FEW))) is not None
    ]
    if not found:
        return outline
    _, top, sigma = max(found)
    left, right, foot, head = outline.borders
    above = outline.with_foot(z0 + top, sigma)
    return replace(
        above,
        borders=(left, right, replace(foot, at=z0 + top, sigma=sigma), head),
        depth=find_depth(wide, above.place, above.rise, 2.0 * max(left.sigma, right.sigma)),
    )


def _slope(z: Float, depth: Float, top: float, off: float, least: float) -> tuple[int, float, float] | None:
    """Returns how many points a slope up to about `top` m explains, where it meets the pane, and its sigma.

    z, depth  (n,) m, of the points above the foot and behind the wall
    off       m by which points may lie off
    least     points that masonry would return at least

    Returns None where the points do not rise from the wall to a pane above the slope.
    """
    below, above = z < top, (z >= top) & (z < 2.0 * top)
    rows = np.bincount((z[below] / top * _ROWS).astype(np.int64), minlength=_ROWS)
    if _ROWS * rows.min() < least or above.sum() < _FEW:
        return None
    pane = float(np.median(depth[above]))
    rate, start = np.polyfit(z[below], depth[below], 1)
    if rate * top < _RISE * off or abs(start) > MASONRY.panel or abs(start + rate * top - pane) > off:
        return None
    apart = depth[below] - (start + rate * z[below])
    on, behind = np.abs(apart) < off, np.abs(depth[above] - pane) < off
    if on.mean() < _ON or behind.mean() < _BEHIND:
        return None
    sigma = float(apart[on].std()) / rate * np.hypot(1.0 / np.sqrt(on.sum()), TOLERANCES.common_noise)
    return int(on.sum() + behind.sum()), (pane - start) / rate, float(sigma)
