"""Like openings are divided alike: a bar within one of them is wall in all of them or in none.

Whether a mullion of two windows side by side, or a transom of two above one another, counts as wall is a
narrow decision where it is as wide as a bar. Which points a cloud happens to have then decides for each
opening by itself, so that equal windows come out as one here and as two there. Builders made them alike, so
the evidence at the bars of all of them together decides for each.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binom

from frontage.geometry.arrays import Bool, Float
from frontage.model.masonry import MASONRY
from frontage.openings.boxes import Box
from frontage.openings.layout.densities import Place, row_by_row
from frontage.openings.wall.evidence import Evidence

_CHANCE = 0.01  # that as many like places agree by chance, at most
_BESIDE = 0.5  # share of the height of the higher one by which two places stand beside one another
_ACROSS, _UPRIGHT = (0, 1, 2, 3), (1, 0, 3, 2)  # order of a box's numbers: side by side, above one another


@dataclass(frozen=True, eq=False)
class _Form:
    """Openings as wide as one another, some of them divided by a bar.

    pairs  numbers of the two places on both sides of a bar
    whole  numbers of the places as wide as both of a pair
    bar    m from the middle, where the bar begins and ends
    """

    pairs: list[tuple[int, int]]
    whole: list[int]
    bar: tuple[float, float]


def divided_alike(places: Sequence[Place]) -> list[Place]:
    """Returns the places row by row; those that are alike are all divided, or all of them are whole.

    Two places with a bar between them are like one that is as wide as both together. The nats of all of them,
    divided and whole, tell whether they are divided; what nearly all of them are must agree with that.
    """
    found = list(places)
    for order in (_ACROSS, _UPRIGHT):
        found = _along(found, order)
    return row_by_row(found)


def _along(places: list[Place], order: tuple[int, ...]) -> list[Place]:
    """Divides like places alike across one axis, and returns all places.

    The forms that most places have are decided first. Pairs and whole places that an earlier form has left
    as they are stay so, and tell later forms what is like them. A place of a pair may be a whole place of a
    narrower form.
    """
    divided, whole, gone, added = set[int](), set[int](), set[int](), list[Place]()
    for form in sorted(_forms(places, order), key=lambda f: -len(f.pairs) - len(f.whole)):
        pairs = [pair for pair in form.pairs if gone.isdisjoint(pair)]
        alike = [k for k in form.whole if k not in gone]
        if not pairs or not alike:
            continue
        halves = {k for pair in pairs for k in pair}
        joined = [_joined(places[a], places[b], order) for a, b in pairs]
        parts = [part for k in alike for part in _parted(places[k], form.bar, order)]
        as_whole = sum(p.worth for p in joined) + sum(_worth(places[k]) for k in alike)
        as_parts = sum(_worth(places[k]) for k in halves) + sum(p.worth for p in parts)
        if not _is_told(as_whole - as_parts, len(alike), len(pairs)):
            continue
        if as_whole > as_parts and divided.isdisjoint(halves):
            whole.update(alike)
            gone.update(halves)
            added += joined
        elif as_whole <= as_parts and whole.isdisjoint(alike):
            divided.update(halves)
            gone.update(alike)
            added += [part for part in parts if part.worth > 0.0]
    return [p for k, p in enumerate(places) if k not in gone] + added


def _is_told(nats: float, whole: int, divided: int) -> bool:
    """Returns whether like places tell how they are divided.

    Nearly all of them agree with the `nats` for whole ones: so many that chance would do it once in a
    hundred cases.
    """
    most, less = (whole, divided) if nats > 0.0 else (divided, whole)
    return bool(binom.sf(most - 1, most + less, 0.5) < _CHANCE)


def _forms(places: Sequence[Place], order: tuple[int, ...]) -> list[_Form]:
    """Returns the forms that are divided in some places and whole in others; heights do not matter.

    The form that most pairs have comes first, and takes them. Of forms that as many pairs have, the wider one
    does, and of those the one whose pair is worth more, so that left and right decide nothing.
    """
    boxes = np.array([p.box for p in places]).reshape(-1, 4)[:, order]
    near = np.array([p.slack for p in places])
    pairs = np.argwhere(_are_pairs(boxes, near))
    first, second = boxes[pairs.T]
    width, middle = second[:, 2] - first[:, 0], (second[:, 2] + first[:, 0]) / 2.0
    bar = np.column_stack([first[:, 2], second[:, 0]]) - middle[:, None]
    shape, slack = np.column_stack([width, bar.mean(1)]), near[pairs].max(1)
    alike = np.abs(shape[:, None] - shape).max(2) <= np.maximum(slack, slack[:, None])
    worth = np.array([p.worth for p in places])[pairs].sum(1)
    found, left = list[_Form](), np.ones(len(pairs), np.bool_)
    for n in np.lexsort((-worth, -width.round(6), -alike.sum(1))).tolist():
        own = left & alike[n]
        whole = np.flatnonzero(np.abs(np.ptp(boxes[:, ::2], axis=1) - width[n]) <= slack[n])
        if left[n] and len(whole):
            begin, end = np.median(bar[own], axis=0).tolist()
            found.append(_Form(_apart(pairs[own].tolist()), whole.tolist(), (begin, end)))
        if left[n]:
            left &= ~own
    return found


def _are_pairs(boxes: Float, near: Float) -> Bool:
    """Returns in row i and column k (n, n) whether box k lies right of box i with at most a bar between them.

    Of the height of the higher one, more than half lies beside the other. The borders of the boxes (n, 4) may
    be off by `near` (n,) m.
    """
    near = np.maximum(near, near[:, None])
    x0, z0, x1, z1 = boxes.T
    gap = x0 - x1[:, None]
    both = np.minimum(z1, z1[:, None]) - np.maximum(z0, z0[:, None])
    beside = both > _BESIDE * np.maximum(z1 - z0, (z1 - z0)[:, None])
    return np.asarray(beside & (gap >= -near) & (gap <= MASONRY.half_brick + 2.0 * near))


def _apart(pairs: Sequence[Sequence[int]]) -> list[tuple[int, int]]:
    """Returns pairs that have no place in common.

    A row of places falls into the same pairs from either end, or into none: three places make no pair.
    """
    return sorted(_taken(pairs) & _taken(pairs[::-1]))


def _taken(pairs: Iterable[Sequence[int]]) -> set[tuple[int, int]]:
    """Returns pairs that have no place in common, the first ones first."""
    found, taken = set[tuple[int, int]](), set[int]()
    for a, b in pairs:
        if taken.isdisjoint((a, b)):
            found.add((a, b))
            taken.update((a, b))
    return found


def _joined(a: Place, b: Place, order: tuple[int, ...]) -> Place:
    """Returns the place that covers two; its foot and head are those of either one, as it is worth most."""
    one, other = (np.array(p.box)[list(order)].tolist() for p in (a, b))
    ends = [(low, high) for low in (one[1], other[1]) for high in (one[3], other[3])]
    finer = min(a.evidence, b.evidence, key=lambda e: e.raster.cell)
    trials = [_place((one[0], low, other[2], high), order, finer) for low, high in ends]
    return max(trials, key=lambda p: (p.worth, p.box[3] - p.box[1]))  # of equal ones the highest


def _parted(place: Place, bar: tuple[float, float], order: tuple[int, ...]) -> list[Place]:
    """Returns the two places on both sides of the bar."""
    x0, z0, x1, z1 = np.array(place.box)[list(order)].tolist()
    middle = (x0 + x1) / 2.0
    boxes = [(x0, z0, middle + bar[0], z1), (middle + bar[1], z0, x1, z1)]
    return [_place(box, order, place.evidence) for box in boxes]


def _place(numbers: Box, order: tuple[int, ...], evidence: Evidence) -> Place:
    """Returns the place of a box, whose numbers are ordered along an axis, with its worth."""
    x0, z0, x1, z1 = (numbers[k] for k in order)
    return Place.of((x0, z0, x1, z1), evidence)


def _worth(place: Place) -> float:
    """Returns the nats that a place is worth on the raster that it was found on."""
    return Place.of(place.box, place.evidence).worth
