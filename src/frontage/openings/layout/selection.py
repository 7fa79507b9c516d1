"""Chooses the best layout: of rectangles, or of anything that excludes one another, the set worth most."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import optimize, sparse

from frontage.geometry.arrays import Bool, Float, Int
from frontage.openings.wall.evidence import Evidence

PRICE = 12.0
"""Nats that an opening must be worth: four borders (minimum description length)."""
_UNSEEN = 0.1  # nats that a cell costs which nothing saw


@dataclass(frozen=True)
class CellBox:
    """The cells [r0, r1) x [c0, c1) and their worth in nats."""

    r0: int
    c0: int
    r1: int
    c1: int
    worth: float

    @property
    def cells(self) -> tuple[slice, slice]:
        """The slices that index maps."""
        return slice(self.r0, self.r1), slice(self.c0, self.c1)


def worth_of(evidence: Evidence, cells: tuple[slice, slice]) -> Float:
    """Returns the nats that cells add to what covers them: their evidence for open, less what hides them."""
    llr, expected, free = (m[cells] for m in (evidence.llr, evidence.expected, evidence.expected_free))
    known = np.where(llr == 0.0, 0.0, np.clip(expected / np.maximum(free, 1e-9), 0.0, 1.0))
    return llr - _UNSEEN * (1.0 - known)


def best_layout(groups: Sequence[Sequence[CellBox]], pier: int = 0) -> list[CellBox]:
    """Returns the subset of boxes without overlap with the largest worth, exactly (integer programme).

    At least `pier` cells lie between two boxes of one group. Groups by themselves are worth no less than
    together, so only groups whose layouts overlap are laid out together.
    """
    apart = [[_undominated(g)] for g in groups]
    layouts = _best(apart, pier)
    while (pair := _overlapping(layouts)) is not None:
        first, second = pair
        apart[first] += apart.pop(second)
        del layouts[second]
        layouts[first] = _best([apart[first]], pier)[0]
    return [b for layout in layouts for b in layout]


def most_worth(worth: Float, exclusive: Bool | sparse.csr_array) -> Int:
    """Returns the numbers of the set worth most, with at most one in each row of `exclusive` (k, n)."""
    if not exclusive.shape[0]:
        return np.flatnonzero(worth > 0.0)
    result = optimize.milp(
        -worth,
        integrality=np.ones(len(worth), np.int64),
        bounds=optimize.Bounds(0, 1),
        constraints=optimize.LinearConstraint(sparse.csr_array(exclusive.astype(float)), -np.inf, 1.0),
        options={"mip_rel_gap": 0.0},
    )
    return np.flatnonzero(np.asarray(result.x) > 0.5)


def best_apart(worth: Float, pairs: Int) -> Int:
    """Returns the numbers of the set worth most, of `worth` (n,), without both of any of the pairs (2, k).

    What is in no pair is in the set.
    """
    some = np.unique(pairs)
    exclusive = np.zeros((pairs.shape[1], len(some)), np.bool_)
    for numbers in np.searchsorted(some, pairs):
        exclusive[np.arange(len(exclusive)), numbers] = True
    free = np.setdiff1d(np.arange(len(worth)), some)
    return np.union1d(free, some[most_worth(worth[some], exclusive)]) if len(some) else free


def _undominated(boxes: Sequence[CellBox]) -> list[CellBox]:
    """Drops the boxes that contain another one that is worth as much, for that one fits wherever they do."""
    r0, c0, r1, c1, worth = np.array([(b.r0, b.c0, b.r1, b.c1, b.worth) for b in boxes]).reshape(-1, 5).T
    around = (r0[:, None] <= r0) & (c0[:, None] <= c0) & (r1[:, None] >= r1) & (c1[:, None] >= c1)
    worse = around & (worth[:, None] <= worth)
    worse &= ~(worse.T & np.tri(len(boxes), dtype=np.bool_).T)  # of equal ones the first stays
    return [boxes[k] for k in np.flatnonzero(~worse.any(axis=1)).tolist()]


def _best(sets: Sequence[Sequence[Sequence[CellBox]]], pier: int) -> list[list[CellBox]]:
    """Returns the best layout of the boxes of each set of groups, which may overlap.

    One programme solves all of them, for each takes longer to set up than to solve.
    """
    rivals = [_excluding(groups, pier) for groups in sets]
    boxes = [b for own, _ in rivals for b in own]
    if not boxes:
        return [[] for _ in sets]
    exclusive = sparse.block_diag([sparse.csr_array(rows) for _, rows in rivals], format="csr")
    chosen = set(most_worth(np.array([b.worth for b in boxes]), exclusive).tolist())
    number = iter(range(len(boxes)))
    return [[b for b in own if next(number) in chosen] for own, _ in rivals]


def _excluding(groups: Sequence[Sequence[CellBox]], pier: int) -> tuple[list[CellBox], Bool]:
    """Returns the boxes (n,) of all groups, and in each row (k, n) such as exclude one another."""
    boxes = [b for g in groups for b in g]
    if len(boxes) < 2:
        return boxes, np.empty((0, len(boxes)), np.bool_)
    owner = np.repeat(np.arange(len(groups)), [len(g) for g in groups])
    exclusive = [_shared_cells(boxes, owner == k, pier) for k in range(len(groups))]
    if len(groups) > 1:
        exclusive.append(_shared_cells(boxes, owner >= 0, 0))
    rows = np.vstack(exclusive)
    if rows.all(axis=1).any():  # each excludes all others
        return [max(boxes, key=lambda b: b.worth)], np.empty((0, 1), np.bool_)
    return boxes, rows


def _shared_cells(boxes: Sequence[CellBox], some: Bool, pier: int) -> Bool:
    """Returns which boxes (k, n) cover each cell of the arrangement of their borders that several cover.

    Only the boxes that are `some` count; they reach `pier` cells further up and right.
    """
    own = np.flatnonzero(some).tolist()
    starts = np.array([(boxes[k].r0, boxes[k].c0) for k in own]).reshape(-1, 2)
    ends = np.array([(boxes[k].r1, boxes[k].c1) for k in own]).reshape(-1, 2) + pier
    r, c = (np.unique([starts[:, k], ends[:, k]]) for k in range(2))
    cover = np.zeros((len(boxes), max(len(r) - 1, 0), max(len(c) - 1, 0)), np.bool_)
    for n, start, end in zip(own, starts, ends, strict=True):
        rows, columns = (np.searchsorted(v, (start[k], end[k])) for k, v in enumerate((r, c)))
        cover[n, rows[0] : rows[1], columns[0] : columns[1]] = True
    cells = np.unique(cover.reshape(len(boxes), -1), axis=1).T
    return np.asarray(cells[cells.sum(1) > 1], np.bool_)


def _overlapping(layouts: Sequence[Sequence[CellBox]]) -> tuple[int, int] | None:
    """Returns two layouts, the lower number first, whose boxes overlap; None if there are none."""
    owner = np.repeat(np.arange(len(layouts)), [len(own) for own in layouts])
    r0, c0, r1, c1 = np.array([(b.r0, b.c0, b.r1, b.c1) for own in layouts for b in own]).reshape(-1, 4).T
    meet = (r0[:, None] < r1) & (r1[:, None] > r0) & (c0[:, None] < c1) & (c1[:, None] > c0)
    first, second = np.nonzero(meet & (owner[:, None] < owner))
    return (int(owner[first[0]]), int(owner[second[0]])) if len(first) else None
