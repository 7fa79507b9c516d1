"""Tells the gaps of a balustrade on top of a wall from openings: balusters stand in a row below a rail."""

from collections.abc import Sequence

import numpy as np
import shapely

from frontage.model.masonry import MASONRY
from frontage.model.scan import Scan
from frontage.openings.boxes import Box
from frontage.openings.flights import points_before
from frontage.openings.lintels import goes_on_above, is_covered
from frontage.openings.observe import ObservedWall

_RAIL_M = 1.0  # m above a balustrade where the facade has ended
_SKY_M, _COLUMNS = 2.0, 9  # m above that where walls around a niche would show, in most of so many columns
_NEAR_M = 0.15  # m off the depth of the wall within which balusters stand
_PITCH_M = 0.6  # m between balusters at most
_LONG = 1.25  # times its height that a balustrade is long at least, unlike casements with bars
_FEWEST = 4  # balusters that make a row
_QUARTERS = 4  # parts of the height, of which those of the upper half show the posts; the foot may be hidden
_COLUMN_M, _SPACINGS = 0.05, 2.0  # width of the columns that tell balusters from gaps, m and spacings
# share of the fullest column that tells a baluster from a gap, and the fewest points that it has
_HELD, _TOLD = 0.3, 10


def are_balustrades(places: Sequence[Box], wall: ObservedWall, scan: Scan) -> list[bool]:
    """Returns which places are balustrades at the upper end of a wall, with nothing but sky above their rail.

    Points at the depth of the wall stand there in a row of posts, close together, that reach up to the rail.
    Grilles of windows have wall above them, and railings before windows end halfway up.
    """
    ring = shapely.make_valid(shapely.Polygon(wall.facade.outline))
    rows = [not goes_on_above(ring, place, _RAIL_M) and _is_row_of_posts(wall, place) for place in places]
    if not any(rows):
        return rows
    before = points_before(wall.facade, scan, MASONRY.relief)
    sky = (_RAIL_M, _RAIL_M + _SKY_M)
    told = zip(rows, places, strict=True)
    return [is_row and not is_covered(before, place, sky, _COLUMNS) for is_row, place in told]


def _is_row_of_posts(wall: ObservedWall, place: Box) -> bool:
    """Returns whether the points at the depth of the wall in a place stand in posts close together."""
    x0, z0, x1, z1 = place
    x, y, z = wall.beams.points.T
    inside = (x > x0) & (x < x1) & (z > z0) & (z < z1)
    x, y, z = x[inside], y[inside], z[inside]
    near = np.abs(y - wall.beams.depth_at(x, z)) < _NEAR_M
    wide = max(_COLUMN_M, _SPACINGS * wall.facade.spacing)
    held = np.histogram(x[near], max(int((x1 - x0) / wide), 3), (x0, x1))[0][1:-1]  # without jambs
    if held.max() < _TOLD:
        return False
    posts = held > _HELD * held.max()
    number = int(posts[0]) + int((posts[1:] & ~posts[:-1]).sum())
    if number < _FEWEST or not _LONG * (z1 - z0) < x1 - x0 < _PITCH_M * number:
        return False
    low, high = z0 + wide, z1 - wide  # without foot and rail
    if low >= high:  # too low for columns this wide to tell where the posts end
        return True
    filled = np.histogram(z[near], _QUARTERS, (low, high))[0]
    return bool((filled[_QUARTERS // 2 :] > _HELD * filled.max()).all())
