"""Checks measured borders against the evidence that the openings were found by."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.ring import ring_contains
from frontage.openings.borders.outline import Outline
from frontage.openings.boxes import Box
from frontage.openings.wall.evidence import BEAMS_TO_DECIDE, SHADED, Evidence

_SLACK = 3.0  # cells by which a measured border may lie off the border of cells without a check
_AGAINST = 12.0  # nats that must speak against the strip between the two borders: the price of an opening
_ERROR = 2.0  # cells, one sigma of a border of cells
_ORDER = (0, 2, 1, 3)  # index of left, bottom, right and top among the borders


def with_supported_borders(outline: Outline, rough: Box, evidence: Evidence) -> Outline:
    """Puts those borders back to their rough places whose measured places the evidence speaks against.

    A border that was moved outwards over cells of wall, or inwards over open ones, was drawn there by
    something else: a room behind the wall, the edge of a shadow. An outline with such a border is not a
    circle; of a circle's box only what lies within the circle counts. The tops of other curved heads are left
    alone, for the wall shows beside them.
    """
    circle = outline.shape == "circle"
    last = 4 if circle or outline.shape == "rectangle" else 3
    wrong = [side for side in range(last) if _against(side, rough, outline, evidence)]
    return with_rough_borders(outline, rough, wrong, evidence.raster.cell) if wrong else outline


def with_rough_borders(outline: Outline, rough: Box, sides: Collection[int], cell: float) -> Outline:
    """Returns the outline with the borders on some `sides` (0 left, 1 bottom, 2 right, 3 top) as in `rough`.

    `cell` m is the side of the cells that `rough` was found in. A circle becomes a rectangle, and so does a
    curved head whose top is put back.
    """
    circle = outline.shape == "circle"
    place, covariance, borders = list(outline.place), outline.covariance.copy(), list(outline.borders)
    for side in range(4) if circle else sides:
        k = _ORDER[side]
        # the border lies at either of the two places with equal probability
        sigma = float(np.hypot(_ERROR * cell, (place[side] - rough[side]) / np.sqrt(2.0)))
        place[side] = rough[side]
        covariance[k, :] = covariance[:, k] = 0.0
        covariance[k, k] = sigma**2
        borders[k] = replace(borders[k], at=rough[side], sigma=sigma, gain=0.0)
    x0, z0, x1, z1 = place
    straight = circle or 3 in sides or z1 - outline.rise <= z0
    if straight:
        covariance[4, :] = covariance[:, 4] = 0.0
    return replace(
        outline,
        shape="rectangle" if straight else outline.shape,
        place=(x0, z0, x1, z1),
        rise=0.0 if straight else outline.rise,
        covariance=covariance,
        borders=tuple(borders),
    )


def is_head_open(outline: Outline, rough: Box, evidence: Evidence) -> bool:
    """Returns whether no wall shows between a curved head and the `rough` box around it.

    What stands in the corners of such an opening is joinery, which returns as little as bars do.
    """
    if outline.rise <= 0.0:
        return False
    x0, _, x1, z1 = rough
    cells = evidence.raster.cells((x0, outline.place[3] - outline.rise, x1, z1))
    outside = ~ring_contains(outline.bare_ring, _middles(cells, evidence))
    solid, due = (float(m[cells].ravel()[outside].sum()) for m in (evidence.solid, evidence.expected))
    return due >= BEAMS_TO_DECIDE and solid < SHADED * due


def _against(side: int, rough: Box, outline: Outline, evidence: Evidence) -> bool:
    """Returns whether the evidence between a rough side and the measured one speaks against the latter."""
    axis, at = side % 2, outline.place[side]
    if abs(at - rough[side]) <= _SLACK * evidence.raster.cell:
        return False
    strip = list(rough)
    strip[axis], strip[axis + 2] = sorted((at, rough[side]))
    cells = evidence.raster.cells((strip[0], strip[1], strip[2], strip[3]))
    llr = evidence.llr[cells]
    outward = (at < rough[side]) == (side < 2)
    if outward and outline.shape == "circle":
        llr = llr.ravel()[ring_contains(outline.bare_ring, _middles(cells, evidence))]
    gain = float(llr.sum())
    return gain < -_AGAINST if outward else gain > _AGAINST


def _middles(cells: tuple[slice, slice], evidence: Evidence) -> Float:
    """Returns the middles (n, 2) x, z m of cells, row by row."""
    own = np.zeros(evidence.raster.shape, np.bool_)
    own[cells] = True
    return evidence.raster.middles(own)
