"""Finds the rectangles that may be openings, and the best layout of them."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float, Int
from frontage.model.masonry import MASONRY
from frontage.openings.layout.posts import Post, cells_held_by
from frontage.openings.layout.rejoined import rejoined
from frontage.openings.layout.selection import PRICE, CellBox, best_layout, worth_of
from frontage.openings.options import OpeningOptions
from frontage.openings.wall.evidence import BEAMS_TO_DECIDE, Evidence, local_rate
from frontage.openings.wall.raster import opened

_LINES = 8  # candidate borders that a component as large as the largest opening has in each direction
_LESSER = 0.1  # share of the worth of the best of its component: less is a remnant of an uneven outline
_PIECE = 0.5  # the same share for what bars part: less is a piece of it
_HALF = 0.5  # share of a row that is most of it
_RAIL = 0.1  # m, height of a handrail at most, and of the gap below the balusters
_GAP = 0.12  # m between the bars of a grille: guards of windows and balconies leave no wider gaps
# size of the opening square, and the largest component that is kept, in least openings
_SCALES = ((0.6, 12.0), (1.0, 12.0), (1.7, 12.0), (2.5, 25.0))
_RIBBON = 4.0  # least openings, the square that parts the lights of ribbons from gaps in the wall beside them
_FILLED = 0.8  # share of its box that a larger component fills which is a rectangle
# share of the expected beams that came back from behind the wall where larger components are open
_SEEN = 0.3

_DIGITS = 6  # of nats: sums in another order differ by less, and must not choose between equal rectangles

Part = tuple[slice, slice]


def find_boxes(
    evidence: Evidence,
    options: OpeningOptions,
    framed: Callable[[Int], Bool],
    posts: Sequence[Post] = (),
    densest: float = np.inf,
) -> list[CellBox]:
    """Returns the set of rectangles without overlap that is worth most.

    A rectangle is worth the evidence of its cells less the price of an opening; its borders are lines where
    the evidence of a connected component of open cells changes most. Two windows and their pier compete with
    the window over both. Only rectangles (n, 4) r0, c0, r1, c1 that are `framed` can be openings. Components
    are left out where all cells would hold `densest` beams or more.
    """
    where = evidence.expected_free < densest
    least = (options.min_height / evidence.raster.cell, options.min_width / evidence.raster.cell)
    pier = max(round(MASONRY.half_brick / evidence.raster.cell), 1)
    open_ = evidence.is_open
    if evidence.rays:  # without them, what lies beside an opening may be a shadow
        thick = int(MASONRY.half_brick / evidence.raster.cell) + 1
        open_ = open_ | _bars(open_, thick) | _bars(open_.T, thick).T
        held = cells_held_by(posts, evidence.raster)
        open_ &= ~held
    parts = _components(evidence, least, open_, where)
    found = best_layout(_rivals(evidence, parts, least=least, framed=framed, share=_LESSER), pier)
    if evidence.rays:  # lines of sight tell bars from walls
        return rejoined(found, evidence, held, framed)
    gaps = _between_bars(evidence)
    found = _behind_railings(found, gaps, evidence, least[0], framed)
    behind_bars = _components(evidence, least, gaps, where)
    cells = np.array([(b.r0, b.c0, b.r1, b.c1) for b in found], np.int64).reshape(-1, 4)
    left = [(part, others) for part, others in behind_bars if not _meet(cells, part)]
    return found + best_layout(_rivals(evidence, left, least=least, framed=framed, share=_PIECE), pier)


def _rivals(
    evidence: Evidence,
    parts: Iterable[tuple[Part, Bool]],
    *,
    least: tuple[float, float],
    framed: Callable[[Int], Bool],
    share: float,
) -> list[list[CellBox]]:
    """Returns the rectangles of each component that can be openings and are worth a `share` of its best.

    Components come with the cells of others, which count against them.
    """
    boxes, gains = [np.empty((0, 4), np.int64)], []
    for part, others in parts:
        worth = worth_of(evidence, part)
        own = np.where(others, -np.abs(worth), worth)
        some, gain = _rectangles(own, evidence.expected_free[part], least, evidence.raster.cell)
        boxes.append(some + np.array([s.start for s in part] * 2))
        gains.append(gain)
    can_be = np.split(framed(np.concatenate(boxes)), np.cumsum([len(gain) for gain in gains]))
    found = []
    for some, gain, ok in zip(boxes[1:], gains, can_be, strict=False):
        kept = np.flatnonzero(ok)
        kept = kept[gain[kept] >= share * gain[kept].max(initial=0.0)]
        cells, worths = some[kept].tolist(), gain[kept].tolist()
        found.append([CellBox(r0, c0, r1, c1, w) for (r0, c0, r1, c1), w in zip(cells, worths, strict=True)])
    return found


def _behind_railings(
    boxes: Sequence[CellBox], gaps: Bool, evidence: Evidence, least: float, framed: Callable[[Int], Bool]
) -> list[CellBox]:
    """Lengthens the boxes whose lower parts are hidden by a railing, and returns all boxes.

    Most cells of each row there are open between the balusters, as `gaps` (h, w) tells; a handrail may cross
    them. The railing is at least as high as an opening, no other box lies behind it, and the longer box is
    `framed`.
    """
    rail = int((_RAIL + _GAP) / evidence.raster.cell) + 1  # with half a gap on both sides, which is blurred
    told = np.zeros(gaps.shape, np.bool_)
    for box in boxes:
        told[box.r0 : box.r1, box.c0 : box.c1] = True
    found = []
    for box in boxes:
        columns = slice(box.c0, box.c1)
        is_open = gaps[: box.r0, columns].mean(1) > _HALF
        row = low = box.r0
        while row > 0 and low - row < rail and not told[row - 1, columns].any():
            row -= 1
            low = row if is_open[row] else low
        whole = np.array([[low, box.c0, box.r1, box.c1]])
        if box.r0 - low >= least and framed(whole)[0]:
            worth = float(worth_of(evidence, (slice(low, box.r1), columns)).sum()) - PRICE
            box = CellBox(low, box.c0, box.r1, box.c1, worth)
        found.append(box)
    return found


def _between_bars(evidence: Evidence) -> Bool:
    """Returns the cells (h, w) that are open as seen over the gap between two bars of a grille.

    Beams must be so dense there that cells tell bars from gaps.
    """
    wide = max(_GAP / 2.0 / evidence.raster.cell, 1.0)
    dense = 4.0 * np.pi * wide**2 * evidence.expected_free >= BEAMS_TO_DECIDE
    return np.asarray(dense & (local_rate(evidence.llr, evidence.expected_free, wide) > 0))


def _meet(boxes: Int, part: Part) -> bool:
    """Returns whether any of the boxes (n, 4) r0, c0, r1, c1 has cells in a part."""
    rows, columns = part
    low, high = np.array([rows.start, columns.start]), np.array([rows.stop, columns.stop])
    return bool(((boxes[:, :2] < high) & (boxes[:, 2:] > low)).all(1).any())


def _components(
    evidence: Evidence, least: tuple[float, float], open_: Bool, where: Bool
) -> Iterator[tuple[Part, Bool]]:
    """Yields the bounding boxes of connected `open_` cells that can hold an opening, and others' cells there.

    Boxes without any of the cells `where` (h, w) are left out.

    Oversized components are joined only by shadows and gaps: they are opened (morphologically) with larger
    squares, which leave rectangles as they are, until they fall apart. A component that does not is an
    opening if it is a rectangle, as ribbon windows are, or if beams are seen to go through it, as through the
    panes of a shop. So is a rectangle that is lower or narrower than the next square, which would erase it.
    """
    llr = evidence.llr
    scales = (*_SCALES, (_SCALES[-1][0], np.inf), (_RIBBON, np.inf))
    for (size, largest), (following, _) in zip(scales, (*scales[1:], scales[-1]), strict=True):
        high, broad = (max(3, int(size * side)) for side in least)
        labels, _ = ndimage.label(opened(open_, (high, broad)))
        open_ = np.zeros(llr.shape, np.bool_)
        for number, (rows, columns) in enumerate(ndimage.find_objects(labels), 1):
            tall, wide = rows.stop - rows.start, columns.stop - columns.start
            own = labels[rows, columns] == number
            if largest < np.inf:
                exceeds = tall > largest * least[0] or wide > largest * least[1]
                is_large = exceeds and not _is_erased(own, following, least)
            else:
                is_large = own.mean() <= _FILLED and not _seen_through(evidence, (rows, columns), own)
            if is_large:
                open_[rows, columns] |= own
            elif tall + 2 >= least[0] and wide + 2 >= least[1]:
                part = _grown(rows), _grown(columns)
                if where[part].any():
                    yield part, (labels[part] != number) & (labels[part] > 0)


def _is_erased(own: Bool, size: float, least: tuple[float, float]) -> bool:
    """Returns whether a component (h, w) is a rectangle that squares of `size` least openings erase."""
    fits = all(cells >= int(size * side) for cells, side in zip(own.shape, least, strict=True))
    return not fits and float(own.mean()) > _FILLED


def _grown(cells: slice) -> slice:
    """Returns the cells with two more on each side."""
    return slice(max(cells.start - 2, 0), cells.stop + 2)


def _seen_through(evidence: Evidence, part: Part, own: Bool) -> bool:
    """Returns whether beams, and not only their absence, tell that the `own` cells of a part are open."""
    deep, expected = (float(m[part][own].sum()) for m in (evidence.deep, evidence.expected))
    return deep > _SEEN * expected


def _bars(open_: Bool, thick: int) -> Bool:
    """Returns the upright bars, at most `thick` cells wide, between open cells (h, w) that are equally high.

    Openings whose sills or lintels differ by more than a bar are several, however near they are. Lying bars
    are those of the transposed cells.
    """
    bars = ndimage.binary_closing(open_, np.ones((1, thick), np.bool_)) & ~open_
    whole = ndimage.binary_closing(open_, np.ones((thick, 1), np.bool_))  # without transoms
    labels, _ = ndimage.label(bars)
    for number, (rows, columns) in enumerate(ndimage.find_objects(labels), 1):
        middle = (rows.start + rows.stop) // 2
        sides = slice(max(columns.start - thick, 0), columns.start), slice(columns.stop, columns.stop + thick)
        left, right = (_run(np.any(whole[:, side], axis=1), middle) for side in sides)
        if max(abs(left[0] - right[0]), abs(left[1] - right[1])) > thick:
            bars[rows, columns] &= labels[rows, columns] != number
    return bars


def _run(cells: Bool, at: int) -> tuple[int, int]:
    """Returns the nearest cells (n,) below and above the cell `at` that are not set."""
    shut = np.flatnonzero(~cells)
    k = int(np.searchsorted(shut, at))
    return int(shut[k - 1]) if k else -1, int(shut[k]) if k < len(shut) else len(cells)


def _lines(part: Float, axis: int, reach: int, count: int) -> Int:
    """Returns the `count` borders along an axis where the evidence changes most over `reach` lines of cells.

    Changes are summed over bands of a quarter of the part each, so that a border of one window among several
    counts. The two ends of the part are returned as well.
    """
    lines = np.moveaxis(part, axis, 0)
    bands = max(1, min(4, lines.shape[1] // 8))
    ends = np.arange(bands + 1) * lines.shape[1] / bands
    parts = [lines[:, int(a) : int(np.ceil(b))] for a, b in pairwise(ends)]
    total = np.stack([part.sum(1) for part in parts] + [lines.sum(1) / bands], 1)
    sums = np.zeros((len(total) + 2 * reach + 1, bands + 1))
    sums[1 : reach + 1], sums[reach + 1 : -reach], sums[-reach:] = total[0], total, total[-1]
    sums = sums.cumsum(0)
    change = np.abs(sums[2 * reach :] - 2.0 * sums[reach:-reach] + sums[: -2 * reach])
    step = np.round(change[:, :-1].max(1) + change[:, -1], _DIGITS)
    peak = step >= ndimage.maximum_filter1d(step, 2 * reach + 1)
    ranked = sorted(np.flatnonzero(peak).tolist(), key=lambda k: (-step[k], k))[:count]
    return np.array(sorted({0, len(lines), *ranked}), np.int64)


def _rectangles(part: Float, due: Float, least: tuple[float, float], cell: float) -> tuple[Int, Float]:
    """Returns the rectangles (n, 4) r0, c0, r1, c1 between candidate borders that are worth their price.

    They come with their worth (n,), best first. Cells are `cell` m wide. A part that is longer than any
    opening holds several, and has as many more candidate borders.
    """
    reach = max(1, round(1.0 / np.sqrt(max(float(due.mean()), 1e-3))))
    counts = [int(_LINES * max(n * cell / MASONRY.largest_opening, 1.0)) for n in part.shape]
    r, c = (_lines(part, axis, reach, count) for axis, count in enumerate(counts))
    total = np.pad(part.cumsum(0).cumsum(1), ((1, 0), (1, 0)))[np.ix_(r, c)]
    i, j = np.triu_indices(len(r), 1)
    k, m = np.triu_indices(len(c), 1)
    keep, also = r[j] - r[i] >= least[0] - 0.5, c[m] - c[k] >= least[1] - 0.5
    i, j, k, m = i[keep], j[keep], k[also], m[also]
    band = total[j] - total[i]
    worth = np.round(band[:, m] - band[:, k] - PRICE, _DIGITS)
    a, b = np.nonzero(worth > 0)
    area = (r[j[a]] - r[i[a]]) * (c[m[b]] - c[k[b]])
    order = np.lexsort((b, a, area, -worth[a, b]))
    a, b = a[order], b[order]
    return np.column_stack([r[i[a]], c[k[b]], r[j[a]], c[m[b]]]), worth[a, b]
