"""The kind of an opening: by size, height above the ground, and how many beams go through it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.model.masonry import MASONRY
from frontage.model.opening import Opening, OpeningKind

_LOW = 0.45  # m above the ground: doors and gates start below it, kerb and step included
_WIDE = 2.0  # m: doors are narrower than two leaves
# m, width and height: wider than the two leaves of a window and higher than a door is shop glazing
_GLAZED = (1.5, 2.4)
_FLOOR = 2.0  # m above the ground: shop fronts start below it, plinths on sloping streets included
_RAISED = 1.0  # m above the ground: a floor that a few steps lead up to lies no higher
_PARAPET = 0.6  # m from the floor to the sills of windows, at least
# m: height of the top above the ground, and height, of basement windows, at most (either pair)
_CELLAR = ((1.1, 0.9), (1.7, 0.6))


def kind_of(width: float, height: float, sill: float, passes: float, on_steps: bool = False) -> OpeningKind:
    """Returns "window", "door", "shopfront", "garage", "passage" or "basement".

    width, height   m
    sill            m, height of the lower border above the ground
    passes          share of the beams that end more than a metre behind the wall
    on_steps        whether steps or a balcony stand before the foot of the opening

    A door is as high as a person and stands on the ground, on steps or on a balcony. A gate is wider than two
    leaves; a passage lets beams through. Shop fronts are wide and high, on the ground floor. A basement
    window ends below the height of a sill.
    """
    if height >= MASONRY.door_height and width > _WIDE and sill <= _FLOOR:
        if sill > _LOW:
            return OpeningKind.SHOPFRONT
        if passes > 0.7:
            return OpeningKind.PASSAGE
        return OpeningKind.GARAGE if passes < 0.2 else OpeningKind.SHOPFRONT
    if width > _GLAZED[0] and height >= _GLAZED[1] and _LOW < sill <= _FLOOR and not on_steps:
        return OpeningKind.SHOPFRONT
    if height >= MASONRY.door_height and width <= _WIDE and (sill <= _LOW or on_steps):
        return OpeningKind.DOOR
    if any(sill + height <= top and height <= most for top, most in _CELLAR):
        return OpeningKind.BASEMENT
    return OpeningKind.WINDOW


def with_doors(openings: Sequence[Opening], ground: float) -> list[Opening]:
    """Returns the openings, with windows that reach down to the floor of those beside them as doors.

    `ground` is the height z m of the ground. On sloping streets and behind hidden steps the foot of a door is
    higher than a kerb. An opening as high and narrow as a door that begins a parapet below the sills of the
    windows beside it can be walked through.
    """
    windows = [o for o in openings if o.kind == OpeningKind.WINDOW]
    boxes = np.array([[*o.ring.min(0), *o.ring.max(0)] for o in windows]).reshape(-1, 4)
    doors: set[int] = set()
    for k, (x0, z0, x1, z1) in enumerate(boxes):
        if z1 - z0 < MASONRY.door_height or x1 - x0 > _WIDE or z0 > ground + _RAISED:
            continue
        common = np.minimum(boxes[:, 3], z1) - np.maximum(boxes[:, 1], z0)
        beside = (common > 0.5 * (boxes[:, 3] - boxes[:, 1])) & (np.arange(len(boxes)) != k)
        if beside.any() and float(np.median(boxes[beside, 1])) - z0 >= _PARAPET:
            doors.add(id(windows[k]))
    return [replace(o, kind=OpeningKind.DOOR) if id(o) in doors else o for o in openings]


def in_reading_order(openings: Sequence[Opening]) -> tuple[Opening, ...]:
    """Returns the openings storey by storey from the lowest, and from left to right within each storey.

    Storeys: the openings are sorted by their middles; a new storey begins where the foot of an opening lies
    above the median middle of the storey so far. Basement windows are sorted with the ground floor.
    """
    rows: list[list[Opening]] = []
    for o in sorted(openings, key=lambda o: (float(o.ring[:, 1].mean()), float(o.ring[:, 0].min()))):
        middle = np.median([q.ring[:, 1].mean() for q in rows[-1]]) if rows else -np.inf
        if not rows or (
            o.ring[:, 1].min() > middle and any(q.kind != OpeningKind.BASEMENT for q in rows[-1])
        ):
            rows.append([])
        rows[-1].append(o)
    return tuple(o for row in rows for o in sorted(row, key=lambda o: float(o.ring[:, 0].min())))
