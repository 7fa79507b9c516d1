"""Joins rectangles that only a bar parts, such as the handrail before a tall window.

The best layout may keep two rectangles apart by half a brick although most of what lies between them is open.
Between two openings there is wall, and no wall is thinner than half a brick.
"""

from collections.abc import Callable, Sequence
from itertools import permutations

import numpy as np

from frontage.geometry.arrays import Bool, Int
from frontage.model.masonry import MASONRY
from frontage.openings.layout.selection import PRICE, CellBox, worth_of
from frontage.openings.wall.evidence import Evidence

_ALIGNED = 2  # cells by which the jambs of two parts of one opening differ at most
_WIDEST = 2.0  # half bricks between two parts: the bar, and what it hides
_BAR = 0.75  # of half a brick, as cells show it: half a brick fills at least so much of whole cells


def rejoined(
    boxes: Sequence[CellBox], evidence: Evidence, held: Bool, framed: Callable[[Int], Bool]
) -> list[CellBox]:
    """Returns the boxes, of which those that only a bar parts are joined where they are `framed` together.

    `held` (h, w) are the cells of posts and strips of wall, which part openings however narrow they are.
    """
    left = list(boxes)
    for low, high in permutations(boxes, 2):
        if low in left and high in left and _is_parted_by_bar(low, high, evidence, held):
            whole = _joined(low, high, evidence)
            if framed(np.array([[whole.r0, whole.c0, whole.r1, whole.c1]]))[0]:
                left = [b for b in left if b not in (low, high)] + [whole]
    return left


def _is_parted_by_bar(low: CellBox, high: CellBox, evidence: Evidence, held: Bool) -> bool:
    """Returns whether two boxes lie one above the other with nothing between them but a bar."""
    cell = evidence.raster.cell
    gap = high.r0 - low.r1
    aligned = max(abs(low.c0 - high.c0), abs(low.c1 - high.c1)) <= _ALIGNED
    if not aligned or not 0 <= gap * cell <= _WIDEST * MASONRY.half_brick:
        return False
    between = slice(low.r1, high.r0), slice(max(low.c0, high.c0), min(low.c1, high.c1))
    wall = int((evidence.llr[between].sum(1) < 0.0).sum())
    return not held[between].any() and wall * cell < _BAR * MASONRY.half_brick


def _joined(low: CellBox, high: CellBox, evidence: Evidence) -> CellBox:
    """Returns the box around two boxes."""
    r0, c0, r1, c1 = low.r0, min(low.c0, high.c0), high.r1, max(low.c1, high.c1)
    worth = float(worth_of(evidence, (slice(r0, r1), slice(c0, c1))).sum()) - PRICE
    return CellBox(r0, c0, r1, c1, worth)
