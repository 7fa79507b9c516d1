"""Tells badly seen openings from chance gaps: real ones have others like them."""

from collections.abc import Sequence

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY
from frontage.openings.borders.gaps import is_opening, shows_most
from frontage.openings.borders.outline import Outline
from frontage.openings.layout.forms import is_known
from frontage.openings.layout.inferred import SAME
from frontage.openings.wall.evidence import BARS

_ENOUGH = 3  # borders of four that tell a rectangle by themselves, as of small openings
_PROVED = 1  # the same where lines of sight prove that the wall is open
_BESIDE, _PROBES = 0.1, 9  # m beside a side where its jamb is looked for, and at how many places
_HALF = 0.5  # share of these places that are jamb


def are_openings(outlines: Sequence[Outline]) -> list[bool]:
    """Returns which outlines are openings by themselves, or because another one is.

    The frame of a small window may be no deeper than the panels of a wall. An outline that shows its frame
    and most of its borders is an opening if a sure one above, below or beside it is as wide and as high.
    Where lines of sight are not known, an outline behind which nothing shows needs such a one as well,
    because dark or wet masonry returns nothing either. Where nothing shows behind any, two that are alike
    tell each other.
    """
    places = np.array([o.place for o in outlines]).reshape(-1, 4)
    alone = np.array([is_opening(o) for o in outlines], np.bool_)
    shown = np.array([o.has_rays or o.depth is not None or o.behind > BARS for o in outlines], np.bool_)
    framed = np.array([o.depth is not None and shows_most(o) for o in outlines], np.bool_)

    def like(some: Bool, others: Bool) -> list[int]:
        """Returns which of some outlines (n,) are like one of the others (n,)."""
        numbers = np.flatnonzero(others)
        return [
            k for k in np.flatnonzero(some).tolist() if _has_like(outlines[k], places[numbers[numbers != k]])
        ]

    told, empty = alone & shown, alone & ~shown
    if not told.any():
        told[like(empty, empty)] = True
    while more := like(empty & ~told, told):
        told[more] = True
    told[like(framed & ~alone, told)] = True
    return [bool(t) for t in told]


def have_jambs(outlines: Sequence[Outline], facade: Facade) -> list[bool]:
    """Returns which outlines are as wide as a pier, or have the facade on both sides.

    The sides of a column that stands in the outline of a facade recede, and look like slots beside it. What
    is wider than a pier may be a shop window at the end of a front.
    """
    ring = shapely.make_valid(shapely.Polygon(facade.outline))
    along = np.linspace(0.0, 1.0, _PROBES)
    jambs = []
    for outline in outlines:
        x0, z0, x1, z1 = outline.place
        z = z0 + along * (z1 - z0)
        sides = (shapely.contains_xy(ring, x, z).mean() for x in (x0 - _BESIDE, x1 + _BESIDE))
        jambs.append(x1 - x0 >= MASONRY.pier or min(sides) > _HALF)
    return jambs


def odd_heads(outlines: Sequence[Outline]) -> list[int]:
    """Returns the numbers of the outlines with curved heads that have more flat ones like them.

    Those above, below and beside them count that are as wide and as high. Frames that return beams in their
    corners, and panes that do not, make a gap look round. Outlines that show none of their borders are left
    out, because their rows complete them.
    """
    places = np.array([o.place for o in outlines]).reshape(-1, 4)
    flat = np.array([o.shape == "rectangle" for o in outlines], np.bool_)
    odd = []
    for k in np.flatnonzero(~flat).tolist():
        like = _are_like(outlines[k], places)
        shown = any(b.is_seen for b in outlines[k].borders)
        if shown and (like & flat).sum() > (like & ~flat).sum():
            odd.append(k)
    return odd


def without_unsupported(outlines: Sequence[Outline | None], ground: float) -> list[Outline | None]:
    """Returns the outlines with None for those that neither their borders nor other openings tell.

    Shadows, leaves and lost points leave gaps whose rectangles end anywhere. What has fewer than three known
    borders is an opening if a better known one beside, above or below it is as wide and as high. The foot of
    a door is known by the `ground` (height z m) that it stands on. Beams that went through the wall prove
    that it is open; where such lines of sight are known, one border is enough.
    """
    told = [o for o in outlines if o is not None]
    known = np.array([_number_known(o, ground) >= _ENOUGH for o in told], np.bool_)
    places = np.array([o.place for o in told]).reshape(-1, 4)
    return [o if o is None or _is_told(o, places[known], ground) else None for o in outlines]


def _number_known(outline: Outline, ground: float) -> int:
    """Returns the number of borders that are known, the foot of a door on the ground included."""
    known = is_known(outline)
    known[2] |= outline.place[1] <= ground + MASONRY.threshold
    return int(known.sum())


def _is_told(outline: Outline, known: Float, ground: float) -> bool:
    """Returns whether an outline is told by enough of its borders, or by `known` boxes (n, 4) like it."""
    enough = _PROVED if outline.has_rays else _ENOUGH
    return _number_known(outline, ground) >= enough or _has_like(outline, known)


def _has_like(outline: Outline, others: Float) -> bool:
    """Returns whether one of the boxes (n, 4) m is the outline's own, moved along its row or column."""
    return bool(_are_like(outline, others).any())


def _are_like(outline: Outline, others: Float) -> Bool:
    """Returns which boxes (n, 4) m are the outline's own, moved along its row or column."""
    low, high = np.array(outline.place[:2]), np.array(outline.place[2:])
    size, other = high - low, others[:, 2:] - others[:, :2]
    shared = np.clip(np.minimum(high, others[:, 2:]) - np.maximum(low, others[:, :2]), 0.0, None)
    least = np.minimum(size, other)
    in_row = least[:, 0] * shared[:, 1]  # moved along the row, one lies within the width of the other
    in_column = shared[:, 0] * least[:, 1]
    both = np.maximum(in_row, in_column)
    return np.asarray(both > SAME * (size.prod() + other.prod(1) - both))
