"""Rectangles that may be openings, and the best layout of those that do not overlap."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy import ndimage, optimize, sparse

from frontage.geometry.arrays import Bool, Float, Int
from frontage.openings.evidence import Evidence
from frontage.openings.options import OpeningOptions

_PRICE = 12.0  # nats an opening must be worth: four borders (MDL)
_LINES = 8  # candidate borders a component has in each direction, at most
_KEPT = 80  # rectangles of a component that go into the layout
_TRIED = 400  # rectangles that are looked at for those
_UNSEEN = 0.05  # nats a cell of nothing known costs
_SCALES = ((0.6, 12.0), (1.0, 12.0), (1.7, 12.0), (2.5, 25.0))  # least openings: square, largest part
_SMOOTH = 1.0  # cells, one sigma before components are formed


@dataclass(frozen=True)
class Box:
    """Cells [r0, r1) x [c0, c1) and their worth in nats."""

    r0: int
    c0: int
    r1: int
    c1: int
    worth: float

    @property
    def cells(self) -> tuple[slice, slice]:
        """To index maps with."""
        return slice(self.r0, self.r1), slice(self.c0, self.c1)


def find_boxes(evidence: Evidence, options: OpeningOptions, framed: Callable[[Box, bool], bool]) -> list[Box]:
    """The set of rectangles without overlap that is worth most, by components of open cells.

    A rectangle is worth the evidence of its cells less the price of an opening; its borders are lines where
    the evidence of a component changes most. Two windows and their pier compete with the window over both.
    Only `framed` rectangles are openings; where the best layout has others, the best of those that are framed
    on all sides (its second argument) counts instead.
    """
    worth = np.where(evidence.llr == 0.0, -_UNSEEN, evidence.llr)
    least = (options.min_height / evidence.raster.cell, options.min_width / evidence.raster.cell)
    found: list[Box] = []
    for rows, columns in _components(evidence.llr, least):
        boxes = [
            Box(b.r0 + rows.start, b.c0 + columns.start, b.r1 + rows.start, b.c1 + columns.start, b.worth)
            for b in _rectangles(worth[rows, columns], least)
        ]
        chosen = best_layout(boxes[:_KEPT])
        if not all(framed(b, False) for b in chosen):
            chosen = best_layout([b for b in boxes if framed(b, True)][:_KEPT])
        found += chosen
    return found


def _components(llr: Float, least: tuple[float, float]) -> Iterator[tuple[slice, slice]]:
    """Bounding boxes of connected open cells that can hold an opening.

    What is larger than openings are hangs together by shadows and gaps: it is opened with larger squares,
    which leave rectangles as they are, until it falls apart.
    """
    open_: Bool = ndimage.gaussian_filter(llr, _SMOOTH, mode="constant") > 0
    for size, largest in _SCALES:
        kernel = np.ones([max(3, int(size * side)) for side in least], bool)
        labels, _ = ndimage.label(ndimage.binary_opening(open_, kernel))
        open_ = np.zeros(llr.shape, np.bool_)
        for number, (rows, columns) in enumerate(ndimage.find_objects(labels), 1):
            tall, wide = rows.stop - rows.start, columns.stop - columns.start
            if tall > largest * least[0] or wide > largest * least[1]:
                open_[rows, columns] |= labels[rows, columns] == number
            elif tall + 2 >= least[0] and wide + 2 >= least[1]:
                yield (
                    slice(max(rows.start - 2, 0), min(rows.stop + 2, llr.shape[0])),
                    slice(max(columns.start - 2, 0), min(columns.stop + 2, llr.shape[1])),
                )


def _lines(part: Float, axis: int) -> Int:
    """Borders (k,) along an axis: the largest changes of the evidence from one line of cells to the next.

    Change is summed over the bands of a quarter of the part each, so that a border of one window among
    several counts.
    """
    lines = np.moveaxis(part, axis, 0)
    bands = max(1, min(4, lines.shape[1] // 8))
    total = np.stack([b.sum(1) for b in np.array_split(lines, bands, axis=1)], 1)
    step = np.abs(np.diff(total, axis=0, prepend=0.0, append=0.0)).max(1)
    step = step + np.abs(np.diff(lines.sum(1), prepend=0.0, append=0.0)) / bands
    peak = step >= ndimage.maximum_filter1d(step, 3)
    ranked = sorted(np.flatnonzero(peak).tolist(), key=lambda k: (-step[k], k))[:_LINES]
    return np.array(sorted({0, len(lines), *ranked}), np.int64)


def _rectangles(part: Float, least: tuple[float, float]) -> list[Box]:
    """The rectangles between candidate borders that are worth more than their price, best first."""
    r, c = _lines(part, 0), _lines(part, 1)
    total = np.pad(part.cumsum(0).cumsum(1), ((1, 0), (1, 0)))[np.ix_(r, c)]
    i, j = np.triu_indices(len(r), 1)
    k, m = np.triu_indices(len(c), 1)
    keep, also = r[j] - r[i] >= least[0] - 0.5, c[m] - c[k] >= least[1] - 0.5
    i, j, k, m = i[keep], j[keep], k[also], m[also]
    band = total[j] - total[i]
    worth = band[:, m] - band[:, k] - _PRICE
    a, b = np.nonzero(worth > 0)
    order = np.lexsort((b, a, -worth[a, b]))[:_TRIED]
    return [
        Box(int(r[i[p]]), int(c[k[q]]), int(r[j[p]]), int(c[m[q]]), float(worth[p, q]))
        for p, q in zip(a[order], b[order], strict=True)
    ]


def best_layout(boxes: list[Box]) -> list[Box]:
    """The subset of boxes without overlap with the largest worth, exactly (integer programme).

    Constraints: every cell of the arrangement of all borders lies in at most one chosen box.
    """
    if len(boxes) < 2:
        return boxes
    r = np.unique([v for b in boxes for v in (b.r0, b.r1)])
    c = np.unique([v for b in boxes for v in (b.c0, b.c1)])
    cover = np.zeros((len(boxes), len(r) - 1, len(c) - 1), bool)
    for n, b in enumerate(boxes):
        rows, columns = np.searchsorted(r, [b.r0, b.r1]), np.searchsorted(c, [b.c0, b.c1])
        cover[n, rows[0] : rows[1], columns[0] : columns[1]] = True
    cells = np.unique(cover.reshape(len(boxes), -1), axis=1).T
    cells = cells[cells.sum(1) > 1]
    if len(cells) == 0:
        return boxes
    result = optimize.milp(
        -np.array([b.worth for b in boxes]),
        integrality=np.ones(len(boxes), np.int64),
        bounds=optimize.Bounds(0, 1),
        constraints=optimize.LinearConstraint(sparse.csr_array(cells.astype(float)), -np.inf, 1.0),
    )
    return [b for b, chosen in zip(boxes, np.asarray(result.x), strict=True) if chosen > 0.5]
