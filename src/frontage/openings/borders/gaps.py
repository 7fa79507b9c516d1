"""Tells openings from gaps in the scan of a solid wall: only openings have straight borders all around."""

from frontage.model.masonry import MASONRY
from frontage.openings.borders.outline import Outline
from frontage.openings.wall.evidence import WALL

_SMALL = 0.6  # m: shadows of ledges, joints and pipes leave gaps that are narrower or lower
_SMALL_EMPTY = 0.9  # m: patches that return little leave larger gaps, with no frame or sharp border
_SURELY = 2.0  # sigmas by which a small opening is deeper than a panel
_DEEP = 1 / 3  # share of what lies behind the wall that lies deeper than half a brick: panes and rooms
_SHARE = 0.75  # share of the borders that nothing hides that a small opening shows


def is_opening(outline: Outline) -> bool:
    """Returns whether an outline is that of an opening, not of a gap in the scan of a solid wall.

    Beams that went through the wall prove that it is open, so where lines of sight are known only small
    outlines are judged: one border must show, as it does not where a few beams end behind the top of a wall,
    and without a depth three of four, as they do not at the rim of a scan. Without lines of sight, gaps have
    some straight borders as well: along the ledge or the pipe that throws the shadow. What is no larger than
    such gaps is an opening only if its frame shows, if it is deeper than sunken ornaments and blind niches or
    returns less than their masonry does, and if it shows three of its four borders beyond doubt, or, where
    something stands before others, two and most of those left. It is deeper if its frame surely lies behind
    the panels of a wall, or if a third of what lies behind the wall is more than half a brick behind it. Of
    larger outlines, one border or the frame is enough: a scan leaves few gaps of that size in a wall that
    have the form of a rectangle and wall around. Where the frame does not show, most borders must, unless the
    outline is larger than the patches that return little. Where neither shows, points are merely missing, as
    behind the ledges of a frieze.
    """
    x0, z0, x1, z1 = outline.place
    size, depth = min(x1 - x0, z1 - z0), outline.depth
    seen = any(b.is_seen for b in outline.borders)
    if outline.has_rays:
        return size >= _SMALL or shows_most(outline) or (depth is not None and seen)
    if depth is None:
        return (size >= _SMALL_EMPTY and seen) or (size >= _SMALL and shows_most(outline))
    if size >= _SMALL:
        return True
    is_deep = outline.sunken > _DEEP or depth.value - _SURELY * float(depth.sigma[0]) >= MASONRY.panel
    return shows_most(outline) and (is_deep or outline.behind < WALL)


def shows_most(outline: Outline) -> bool:
    """Returns whether most borders show beyond doubt: three of four, or two where others are hidden."""
    seen = sum(b.is_seen for b in outline.borders)
    hidden = sum(b.is_hidden for b in outline.borders)
    return seen >= max(_SHARE * (len(outline.borders) - hidden), 2.0)
