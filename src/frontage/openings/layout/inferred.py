"""Predicts openings that nothing saw, where the rows and columns of the others say that there is one.

A row of like openings and a column of openings cross at a node. What stands at a node is predicted from the
others: its middle from the column, its sill from the row, its size and depth from its like. The facade itself
shows how often that is right, node by node: each opening that was measured is predicted without itself, and
each node where the wall is seen counts as wrong.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float
from frontage.model.estimate import Estimate, Provenance
from frontage.openings.borders.outline import Outline
from frontage.openings.boxes import Box
from frontage.openings.layout.forms import is_known
from frontage.openings.layout.groups import (
    HEIGHT,
    MIDDLE,
    WIDTH,
    between_members,
    columns_of,
    equally_high,
    levels_of,
    like_groups,
    predicted,
    rows_of,
    values_of,
)
from frontage.openings.wall.evidence import VISIBLE, Evidence

_RIGHT = 0.9  # share of the predictions that must be right
_OTHERS = (2, 1)  # openings of a row, and of a column, that a prediction needs
_WALL = -6.0  # nats over a place below which the wall was seen
SAME = 0.5
"""Intersection over union of a prediction that counts as right, and of two openings that are the same."""
CLEAR = 0.1
"""m between openings, at least."""
WITHIN = 0.98
"""Share of an opening that lies within the facade's outline."""
SEEN = ("wall", "other")
"""States of a free place that beams came back from."""


@dataclass(frozen=True, eq=False)
class Inferred:
    """A predicted opening, the share of such predictions that are right, and its evidence in nats."""

    outline: Outline
    confidence: float
    evidence: float


@dataclass(frozen=True, eq=False)
class Node:
    """What the row `row` and the column `column` predict where they cross.

    place       box m
    covariance  (5, 5) m2 of left, right, bottom, top and rise
    like        number of an opening of the same form
    same        whether the column holds openings of that form
    """

    place: Box
    covariance: Float
    like: int
    row: int
    column: int
    same: bool


def infer(outlines: Sequence[Outline], evidence: Evidence) -> list[Inferred]:
    """Returns the openings that rows and columns predict where nothing saw the wall.

    There are none where the facade is not regular enough for nine of ten to be right.
    """
    if len(outlines) <= sum(_OTHERS):
        return []
    grid = OpeningGrid(outlines)
    told = [(node, state_of(node.place, outlines, evidence)) for node in grid.nodes()]
    right = {(n.row, n.column): True for n in grid.left_out()}
    right |= {(n.row, n.column): False for n, state in told if state == "wall"}
    found: list[Inferred] = []
    overall = rate_of(right, None, None)
    for node, state in told:
        if state != "unknown":
            continue
        rates = [
            overall,
            rate_of(right, node.row, None),
            rate_of(right, None, node.column),
        ]
        if min(rates) < _RIGHT:
            continue
        if is_near(node.place, [f.outline.place for f in found]):
            continue
        like = outlines[node.like]
        depth = grid.depth(node.like)
        outline = Outline(
            like.shape, node.place, like.rise, node.covariance, (), depth, like.passes, like.wall
        )
        found.append(Inferred(outline, rates[0], worth_at(node.place, evidence)))
    return found


def rate_of(right: dict[tuple[int, int], bool], row: int | None, column: int | None) -> float:
    """Returns the expected share of right predictions (Jeffreys); of a row or a column its own share."""
    some = [v for (r, c), v in right.items() if row in (None, r) and column in (None, c)]
    if row is None and column is None:
        return (sum(some) + 0.5) / (len(some) + 1.0)
    return sum(some) / len(some) if some else 1.0


class OpeningGrid:
    """Rows of like openings and columns of all openings, and what they predict."""

    def __init__(self, outlines: Sequence[Outline], like: Sequence[tuple[int, ...]] | None = None) -> None:
        """`like` are the groups of like openings, by default those that agree within their errors.

        With groups that are given, a single opening makes a column.
        """
        single = like is not None
        self._outlines = outlines
        self._own, variance = values_of(outlines)
        self._sigma = {
            name: np.sqrt([share @ v @ share for v in variance])
            for name, share in (("x", MIDDLE), ("w", WIDTH), ("h", HEIGHT))
        }
        like = like_groups(outlines) if like is None else like
        self._like = {k: group for group in like for k in group}
        high = equally_high(outlines, like)
        self._high = {k: group for group in high for k in group}
        self._level, self._sigma["z"] = levels_of(self._own, variance, high)
        upright = {k for k, o in enumerate(outlines) if is_known(o)[2:].all()}
        self._rows = [row for row in rows_of(self._level, high) if not upright.isdisjoint(row)]
        self._columns = columns_of(outlines, [tuple(range(len(outlines)))])
        if single:
            self._columns += [(k,) for k in range(len(outlines)) if not any(k in c for c in self._columns)]
        self._between = {
            "x": between_members(self._own @ MIDDLE, self._sigma["x"], self._columns),
            "z": between_members(self._level, self._sigma["z"], self._rows),
            "w": between_members(self._own @ WIDTH, self._sigma["w"], like),
            "h": between_members(self._own @ HEIGHT, self._sigma["h"], high),
        }

    def nodes(self, vague: Collection[int] = ()) -> list[Node]:
        """Returns the nodes of all rows and columns that have no opening in common but a `vague` one.

        What a vague opening says of its own node is left out.
        """
        found = []
        for r, row in enumerate(self._rows):
            for c, column in enumerate(self._columns):
                both = set(row) & set(column)
                if both <= set(vague) and len(both) < 2:
                    found.append(self._node(r, c, min(both, default=-1)))
        return [node for node in found if node is not None]

    def left_out(self) -> list[Node]:
        """Returns the nodes of measured openings that are predicted right without them."""
        found = []
        for r, row in enumerate(self._rows):
            for c, column in enumerate(self._columns):
                for k in set(row) & set(column):
                    node = self._node(r, c, k)
                    if node is not None and iou_of(node.place, self._outlines[k].place) >= SAME:
                        found.append(node)
        return found

    def _node(self, r: int, c: int, without: int) -> Node | None:
        """Returns what row r and column c predict without one opening; None where too few determine it.

        The row tells sill and height. The column tells the width if it has openings that are equally high;
        otherwise it is that of most openings of the row.
        """
        row = [k for k in self._rows[r] if k != without]
        column = [k for k in self._columns[c] if k != without]
        if len(row) < _OTHERS[0] or len(column) < _OTHERS[1]:
            return None
        equal = [k for k in self._high[row[0]] if k != without]
        forms = [self._like[k] for k in column if k in equal] or [self._like[k] for k in row]
        most = max(forms, key=lambda form: (forms.count(form), len(form)))  # of two as frequent the larger
        like = [k for k in most if k != without]
        same = [k for k in column if k in like]
        near = same or column
        told = {
            name: predicted(value, self._sigma[name], members, self._between[name])
            for name, value, members in (
                ("x", self._own @ MIDDLE, near),
                ("z", self._level, row),
                ("w", self._own @ WIDTH, like),
                ("h", self._own @ HEIGHT, equal),
            )
        }
        (x, dx), (z, dz), (w, dw), (h, dh) = (told[name] for name in "xzwh")
        covariance = np.zeros((5, 5))
        covariance[:2, :2] = dx**2 + dw**2 / 4.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
        covariance[2:4, 2:4] = dz**2 + np.diag([0.0, dh**2])
        covariance[4, 4] = self._outlines[like[0]].covariance[4, 4]
        place = (x - w / 2, z, x + w / 2, z + h)
        return Node(place, covariance, like[0], r, c, bool(same))

    def fellows(self, node: Node) -> tuple[int, ...]:
        """Returns the numbers of the openings of the form that a node predicts."""
        return self._like[node.like]

    def depth(self, like: int) -> Estimate[float] | None:
        """Returns the depth of a further opening like number `like`; None where too few determine it."""
        known = [d for k in self._like[like] if (d := self._outlines[k].depth) is not None]
        if len(known) < _OTHERS[0]:
            return None
        value = np.array([d.value for d in known])
        sigma = np.array([float(d.sigma[0]) for d in known])
        between = between_members(value, sigma, [tuple(range(len(known)))])
        at, error = predicted(value, sigma, range(len(known)), between)
        return Estimate(at, np.array([[error**2]]), float(len(known) - 1), Provenance.INFERRED)


def state_of(place: Box, outlines: Sequence[Outline], evidence: Evidence) -> str:
    """Returns what is known of a place: "taken", "off" the facade, "wall", "unknown", or "other".

    "other" means that beams came back from it and that it is not wall.
    """
    if is_near(place, [o.place for o in outlines]):
        return "taken"
    part = cells_of(place, evidence)
    if part is None or evidence.inside[part].mean() < WITHIN:
        return "off"
    if float(evidence.llr[part].sum()) < _WALL:
        return "wall"
    due = float(evidence.expected_free[part].sum())
    hidden = float(evidence.expected[part].sum()) < VISIBLE * due or due == 0.0
    return "unknown" if hidden else "other"


def worth_at(place: Box, evidence: Evidence) -> float:
    """Returns the nats for open over a place."""
    part = cells_of(place, evidence)
    return 0.0 if part is None else float(evidence.llr[part].sum())


def cells_of(place: Box, evidence: Evidence) -> tuple[slice, slice] | None:
    """Returns the cells of a place, None where it leaves the raster."""
    g, (cx, cz) = evidence.raster.cell, evidence.raster.corner
    c0, r0, c1, r1 = (round((v - o) / g) for v, o in zip(place, (cx, cz, cx, cz), strict=True))
    h, w = evidence.raster.shape
    return (slice(r0, r1), slice(c0, c1)) if 0 <= r0 < r1 <= h and 0 <= c0 < c1 <= w else None


def is_near(place: Box, others: Sequence[Box]) -> bool:
    """Returns whether a box overlaps one of the others or stands too close to it."""
    return bool(near_ones(place, np.reshape(others, (-1, 4))).any())


def near_ones(place: Box, boxes: Float) -> Bool:
    """Returns which boxes (n, 4) m a box overlaps or stands too close to."""
    own = np.array(place)
    gap = np.maximum(np.maximum(boxes[:, :2] - own[2:], own[:2] - boxes[:, 2:]), 0.0)
    return np.asarray(np.hypot(*gap.T) < CLEAR)


def iou_of(a: Box, b: Box) -> float:
    """Returns the intersection over union of two boxes."""
    one, other = shapely.box(*a), shapely.box(*b)
    return float(one.intersection(other).area / one.union(other).area)
