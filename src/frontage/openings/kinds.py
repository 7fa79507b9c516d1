"""What an opening is, and its number: by size, height above the ground, and what the beams find behind it."""

from dataclasses import replace

import numpy as np

from frontage.model.opening import Opening

_SILL = 0.45  # m above the ground: doors and gates start below it, kerbs and steps included


def kind_of(width: float, height: float, sill: float, passes: float) -> str:
    """ "window", "door", "shopfront", "garage", "passage" or "basement".

    width, height m; sill m above the ground; passes = share of the beams that end more than a metre behind.
    Doors are a person high and at the ground, gates wider than two leaves; a passage lets beams through;
    a basement window ends below the height of a sill.
    """
    if sill <= _SILL and height >= 1.8:
        if width > 2.0 and passes > 0.7:
            return "passage"
        if width > 2.0:
            return "garage" if passes < 0.2 else "shopfront"
        return "door"
    if sill + height <= 1.1 and height <= 0.9:
        return "basement"
    return "shopfront" if sill <= 1.0 and width > 2.0 and height > 1.4 else "window"


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
            letter = "W" if o.kind in ("window", "basement") else "D"
            named.append(replace(o, id=f"{facade}/{letter}{floor}-{bay}", floor=floor, bay=bay))
    return tuple(named)
