"""Tells gaps that are open to the sky from openings, which have a lintel, a cornice or a ceiling above."""

from collections.abc import Sequence

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY
from frontage.model.scan import Scan
from frontage.openings.borders.outline import Outline
from frontage.openings.flights import points_before

_ABOVE, _PROBES = 0.1, 9  # m above the top where the facade may go on, and at how many places
_HALF = 0.5  # share of the width that is closed above
_REACH = 1.0  # m above the top within which a cornice or a ceiling lies
_SPACINGS = 3.0  # spacings that a column is wide that tells whether anything lies above it


def have_lintels(outlines: Sequence[Outline], facade: Facade, scan: Scan) -> list[bool]:
    """Returns which outlines show their top, or have the facade or something before it above them.

    The gap between two dormers ends where they do, and so does the facade.
    """
    ring = shapely.make_valid(shapely.Polygon(facade.outline))
    closed = [o.borders[3].is_seen or _goes_on(ring, o) for o in outlines]
    if all(closed):
        return closed
    points = points_before(facade, scan, MASONRY.relief)
    wide = _SPACINGS * facade.spacing
    return [is_closed or _is_covered(points, o, wide) for is_closed, o in zip(closed, outlines, strict=True)]


def _goes_on(ring: shapely.Geometry, outline: Outline) -> bool:
    """Returns whether the outline of the facade goes on above most of an opening."""
    x0, _, x1, z1 = outline.place
    x = np.linspace(x0, x1, _PROBES + 2)[1:-1]
    within: Bool = shapely.contains_xy(ring, x, np.full(_PROBES, z1 + _ABOVE))
    return bool(within.mean() > _HALF)


def _is_covered(points: Float, outline: Outline, wide: float) -> bool:
    """Returns whether points (n, 3) m, sorted by x, lie in most columns, `wide` m wide, above an opening."""
    x0, _, x1, z1 = outline.place
    x, _, z = points[slice(*np.searchsorted(points[:, 0], [x0, x1]))].T
    above = (z > z1) & (z < z1 + _REACH)
    columns = np.linspace(x0, x1, max(1, round((x1 - x0) / wide)) + 1)
    return bool((np.histogram(x[above], columns)[0] > 0).mean() > _HALF)
