"""Finds narrow strips of wall between two openings: they are narrower than any pier of brick.

Bars that are level with the wall belong to joinery that is level with it. Where the frames on both sides lie
behind a strip that is level with the wall, it is part of the wall: a mullion of stone or concrete.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float, rising
from frontage.model.masonry import MASONRY
from frontage.openings.boxes import Box
from frontage.openings.layout.joinery import (
    FULL,
    JoineryPlane,
    beside,
    due_in,
    points_within,
)
from frontage.openings.layout.posts import Post, same_on_most
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.evidence import BEAMS_TO_DECIDE, Evidence

_LONG = 0.3  # m: openings are at least as high and wide, and so are the strips between them
_NARROW = 0.07  # m: cover strips, bars of grilles and rails of railings are narrower
_PROUD = 0.04  # m that cover strips stand out from the joinery behind them at most
_FRAME = 0.04  # m beside a strip that the frame behind it fills
_ROW = 0.1  # m, height of the rows in which panes are open or filled
_UPRIGHT, _LYING = slice(None), slice(None, None, -1)  # the order of x and z, along and across a strip


def find_strips(
    beams: Beams, planes: Sequence[JoineryPlane], evidences: Sequence[Evidence]
) -> tuple[Post, ...]:
    """Finds the upright and lying strips of wall between openings, as posts that are level with the wall.

    A strip shows a frame that lies behind it on one side at least, or lies in one line with such a strip.
    `evidences` are those of the wall on several rasters, most of which must show a strip. Only known lines of
    sight tell strips from what stands before an opening.
    """
    if not beams.rays:
        return ()
    frames = [plane.own for plane in planes if plane.depth > _PROUD]
    found: list[Post] = []
    for turn in (_UPRIGHT, _LYING):
        through = _sorted(np.vstack([beams.open.T[turn], beams.open_depth]))
        solid, joinery = _sorted(beams.solid.T[turn]), [_sorted(own[turn]) for own in frames]
        rasters = [
            [(_level_post(beams, _turned(box, turn)), is_framed) for box, is_framed in strips]
            for strips in (_strips(solid, through, joinery, evidence, turn) for evidence in evidences)
        ]
        sure = _on_most([[post for post, is_framed in posts if is_framed] for posts in rasters])
        likely = _on_most([[post for post, _ in posts] for posts in rasters])
        found += sure
        found += [
            p for p in likely if any(_in_line(p, s, turn) for s in sure) and not any(p.meets(s) for s in sure)
        ]
    return tuple(found)


def _level_post(beams: Beams, box: Box) -> Post:
    """Returns a strip of wall as a post that is level with the wall."""
    return Post(*box, beams.depth_at(*_middle(box)).item(), level=True)


def _on_most(rasters: Sequence[Sequence[Post]]) -> list[Post]:
    """Returns the strips that most rasters show, as the first of them shows them."""
    return [rasters[k][number] for (k, number), *_ in same_on_most(rasters)]


def _in_line(post: Post, other: Post, turn: slice) -> bool:
    """Returns whether two strips lie in one line: most of their widths is the same."""
    (a0, _, a1, _), (b0, _, b1, _) = (_turned((p.x0, p.z0, p.x1, p.z1), turn) for p in (post, other))
    return 2.0 * (min(a1, b1) - max(a0, b0)) > max(a1 - a0, b1 - b0)


def _turned(box: Box, turn: slice) -> Box:
    """Returns a box with x and z in the order of a direction."""
    x0, z0, x1, z1 = box
    return (z0, x0, z1, x1) if turn == _LYING else box


def _middle(box: Box) -> tuple[Float, Float]:
    """Returns the place (1,), (1,) m of the middle of a box."""
    return np.array([(box[0] + box[2]) / 2.0]), np.array([(box[1] + box[3]) / 2.0])


def _strips(
    solid: Float, through: Float, joinery: Sequence[Float], evidence: Evidence, turn: slice
) -> Iterator[tuple[Box, bool]]:
    """Yields the strips x0, z0, x1, z1 m of one direction; for lying ones x and z change places.

    Each comes with whether its ends meet wall and a frame lies behind it.

    `solid` (2, n) m are the places of the points on the wall, `through` (3, m) m those of the beams that
    crossed it, with the depths where they ended, and `joinery` (2, k) m those of the points on planes of
    joinery. All are sorted along the first axis.
    """
    cell, corner = evidence.raster.cell, np.tile(evidence.raster.corner[turn], 2)
    long = max(round(_LONG / cell), 3)
    open_ = _open_along(evidence.llr.T if turn == _LYING else evidence.llr, long)
    thick = int(MASONRY.half_brick / cell) + 3  # one cell at either border may be wall in part
    between = ndimage.binary_closing(open_, np.ones((1, thick), np.bool_)) & ~open_
    between = ndimage.binary_closing(between, np.ones((long, 1), np.bool_))  # noise interrupts it
    for rows, columns in ndimage.find_objects(ndimage.label(between)[0]):
        ends = [open_[max(r, 0) : r + 2, columns] for r in (rows.start - 2, rows.stop)]
        if (rows.stop - rows.start) * cell < _LONG:
            continue
        ends_in_wall = not any(end.all() for end in ends if end.size)
        x0, z0, x1, z1 = (
            corner + np.array([columns.start, rows.start, columns.stop, rows.stop]) * cell
        ).tolist()
        due = due_in(evidence, _turned((x0, z0, x1, z1), turn))
        across = _across(solid, through, (x0 - cell, z0, x1 + cell, z1), due) if due > 0.0 else None
        if across is None or not _NARROW <= across[1] - across[0] <= MASONRY.half_brick + cell:
            continue
        x0, x1 = across
        panes = [(a, z0, b, z1) for a, b in beside(x0, x1)]
        if not all(_is_deep(pane, solid, through) for pane in panes):
            continue
        sides = [(x0 - _FRAME, z0, x0, z1), (x1, z0, x1 + _FRAME, z1)]
        is_framed = ends_in_wall and any(
            _is_frame(own, side, pane, due)
            for own in joinery
            for side, pane in zip(sides, panes, strict=True)
        )
        yield (x0, z0, x1, z1), is_framed


def _is_deep(pane: Box, solid: Float, through: Float) -> bool:
    """Decides whether most beams cross a pane and end deep behind the wall.

    `solid` (2, n) m are the places of the points on the wall, and `through` (3, m) m those of the beams that
    crossed it, with the depths where they ended. Both are sorted along the first axis.
    """
    own = points_within(through, pane)[2]
    shut = points_within(solid, pane).shape[1]
    enough = len(own) >= max(BEAMS_TO_DECIDE, (1.0 / FULL - 1.0) * shut)
    return bool(enough and np.median(own) > _PROUD)


def _is_frame(own: Float, side: Box, pane: Box, due: float) -> bool:
    """Decides whether joinery fills a `side` of a strip along the rows where the `pane` beside it is open.

    Rails and blinds fill the rows of several panes one above the other. `own` (2, n) m are the places of the
    points on a plane of joinery, sorted along the first axis. A wall returns `due` beams per m2.
    """
    _, z0, _, z1 = pane
    number = max(int((z1 - z0) / _ROW), 1)
    shares = [_shares(own, box, due, number) for box in (side, pane)]
    free = shares[1] < FULL
    return bool(free.sum() * (z1 - z0) / number >= _LONG and shares[0][free].mean() > FULL)


def _shares(own: Float, box: Box, due: float, number: int) -> Float:
    """Returns how many beams ended in each of `number` rows of a box, as a share of those expected there."""
    x0, z0, x1, z1 = box
    counts = np.histogram(points_within(own, box)[1], number, (z0, z1))[0]
    return np.asarray(counts * number / (due * (x1 - x0) * (z1 - z0)))


def _open_along(llr: Float, number: int) -> Bool:
    """Returns the cells (h, w) that are open as seen over a `number` of cells along a strip."""
    return np.asarray(ndimage.uniform_filter1d(llr, number, axis=0) > 0.0)


def _across(solid: Float, through: Float, around: Box, due: float) -> tuple[float, float] | None:
    """Returns the left and right border m of the strip of wall in a box; None if no beam tells of it.

    It is as wide as the sum over the box of the shares of beams that ended on the wall. The others crossed it
    at the places `through` (3, m); both are sorted along the first axis. A wall returns `due` beams per m2.
    """
    x0, _, x1, _ = around
    number = max(int((x1 - x0) * np.sqrt(due)), 1)
    ended, passed = (
        np.histogram(points_within(some, around)[0], number, (x0, x1))[0] for some in (solid, through)
    )
    share = ended / np.maximum(ended + passed, max(float(np.median(ended + passed)), 1.0))
    wide, middle = share.sum(), share @ (np.arange(number) + 0.5)
    if wide == 0.0:
        return None
    step = (x1 - x0) / number
    return x0 + (middle / wide - wide / 2) * step, x0 + (middle / wide + wide / 2) * step


def _sorted(places: Float) -> Float:
    """Returns places (k, n) in the order of the first axis."""
    return places[:, rising(places[0])]
