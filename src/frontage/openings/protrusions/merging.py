"""Joins pieces that are one: mouldings on a front, tiers of a cornice, steps, and half-hidden parts."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from frontage.model.masonry import MASONRY
from frontage.openings.boxes import Box
from frontage.openings.protrusions.beams import FacadeBeams
from frontage.openings.protrusions.pieces import Piece
from frontage.openings.protrusions.resolution import Resolution

_MOULDING = 0.2  # m by which mouldings on a front (sills, surrounds) stand out before it, at most
_WITHIN = 0.8  # share of a moulding that lies within the front
_LOW = 2.0  # times its height that a tier or a step is wide
_LEVEL = 0.6  # share of the longer one's side that parts of one piece have in common
_PASSING = 0.1  # share of the beams through a gap between two pieces from which they are not one
_WALL = 0.08  # m before the wall where beams that passed a shallow piece end at the earliest
_REVEAL = 0.5  # m behind a front: windows of oriels are less deep; what ends further in passed beside it


def merge_pieces(pieces: list[Piece], resolution: Resolution) -> list[Piece]:
    """Returns the pieces without those within others, and with tiers of one moulding or stair as one."""
    return _united(
        pieces,
        lambda piece, host: _part_of(piece, host, resolution),
        lambda piece, host: _joined(piece, host, resolution),
    )


def bridge_gaps(pieces: list[Piece], beams: FacadeBeams, resolution: Resolution) -> list[Piece]:
    """Joins pieces that are one protrusion, part of which something hides.

    They are level with one another and stand out equally far, and hardly any beam passes between them.
    """

    def is_next(piece: Piece, host: Piece) -> bool:
        """Returns whether a piece is the continuation of its host."""
        return _goes_on(host, piece, beams, resolution)

    def bridged(piece: Piece, host: Piece) -> Piece:
        """Returns both as one, with the front of the larger one."""
        larger = max(piece, host, key=lambda p: len(p.front_rows))
        joined = _joined(piece, host, resolution)
        return replace(joined, y=larger.y, front_rows=larger.front_rows)

    return _united(pieces, is_next, bridged)


def _united(
    pieces: list[Piece], is_one: Callable[[Piece, Piece], bool], join: Callable[[Piece, Piece], Piece]
) -> list[Piece]:
    """Joins pieces, beginning with the largest, until no two of them belong together."""
    out: list[Piece] = []
    todo = sorted(pieces, key=lambda p: -_area(p.box))
    while todo:
        piece = todo.pop(0)
        host = next((k for k, p in enumerate(out) if is_one(piece, p)), None)
        if host is None:
            out.append(piece)
        else:
            todo.insert(0, join(piece, out.pop(host)))
    return out


def _joined(piece: Piece, host: Piece, resolution: Resolution) -> Piece:
    """Returns a piece and its host as one: the larger front, of tiers the foremost."""
    a, b = piece.box, host.box
    ahead = piece if piece.y < host.y and _tier(a, b, resolution) else host
    box = (min(a[0], b[0]), min(a[1], b[1]), max(a[2], b[2]), max(a[3], b[3]))
    rows = np.concatenate([host.rows, piece.rows])
    return replace(ahead, rows=rows, box=box, inclined=host.inclined and piece.inclined)


def _goes_on(one: Piece, other: Piece, beams: FacadeBeams, resolution: Resolution) -> bool:
    """Returns whether two pieces beside or above each other are one that something hides in the middle."""
    if abs(one.y - other.y) > 2.0 * resolution.half:
        return False
    y = max(one.y, other.y)
    for axis in (0, 1):
        a, b = sorted((one.box, other.box), key=lambda box: box[axis])
        across = 1 - axis
        low, high = max(a[across], b[across]), min(a[across + 2], b[across + 2])
        level = high - low > _LEVEL * max(a[across + 2] - a[across], b[across + 2] - b[across])
        start, end = a[axis + 2] + resolution.spacing, b[axis] - resolution.spacing
        if not level or end <= start:
            continue
        gap = (start, low, end, high) if axis == 0 else (low, start, high, end)
        _, between = beams.at(y, gap, 0.0)
        seen = sum(len(beams.at(y, box, 0.0)[1]) for box in (a, b))
        due = seen * (end - start) / (a[axis + 2] - a[axis] + b[axis + 2] - b[axis])
        if (between > min(y + _REVEAL, -_WALL)).sum() < _PASSING * due:
            return True
    return False


def _part_of(piece: Piece, host: Piece, resolution: Resolution) -> bool:
    """Returns whether a piece is a moulding on the host's front, or a tier of the same moulding."""
    a, b = piece.box, host.box
    wide, high = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    inside = wide > 0 and high > 0 and wide * high > _WITHIN * _area(a)
    return (inside and piece.y > host.y - _MOULDING) or _tier(a, b, resolution)


def _tier(a: Box, b: Box, resolution: Resolution) -> bool:
    """Returns whether two long boxes with the same ends lie on top of each other."""
    ends = max(abs(a[0] - b[0]), abs(a[2] - b[2])) < 2.0 * resolution.gap
    apart = max(a[1], b[1]) - min(a[3], b[3])
    low = all(min(MASONRY.person, (c[2] - c[0]) / _LOW) > c[3] - c[1] for c in (a, b))
    return ends and apart < resolution.gap and low


def _area(box: Box) -> float:
    """Returns the area m2 of a box."""
    return (box[2] - box[0]) * (box[3] - box[1])
