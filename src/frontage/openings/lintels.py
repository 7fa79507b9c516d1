"""Tells gaps that are open to the sky from openings, which have a lintel, a cornice or a ceiling above."""

from collections.abc import Sequence

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY
from frontage.model.scan import Scan
from frontage.openings.borders.outline import Outline
from frontage.openings.boxes import Box
from frontage.openings.flights import points_before
from frontage.openings.layout.forms import BUILT, is_known
from frontage.openings.layout.groups import BOTTOM, LIKE, WIDTH, borders_of

_ABOVE, _PROBES = 0.1, 9  # m above the top where the facade may go on, and at how many places
_HALF = 0.5  # share of the width that is closed above
_REACH = 1.0  # m above the top within which a cornice or a ceiling lies
_SPACINGS = 3.0  # spacings that a column is wide that tells whether anything lies above it


def have_lintels(outlines: Sequence[Outline], facade: Facade, scan: Scan) -> list[bool]:
    """Returns which outlines show their top, or have the facade or something before it above them.

    The gap between two dormers ends where they do, and so does the facade. Where the scan ends above a row,
    an opening with the width and the sill of another one of it that has a lintel has one, too.
    """
    ring = shapely.make_valid(shapely.Polygon(facade.outline))
    closed = [o.borders[3].is_seen or goes_on_above(ring, o.place, _ABOVE) for o in outlines]
    if all(closed):
        return closed
    points = points_before(facade, scan, MASONRY.relief)
    wide = _SPACINGS * facade.spacing
    number = [max(1, round((o.place[2] - o.place[0]) / wide)) for o in outlines]
    told = zip(closed, outlines, number, strict=True)
    closed = [is_closed or is_covered(points, o.place, (0.0, _REACH), n) for is_closed, o, n in told]
    others = [o for o, is_closed in zip(outlines, closed, strict=True) if is_closed]
    return [c or any(_is_in_row(o, other) for other in others) for c, o in zip(closed, outlines, strict=True)]


def _is_in_row(outline: Outline, other: Outline) -> bool:
    """Returns whether an outline is known to be as wide as another one and to begin at the same height."""
    if not (is_known(outline)[:3].all() and is_known(other)[:3].all()):
        return False
    size = np.stack([WIDTH, BOTTOM])
    off = np.abs(size @ np.subtract(*borders_of([outline, other])))
    covariance = outline.covariance[:4, :4] + other.covariance[:4, :4]
    error = np.sqrt(np.diagonal(size @ covariance @ size.T) + BUILT**2)
    return bool((off < LIKE * error).all())


def goes_on_above(ring: shapely.Geometry, place: Box, above: float) -> bool:
    """Returns whether the outline of the facade holds what lies `above` m over most of a place."""
    x0, _, x1, z1 = place
    x = np.linspace(x0, x1, _PROBES + 2)[1:-1]
    within: Bool = shapely.contains_xy(ring, x, np.full(_PROBES, z1 + above))
    return bool(within.mean() > _HALF)


def is_covered(points: Float, place: Box, above: tuple[float, float], number: int) -> bool:
    """Returns whether points (n, 3) m, sorted by x, lie in most of a `number` of columns over a place.

    above  m, between which heights over the upper end of the place
    """
    x0, _, x1, z1 = place
    x, _, z = points[slice(*np.searchsorted(points[:, 0], [x0, x1]))].T
    over = (z > z1 + above[0]) & (z < z1 + above[1])
    return bool((np.histogram(x[over], np.linspace(x0, x1, number + 1))[0] > 0).mean() > _HALF)
