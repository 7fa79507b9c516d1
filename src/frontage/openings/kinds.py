"""What an opening is, and its number: by size, height above the ground, and what the beams find behind it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.model.opening import Opening, OpeningKind

_LOW = 0.45  # m above the ground: doors and gates start below it, kerbs and a step included
_DOOR = 1.8  # m: doors are higher, and narrower than two leaves
_WIDE = 2.0  # m
_GLAZED = (1.5, 2.4)  # m: wider than a window's two leaves and higher than a door is glazing of a shop
_FLOOR = 2.0  # m above the ground: shop fronts start below it, plinths of sloping streets included
_RAISED = 1.0  # m above the ground: a floor that a few steps lead up to lies no higher
_PARAPET = 0.6  # m from the floor to the sills of windows, at least
_CELLAR = ((1.1, 0.9), (1.7, 0.6))  # m: top above the ground and height of basement windows, at most


def kind_of(width: float, height: float, sill: float, passes: float, stands: bool = False) -> OpeningKind:
    """ "window", "door", "shopfront", "garage", "passage" or "basement".

    width, height m; sill m above the ground; passes = share of the beams that end more than a metre behind;
    stands = steps or a balcony are before its foot. Doors are a person high, at the ground, on steps or on a
    balcony; gates are wider than two leaves; a passage lets beams through; shop fronts are wide and high on
    the ground floor; a basement window ends below the height of a sill.
    """
    if height >= _DOOR and width > _WIDE and sill <= _FLOOR:
        if sill > _LOW:
            return OpeningKind.SHOPFRONT
        return (
            OpeningKind.PASSAGE
            if passes > 0.7
            else OpeningKind.GARAGE
            if passes < 0.2
            else OpeningKind.SHOPFRONT
        )
    if width > _GLAZED[0] and height >= _GLAZED[1] and _LOW < sill <= _FLOOR and not stands:
        return OpeningKind.SHOPFRONT
    if height >= _DOOR and width <= _WIDE and (sill <= _LOW or stands):
        return OpeningKind.DOOR
    if any(sill + height <= top and height <= most for top, most in _CELLAR):
        return OpeningKind.BASEMENT
    return OpeningKind.WINDOW


def with_doors(openings: Sequence[Opening], ground: float) -> list[Opening]:
    """The openings, windows that reach down to the floor of the others beside them as doors; ground m.

    On sloping streets and behind hidden steps the foot of a door is higher than a kerb. What is as high and
    narrow as a door and begins a parapet below the sills of the windows beside it can be walked through.
    """
    windows = [o for o in openings if o.kind == OpeningKind.WINDOW]
    boxes = np.array([[*o.ring.min(0), *o.ring.max(0)] for o in windows]).reshape(-1, 4)
    doors: set[int] = set()
    for k, (x0, z0, x1, z1) in enumerate(boxes):
        if z1 - z0 < _DOOR or x1 - x0 > _WIDE or z0 > ground + _RAISED:
            continue
        common = np.minimum(boxes[:, 3], z1) - np.maximum(boxes[:, 1], z0)
        beside = (common > 0.5 * (boxes[:, 3] - boxes[:, 1])) & (np.arange(len(boxes)) != k)
        if beside.any() and float(np.median(boxes[beside, 1])) - z0 >= _PARAPET:
            doors.add(id(windows[k]))
    return [replace(o, kind=OpeningKind.DOOR) if id(o) in doors else o for o in openings]


def numbered(facade: str, openings: list[Opening]) -> tuple[Opening, ...]:
    """The openings by storey and from left to right, named "B07/F1/W3-2"; ground floor = 0, bays from 1.

    Storeys: openings sorted by their middle; a new one begins where an opening's foot is above the middle
    of the row so far. Basement windows are counted with the ground floor.
    """
    rows: list[list[Opening]] = []
    for o in sorted(openings, key=lambda o: (float(o.ring[:, 1].mean()), float(o.ring[:, 0].min()))):
        middle = np.median([q.ring[:, 1].mean() for q in rows[-1]]) if rows else -np.inf
        if not rows or (o.ring[:, 1].min() > middle and any(q.kind != "basement" for q in rows[-1])):
            rows.append([])
        rows[-1].append(o)
    named: list[Opening] = []
    for floor, row in enumerate(rows):
        for bay, o in enumerate(sorted(row, key=lambda o: float(o.ring[:, 0].min())), 1):
            letter = "W" if o.kind in (OpeningKind.WINDOW, OpeningKind.BASEMENT) else "D"
            named.append(replace(o, id=f"{facade}/{letter}{floor}-{bay}", floor=floor, bay=bay))
    return tuple(named)
