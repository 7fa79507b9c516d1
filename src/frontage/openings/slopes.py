"""Tells strips of roof between dormers from openings: a surface fills them that slants away from the wall."""

from collections.abc import Sequence

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.masonry import TOLERANCES
from frontage.openings.boxes import Box
from frontage.openings.protrusions.boxes import within
from frontage.openings.protrusions.pieces import fit_slanted_line
from frontage.raster.gridding import cell_index, cell_quantiles

_TILES_M = 0.05  # m, thickness of a covering of tiles
_SPACINGS = 3.0  # spacings that a cell is wide that tells whether a roof shows in it
_MOST = 0.5  # share of a place that a roof fills at least
_FEWEST = 30  # points that tell a roof


def are_roofs(places: Sequence[Box], points: Float, spacing: float) -> list[bool]:
    """Returns which places on a wall show a roof that begins there and leans back by more than a wall does.

    points (n, 3) m, frame of the facade; spacing m between beams on the wall
    """
    points = points[points[:, 1] > -_TILES_M]
    points = points[np.argsort(points[:, 0], kind="stable")]
    left = np.searchsorted(points[:, 0], [place[0] for place in places])
    right = np.searchsorted(points[:, 0], [place[2] for place in places], "right")
    beside = (points[a:b] for a, b in zip(left, right, strict=True))
    return [
        _is_roof(p[within(p, place, 0.0)], place, spacing) for p, place in zip(beside, places, strict=True)
    ]


def _is_roof(p: Float, place: Box, spacing: float) -> bool:
    """Returns whether most of a place is filled by points (n, 3) m on a plane that leans back.

    Every cell tells one depth, so that the sides of dormers beside a roof, which hold many points in little
    width, do not decide.
    """
    if len(p) < _FEWEST:
        return False
    cell = _SPACINGS * spacing
    shape = int((place[3] - place[1]) / cell) + 1, int((place[2] - place[0]) / cell) + 1
    start = (place[0] + place[2] - shape[1] * cell) / 2.0, place[1]  # alike in a mirrored facade
    at, inside = cell_index((p[:, [0, 2]] - start) / cell, shape)
    (depth,), _ = cell_quantiles(at, p[inside, 1], shape, (0.5,))
    row, column = np.nonzero(np.isfinite(depth))
    height, behind = np.asarray(row * cell, np.float64), depth[row, column]
    foot, slope, _ = fit_slanted_line(height, behind)
    if slope < np.tan(np.radians(TOLERANCES.parallel_deg)):
        return False
    on = np.abs(behind - foot - slope * height) <= _TILES_M
    return bool(on.mean() > _MOST and on.sum() > _MOST * depth.size)
