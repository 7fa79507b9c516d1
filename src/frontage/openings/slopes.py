"""Tells strips of roof between dormers from openings: a surface fills them that slants away from the wall."""

from collections.abc import Sequence

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.masonry import TOLERANCES
from frontage.openings.boxes import Box
from frontage.openings.protrusions.boxes import filled, within
from frontage.openings.protrusions.pieces import fit_slanted_line

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
    """Returns whether most of a place is filled by points (n, 3) m on a plane that leans back."""
    if len(p) < _FEWEST:
        return False
    at, slope, _ = fit_slanted_line(p[:, 2], p[:, 1])
    if slope < np.tan(np.radians(TOLERANCES.parallel_deg)):
        return False
    on = np.abs(p[:, 1] - at - slope * p[:, 2]) <= _TILES_M
    return on.mean() > _MOST and filled(p[on], place, _SPACINGS * spacing) > _MOST
