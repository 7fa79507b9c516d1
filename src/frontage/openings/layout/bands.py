"""Bands of windows without masonry between them: finds the posts of joinery that part them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float
from frontage.model.masonry import MASONRY
from frontage.openings.layout.joinery import (
    COLUMNS,
    FULL,
    SHADED,
    JoineryPlane,
    beside,
    frame_above,
    frame_below,
    is_wall_beside,
    post_borders,
)
from frontage.openings.layout.posts import Post, same_on_most
from frontage.openings.wall.evidence import Evidence
from frontage.openings.wall.raster import opened

_TALL = 0.3  # m: as windows are at least; lower pieces are rails and panels
_WIDE = 0.6  # m: leaves of doors are wider than posts
_FRAMES = 1.7  # widths of the frame above: windows side by side have one each, casements that meet less
# m: the windows of a band are at least as wide; leaves of one window that meet at a post are narrower
_WINDOW = 0.9
_GAP = 0.15  # m between a post and the wall above and below it
_STEEP = 2.0  # m that sills hide per m of depth
_HIDDEN = 0.5  # share of the expected beams that come at most where something before the wall hides a sill


@dataclass(frozen=True, eq=False)
class _Cells:
    """One raster of a wall: beams per cell (h, w), averaged over half a brick, and which cells are wall.

    solid  beams that ended on the wall
    due    beams that a wall would return
    wall   columns of wall that are as wide as a pier
    """

    evidence: Evidence
    solid: Float
    due: Float
    wall: Bool

    @classmethod
    def of(cls, evidence: Evidence) -> "_Cells":
        """Averages the beams of one raster."""
        pier = max(int(MASONRY.half_brick / evidence.raster.cell), 1)
        # a blade that is seen from the side returns many beams to one cell, and is no pier
        most = np.maximum(evidence.expected, 1.0)
        solid, due = _evened(np.minimum(evidence.solid, most)), _evened(evidence.expected)
        return cls(evidence, solid, due, opened(solid > FULL * np.maximum(due, 1e-9), (1, pier)))


@dataclass(frozen=True)
class _Found:
    """A post that stands between two frames as one raster shows it.

    frames  m, widths of the frames above the panes on the left and on the right
    like    m, places x of the uprights like it
    rail    the rail that it stands on; None where it has a sill
    """

    post: Post
    frames: tuple[float, float]
    like: list[float]
    rail: Post | None

    @property
    def is_wide(self) -> bool:
        """Whether the post is as wide as two frames, and as the least pier."""
        least = max(MASONRY.half_brick, _FRAMES * float(np.mean(self.frames)))
        return self.post.x1 - self.post.x0 >= least


def find_posts(
    planes: Sequence[JoineryPlane], evidences: Sequence[Evidence], ground: float
) -> tuple[Post, ...]:
    """Finds the posts and rails that separate windows; `ground` is the height z m of the ground.

    A window has posts of its own where casements meet: they are narrower than two frames side by side, or its
    leaves are narrower than windows. Some windows stand neither on a sill nor on the ground, but on the head
    of a passage, for example. There the rail of their frames separates them from what is below. `evidences`
    are those of the wall on several rasters. What stands on most of them is as wide as they show on average.
    """
    rasters = [_Cells.of(evidence) for evidence in evidences]
    found = [one for one in _on_most([_find(planes, cells, ground) for cells in rasters]) if one.is_wide]
    posts, finest = [one.post for one in found], rasters[0]
    kept = [one for one in found if _room(one.post, posts, one.like, finest.wall, finest.evidence) >= _WINDOW]
    return tuple(post for one in kept for post in (one.post, one.rail) if post is not None)


def _on_most(rasters: Sequence[Sequence[_Found]]) -> Iterator[_Found]:
    """Yields the means of the posts that stand on most rasters."""
    for numbers in same_on_most([[one.post for one in found] for found in rasters]):
        seen = [rasters[k][number] for k, number in numbers]
        left, right = np.mean([one.frames for one in seen], axis=0).tolist()
        rails = [one.rail for one in seen if one.rail is not None]
        rail = _mean_post(rails) if 2 * len(rails) > len(seen) else None
        yield _Found(_mean_post([one.post for one in seen]), (left, right), seen[0].like, rail)


def _mean_post(posts: Sequence[Post]) -> Post:
    """Returns the mean of the same post on several rasters."""
    x0, z0, x1, z1, y = np.mean([(p.x0, p.z0, p.x1, p.z1, p.y) for p in posts], axis=0).tolist()
    return Post(x0, z0, x1, z1, y, level=posts[0].level)


def _find(planes: Sequence[JoineryPlane], cells: _Cells, ground: float) -> list[_Found]:
    """Finds the posts on one raster, whatever their widths."""
    evidence, wall = cells.evidence, cells.wall
    shaded, free = SHADED * cells.due, (evidence.expected > 0.0) & ~wall
    found: list[_Found] = []
    for plane in planes:
        ended = cells.solid + _evened(evidence.raster.count(*np.hstack(plane.stopped[1:])))
        passed = _evened(evidence.raster.count(*plane.beyond))
        full = (ended > FULL * (ended + passed)) & (ended > shaded) & free
        pieces = list(_uprights(full, evidence.raster.cell))
        for part in pieces:
            seen = _post(plane, part, wall, evidence, ground)
            if seen is None or any(seen[0].meets(other.post) for other in found):
                continue
            post, frames, high = seen
            like = [] if evidence.rays else _like(post, plane, pieces, evidence)
            rail = _rail(post, high, full, wall, evidence) if high else None
            found.append(_Found(post, frames, like, rail))
    return found


def _evened(values: Float) -> Float:
    """Averages values (h, w) over half a brick: columns of points from several stations heap up."""
    return np.asarray(cv2.blur(values, (COLUMNS, 3), borderType=cv2.BORDER_CONSTANT))


def _uprights(full: Bool, cell: float) -> Iterator[tuple[slice, slice]]:
    """Yields the rows and columns of tall and narrow pieces of the cells (h, w) that a plane fills.

    They come from below, of those that begin in the same row the widest first.
    """
    tall = opened(full, (max(int(_TALL / cell), 2), 1))
    pieces = ndimage.find_objects(ndimage.label(tall)[0])
    for rows, columns in sorted(pieces, key=lambda p: (p[0].start, p[1].start - p[1].stop)):
        if MASONRY.half_brick - cell <= (columns.stop - columns.start) * cell <= _WIDE:
            yield rows, columns


def _like(
    post: Post, plane: JoineryPlane, uprights: list[tuple[slice, slice]], evidence: Evidence
) -> list[float]:
    """Returns the middles x m of the uprights beside a post that are wider than one of its two frames.

    Of equal mullions some seem as wide as two frames and some do not, but all of them part leaves. Where
    lines of sight are known, the beams that pass tell their widths, and this is not asked.
    """
    found = []
    for rows, columns in uprights:
        x0, z0, x1, z1 = piece = evidence.raster.box(rows.start, columns.start, rows.stop, columns.stop)
        apart = x0 > post.x1 or x1 < post.x0
        if apart and min(z1, post.z1) - max(z0, post.z0) > (post.z1 - post.z0) / 2.0:
            across = post_borders(plane, piece, evidence)
            if across is not None and across[1] - across[0] > (post.x1 - post.x0) / _FRAMES:
                found.append((x0 + x1) / 2.0)
    return found


def _post(
    plane: JoineryPlane, part: tuple[slice, slice], wall: Bool, evidence: Evidence, ground: float
) -> tuple[Post, tuple[float, float], float] | None:
    """Returns the post in a part of the cells, the widths m of the frames beside it, and its rail's height m.

    A post runs from a sill, or a rail of the frames beside it, to a lintel. Returns None if it is not one.
    """
    (rows, columns), cell, z = part, evidence.raster.cell, evidence.raster.corner[1]
    middle = slice((columns.start + columns.stop - 1) // 2, (columns.start + columns.stop) // 2 + 1)
    below = slice(max(rows.start - int((_GAP + _STEEP * plane.depth) / cell) - 1, 0), rows.start)
    above = wall[rows.stop : rows.stop + int(_GAP / cell) + 2, middle].any(1)
    due, free = (m[below, middle][::-1].sum(1) for m in (evidence.expected, evidence.expected_free))
    hidden = due < _HIDDEN * free
    sill = wall[below, middle][::-1].any(1) & ~hidden
    veiled = due.sum() < _HIDDEN * free.sum()
    low = z + rows.start * cell < ground + MASONRY.threshold
    piece = evidence.raster.box(rows.start, columns.start, rows.stop, columns.stop)
    if not above.any() or any(is_wall_beside(side, piece, evidence) for side in beside(piece[0], piece[2])):
        return None
    lintel = piece[3] + int(above.argmax()) * cell
    across = post_borders(plane, piece, evidence)
    if across is None:
        return None
    sides = beside(*across)
    if (left := frame_above(plane, sides[0], piece, lintel, evidence)) is None:
        return None
    if (right := frame_above(plane, sides[1], piece, lintel, evidence)) is None:
        return None
    stands = sill.any() or low or veiled
    rails = [] if stands else [frame_below(plane, side, piece, evidence) for side in sides]
    if None in rails:
        return None
    foot = int(sill.argmax()) if sill.any() else _hidden_foot(hidden) if veiled else 0
    post = Post(across[0], piece[1] - foot * cell, across[1], lintel, plane.y)
    return post, (left, right), max((r or 0.0 for r in rails), default=0.0)


def _rail(post: Post, high: float, full: Bool, wall: Bool, evidence: Evidence) -> Post:
    """Returns the rail, `high` m, at the foot of a post, as far as cells are `full` of joinery or blades.

    Cells of `wall` that are as wide as a brick is long are a pier.
    """
    cell, (x, z) = evidence.raster.cell, evidence.raster.corner
    row, column = int((post.z0 + high / 2.0 - z) / cell), int((post.middle - x) / cell)
    pier = ndimage.binary_opening(wall[row], np.ones(int(2.0 * MASONRY.half_brick / cell) + 1, np.bool_))
    line = ndimage.binary_closing(full[row] | wall[row], np.ones(COLUMNS, np.bool_)) & ~pier
    shut = np.flatnonzero(~line)
    k = int(np.searchsorted(shut, column))
    left, right = int(shut[k - 1]) + 1 if k else 0, int(shut[k]) if k < len(shut) else len(line)
    return Post(
        x + left * cell, post.z0 - high / 2.0, x + right * cell, post.z0 + high / 2.0, post.y, level=True
    )


def _hidden_foot(hidden: Bool) -> int:
    """Returns how far down a post reaches if `hidden` cells (n), from its foot downwards, hide its sill."""
    first = int(hidden.argmax())
    return first + int(np.append(hidden[first:], False).argmin())


def _room(post: Post, posts: list[Post], like: list[float], wall: Bool, evidence: Evidence) -> float:
    """Returns the width m of the narrower window beside a post.

    It reaches as far as the next post, the next upright at one of the x m `like` it, or the wall.
    """
    cell, (x, z) = evidence.raster.cell, evidence.raster.corner
    rows = wall[max(int((post.z0 - z) / cell), 0) : int((post.z1 - z) / cell) + 1]
    jambs = x + (np.flatnonzero(rows.mean(0) > FULL) + 0.5) * cell
    others = [p.middle for p in posts if p is not post and min(p.z1, post.z1) > max(p.z0, post.z0)]
    ends = np.concatenate([jambs, others, like, [x, x + wall.shape[1] * cell]])
    return float(np.abs(ends - post.middle).min())
